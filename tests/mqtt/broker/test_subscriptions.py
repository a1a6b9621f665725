"""What the tree of filters keeps, and retained messages against the plain rule."""

from hypothesis import given
from hypothesis import strategies as st
from tests.mqtt.broker.conftest import owed

from homebot.clock import ManualClock
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.retained import RetainedMessages
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.session_subscription import SessionSubscription
from homebot.mqtt.broker.stats import Counters
from homebot.mqtt.broker.subscriptions import SubscriptionTree
from homebot.mqtt.topics import topic_matches
from homebot.support.turn_budget import TurnBudget

LEVEL = st.sampled_from(["a", "b", "", "$s", "*.x", "b\n"])
TOPIC = st.lists(LEVEL, min_size=1, max_size=4).map("/".join).filter(bool)
FILTER = (
    st.tuples(st.lists(LEVEL | st.just("+"), max_size=4), st.sampled_from([[], ["#"]]))
    .map(lambda parts: "/".join(parts[0] + parts[1]))
    .filter(bool)
)


def new_session() -> BrokerSession:
    clock = ManualClock()
    return BrokerSession("c", clock, BrokerLimits(), Counters(), TurnBudget(clock.monotonic, lambda _: None))


def test_an_emptied_tree_keeps_nothing() -> None:
    tree, session = SubscriptionTree(), new_session()
    for name in ("a/b/c", "a/+/c", "#"):
        tree.add(session, SessionSubscription(name, name, 0))
    for name in ("a/b/c", "a/+/c", "#"):
        tree.remove(session, SessionSubscription(name, name, 0))
    assert tree.levels == 0
    assert tree.text == 0


@given(st.lists(TOPIC, max_size=8, unique=True), FILTER, st.sampled_from([0, 200]))
def test_retained_messages_are_found_by_the_same_rule(topics: list[str], name: str, others: int) -> None:
    topics += [f"z/{number}" for number in range(others)]
    retained = RetainedMessages(1000, 10_000)
    for topic in topics:
        assert retained.store(BrokerMessage(topic, b"x"), 0.0)
    assert [message.topic for message, _ in owed(retained, name)] == [
        topic for topic in topics if topic_matches(name, topic)
    ]


def test_the_busy_topics_of_a_house_are_matched_once() -> None:
    """The cache began anew after 512 targets, as two of its limits bore one name."""
    tree, session = SubscriptionTree(), new_session()
    tree.add(session, SessionSubscription("#", "#", 0))
    routes = [tree.route(f"house/{number}") for number in range(1000)]
    assert all(tree.route(f"house/{number}") is route for number, route in enumerate(routes))
