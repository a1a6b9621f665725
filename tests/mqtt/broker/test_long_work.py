"""What one packet may cost: long work is done in slices, and what cannot be sliced is bounded.

Work is counted in calls of Python functions, which no other load of the machine changes.
"""

from collections.abc import Callable
from cProfile import Profile
from itertools import product

import pytest
from tests.mqtt.broker.conftest import Join, MemoryClient, NewState, WorkClock

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerState
from homebot.mqtt.topics import topic_matches

pytestmark = pytest.mark.no_cover

CALLS = 300_000
"""About 40 ms of work with the profiler off; before there were slices the cases below took up to 20 million."""


@pytest.fixture
def clock() -> WorkClock:
    """A clock that goes on with the work, and on a computer that is 2.5 times slower than this one."""
    return WorkClock(1000.0, 2.5)


def calls_of(act: Callable[[], None]) -> int:
    """Return how many functions are called, C's included, while *act* runs."""
    profile = Profile()
    profile.runcall(act)
    return sum(function.callcount for function in profile.getstats())


def retain(state: BrokerState, join: Join, topics: list[str]) -> None:
    keeper = join("keeper", at=state)
    for topic in topics:
        keeper.publish(topic, b"x", retain=True)


def served(client: MemoryClient, clock: WorkClock, cost: Callable[[Callable[[], None]], int] = calls_of) -> list[int]:
    """Let time pass until nothing more comes; the calls of each slice."""
    costs = []
    while True:
        before = len(client.link.written)
        clock.advance(0.01)
        costs.append(cost(lambda: client.state.deadlines.run(clock.monotonic())))
        if len(client.link.written) == before and not client.state.turn.waiting:
            return costs


def uncounted(act: Callable[[], None]) -> int:
    """Run *act* without the counting, which takes ten times as long as the work."""
    act()
    return 0


def finish(client: MemoryClient, clock: WorkClock) -> None:
    """Let time pass until nothing more comes."""
    served(client, clock, uncounted)


WILD = [f"{'+/' * depth}{level}/#" for depth in range(20) for level in ("a", "b", "+")] + ["#"]


@pytest.mark.parametrize(
    ("topics", "filters"),
    [
        pytest.param(
            [f"a/{one}/b/{two}" for one in range(25) for two in range(50)],
            [f"+/+/b/{number}" for number in range(460)],
            id="13.9 kB of filters with two wildcards",
        ),
        pytest.param([f"a/{number}" for number in range(5000)], ["#"], id="everything"),
        pytest.param([f"a/b/{number}" for number in range(2000)], WILD, id="filters that overlap"),
        pytest.param(
            ["/".join(levels) for levels in product("ab", repeat=9)],
            ["/".join(levels) for levels in product("a+", repeat=9)],
            id="all ways to put a plus",
        ),
        pytest.param([f"t/{number}" for number in range(3000)], [f"t/{number}" for number in range(4000)], id="plain"),
    ],
)
def test_no_subscribe_takes_long_at_once_and_all_retained_messages_come(
    state: BrokerState, join: Join, clock: WorkClock, topics: list[str], filters: list[str]
) -> None:
    retain(state, join, topics)
    client = join("client")
    clock.advance(1)
    packet = mqtt.Subscribe(7, tuple(mqtt.MqttSubscription(each) for each in filters))
    costs = [calls_of(lambda: client.send(packet)), *served(client, clock)]
    assert max(costs) < CALLS
    suback, *messages = client.take()
    assert isinstance(suback, mqtt.Suback)
    assert len(suback.reasons) == len(filters)
    assert sorted(message.topic for message in messages if isinstance(message, mqtt.Publish)) == matched(
        filters, topics
    )


def matched(filters: list[str], topics: list[str]) -> list[str]:
    """Each topic as often as a filter matches it."""
    wild = [each for each in filters if "+" in each or "#" in each]
    plain = set(filters) & set(topics)
    return sorted([*plain, *(topic for topic in topics for each in wild if topic_matches(each, topic))])


def test_others_are_served_between_the_slices_and_the_client_itself_in_its_order(
    state: BrokerState, join: Join, clock: WorkClock
) -> None:
    retain(state, join, [f"a/{number}" for number in range(5000)])
    client, other = join("client"), join("other")
    client.send(
        mqtt.Subscribe(1, tuple(mqtt.MqttSubscription(f"x/{number}") for number in range(2000))),
        mqtt.Pingreq(),
        mqtt.Publish("x/1"),
    )
    assert client.take() == [mqtt.Pingresp()]
    other.send(mqtt.Pingreq())
    assert other.take() == [mqtt.Pingresp()]
    finish(client, clock)
    suback, message = client.take()
    assert isinstance(suback, mqtt.Suback)
    assert isinstance(message, mqtt.Publish)


def test_what_comes_during_a_replay_comes_behind_it(state: BrokerState, join: Join, clock: WorkClock) -> None:
    """Also what is not retained: an old state must not come after a new one."""
    retain(state, join, [f"a/{number}" for number in range(5000)])
    client, other = join("client"), join("other")
    client.subscribe("#", qos=1)
    other.publish("a/4999", b"new", 0)
    other.publish("a/4998", b"new", 1, 1)
    finish(client, clock)
    payloads = [message.payload for message in client.messages()]
    assert payloads[-2:] == [b"new", b"new"]
    assert payloads[:-2] == [b"x"] * 5000


def test_a_message_that_replaces_a_retained_one_comes_once(state: BrokerState, join: Join, clock: WorkClock) -> None:
    retain(state, join, [f"a/{number}" for number in range(5000)])
    client, other = join("client"), join("other")
    client.subscribe("#", qos=1)
    other.publish("a/4999", b"new", 0, retain=True)
    other.publish("a/4998", b"", 0, retain=True)
    finish(client, clock)
    last = [(message.topic, message.payload) for message in client.messages()][-4:]
    assert last == [("a/4996", b"x"), ("a/4997", b"x"), ("a/4999", b"new"), ("a/4998", b"")]


def test_a_subscription_that_was_taken_back_is_owed_nothing(state: BrokerState, join: Join, clock: WorkClock) -> None:
    retain(state, join, [f"a/{number}" for number in range(5000)])
    client = join("client", to="#")
    got = len(client.messages())
    client.send(mqtt.Unsubscribe(2, ("#",)))
    finish(client, clock)
    assert 0 < got + len(client.messages()) < 5000
    assert state.stats.queued_messages == 0


def test_a_replay_goes_on_when_its_client_comes_back(state: BrokerState, join: Join, clock: WorkClock) -> None:
    """At QoS 1, as all that waits for an absent client."""
    keeper = join("keeper")
    for number in range(3000):
        keeper.publish(f"a/{number}", b"x", number % 2, number % 2 or None, retain=True)
    client = join("client", session_expiry_interval=1000, receive_maximum=10, to="#")
    client.lose()
    client = join("client", clean=False, present=True, session_expiry_interval=1000)
    received = set()
    while messages := client.messages() or (served(client, clock, uncounted) and client.messages()):
        received |= {message.topic for message in messages}
        client.acknowledge(*(message for message in messages if message.qos))
    assert len([topic for topic in received if int(topic[2:]) % 2]) == 1500


def test_messages_of_members_that_leave_together_are_handed_on_a_few_at_a_time(
    state: BrokerState, join: Join, clock: WorkClock
) -> None:
    members = [join(f"m{number}", to=f"$share/{number}/t") for number in range(5)]
    publisher = join("publisher")
    count = 7000
    for number in range(count):
        publisher.publish("t", b"%d" % number, qos=1, packet_id=number + 1)
        clock.advance(0.01)
        state.deadlines.run(clock.monotonic())
    others = [join(f"o{number}", to=f"$share/{number}/t") for number in range(5)]

    def leave() -> None:
        for each in members:
            each.lose()

    assert max(calls_of(leave), *served(others[0], clock)) < CALLS
    assert state.sessions.queued + sum(len(each.messages()) for each in others) == 5 * count


def test_a_client_that_goes_in_the_middle_of_its_subscribe_leaves_nothing(
    state: BrokerState, join: Join, clock: WorkClock
) -> None:
    client = join("client")
    client.send(
        mqtt.Subscribe(1, tuple(mqtt.MqttSubscription(f"x/{number}") for number in range(5000))), mqtt.Publish("t")
    )
    assert 0 < state.stats.subscriptions < 5000
    client.lose()
    finish(client, clock)
    assert (state.stats.subscriptions, state.stats.sessions, state.exchange.subscriptions.levels) == (0, 0, 0)


def test_a_slow_reader_of_many_retained_messages_costs_no_memory_for_them(
    new_state: NewState, join: Join, clock: WorkClock
) -> None:
    state = new_state()
    retain(state, join, [f"a/{number}" for number in range(5000)])
    client = join("client", at=state)
    client.link.write_blocked = True
    for number in range(100):
        client.send(mqtt.Subscribe(number + 1, tuple(mqtt.MqttSubscription(f"{'+/' * deep}#") for deep in range(20))))
    finish(client, clock)
    assert state.stats.queued_messages == 100
    assert len(state.sessions._sessions["client"]._queue.messages) == 100


@pytest.mark.parametrize("kind", [mqtt.Subscribe, mqtt.Unsubscribe])
def test_a_packet_with_too_many_filters_ends_its_connection_soon(join: Join, kind: type) -> None:
    client = join("client")
    many = tuple(mqtt.MqttSubscription("a") if kind is mqtt.Subscribe else "a" for _ in range(50_000))
    data = mqtt.encode(kind(1, many))
    assert calls_of(lambda: client.send_bytes(data)) < CALLS
    assert client.link.closed
    assert client.take_only(mqtt.Disconnect)[0].reason in (
        mqtt.ReasonCode.QUOTA_EXCEEDED,
        mqtt.ReasonCode.PACKET_TOO_LARGE,
    )


@pytest.mark.parametrize(
    "properties",
    [
        mqtt.Properties(user_properties=(("", ""),) * 100_000),
        mqtt.Properties(subscription_identifiers=(1,) * 100_000),
    ],
)
def test_a_packet_with_too_many_properties_ends_its_connection_soon(join: Join, properties: mqtt.Properties) -> None:
    client = join("client")
    data = mqtt.encode(mqtt.Publish("t", properties=properties))
    assert calls_of(lambda: client.send_bytes(data)) < CALLS
    assert client.link.closed


def test_five_thousand_filters_are_unsubscribed_in_slices(state: BrokerState, join: Join, clock: WorkClock) -> None:
    client = join("client")
    names = tuple("/".join(str(number).zfill(4)) + "/x" * 15 for number in range(5000))
    client.send(mqtt.Subscribe(1, tuple(mqtt.MqttSubscription(name) for name in names)))
    finish(client, clock)
    client.take()
    clock.advance(1)
    packet = mqtt.Unsubscribe(2, names)
    costs = [calls_of(lambda: client.send(packet)), *served(client, clock)]
    assert max(costs) < CALLS
    (unsuback,) = client.take()
    assert isinstance(unsuback, mqtt.Unsuback)
    assert set(unsuback.reasons) == {mqtt.ReasonCode.SUCCESS}
    assert state.exchange.subscriptions.levels == 0


def test_a_topic_that_meets_every_wildcard_is_published_soon(state: BrokerState, join: Join, clock: WorkClock) -> None:
    """Every way to put a plus into 12 levels, and as many levels as the tree may have."""
    clients = [join(f"c{number}") for number in range(10)]
    for number, client in enumerate(clients):
        start = "/".join("a+"[number >> bit & 1] for bit in range(4))
        names = [f"{start}/{'/'.join(levels)}" for levels in product("a+", repeat=12)]
        client.send(mqtt.Subscribe(1, tuple(mqtt.MqttSubscription(name) for name in names)))
        finish(client, clock)
    assert state.stats.subscriptions > 30_000
    publisher = join("publisher")
    publisher.publish("/".join("a" * 16))
    assert calls_of(lambda: publisher.publish("/".join("a" * 16))) < CALLS
    publisher.subscribe("z")
    assert calls_of(lambda: publisher.publish("/".join("a" * 16))) < CALLS


@pytest.mark.parametrize("version", [mqtt.ProtocolVersion.V311, mqtt.ProtocolVersion.V5])
def test_a_store_that_is_full_of_retained_messages_refuses_one_more_at_once(
    new_state: NewState, join: Join, version: mqtt.ProtocolVersion
) -> None:
    state = new_state(max_retained_messages=5000)
    retain(state, join, [f"a/{number}" for number in range(5000)])
    publisher = join("p", at=state, version=version)
    assert calls_of(lambda: publisher.publish("one/more", b"x", 1, 1, retain=True)) < 500
    assert state.stats.retained_refused == 1


def test_a_publisher_to_many_lets_others_have_their_turn(state: BrokerState, join: Join, clock: WorkClock) -> None:
    """Some thousand small messages fit into one read; each goes to a hundred."""
    subscribers = [join(f"s{number}") for number in range(100)]
    for subscriber in subscribers:
        subscriber.subscribe("t", qos=0)
    publisher = join("p")
    data = mqtt.encode(mqtt.Publish("t", b"")) * 2000
    costs = [calls_of(lambda: publisher.peer.receive(data))]
    assert len(subscribers[0].messages()) < 200
    while state.turn.waiting:
        clock.advance(0.001)
        costs.append(calls_of(lambda: state.deadlines.run(clock.monotonic())))
    assert max(costs) < CALLS
    assert len(subscribers[99].messages()) == 2000


def test_copies_of_a_large_message_are_made_one_after_the_other(
    state: BrokerState, join: Join, clock: WorkClock
) -> None:
    subscribers = [join(f"s{number}", receive_maximum=10) for number in range(40)]
    for number, subscriber in enumerate(subscribers):
        subscriber.subscribe("t", qos=number % 2)
    publisher = join("p")
    publisher.publish("t", bytes(2_000_000), 1, 1)
    publisher.publish("t", b"small", 1, 2)
    assert 0 < sum(len(subscriber.link.written) > 2_000_000 for subscriber in subscribers) < 20
    finish(subscribers[0], clock)
    for subscriber in subscribers:
        assert [len(message.payload) for message in subscriber.messages()] == [2_000_000, 5]


def test_the_subscriptions_of_sessions_that_end_are_removed_a_few_at_a_time(
    state: BrokerState, join: Join, clock: WorkClock
) -> None:
    """As many as one session may have, and all that there may be; from the first on they get nothing."""
    session = join("many")
    rest = join("more")
    for client, count in ((session, state.limits.max_subscriptions), (rest, 10_000)):
        for first in range(0, count, 1000):
            client.send(
                mqtt.Subscribe(
                    1, tuple(mqtt.MqttSubscription(f"s/{number}", 0) for number in range(first, first + 1000))
                )
            )
            finish(client, clock)
    keeper = join("keeper")
    keeper.publish("s/7", b"seen")
    assert [message.payload for message in session.messages()] == [b"seen"]
    assert state.stats.subscriptions == state.limits.max_all_subscriptions
    costs = [calls_of(session.lose), calls_of(rest.lose)]
    assert state.stats.subscriptions > 40_000
    keeper.publish("s/7", b"not seen", 1, 1)
    assert keeper.take_only(mqtt.Puback)[0].reason is mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS
    back = join("many", clean=True)
    back.publish("s/7", b"not seen either")
    costs += served(back, clock)
    assert back.messages() == []
    assert state.stats.subscriptions == 0
    assert max(costs) < CALLS // 4
    assert back.subscribe("s/7", qos=0) == (mqtt.ReasonCode.SUCCESS,)
    keeper.publish("s/7", b"again")
    assert [message.payload for message in back.messages()] == [b"again"]
