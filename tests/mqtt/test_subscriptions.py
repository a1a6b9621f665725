from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.subscriptions import MAX_CHARACTERS, MAX_SUBSCRIPTIONS, batches


def test_plain_topics_are_asked_for_together_and_the_others_alone() -> None:
    wanted = [MqttSubscription(name) for name in ("a", "b", "c/+", "d", "#")] + [
        MqttSubscription("e", qos=1),
        MqttSubscription("f"),
    ]
    assert [[one.filter for one in batch] for batch in batches(wanted, is_paced=True)] == [
        ["a", "b"],
        ["c/+"],
        ["d"],
        ["#"],
        ["e"],
        ["f"],
    ]


def test_all_are_asked_for_together_where_the_broker_drops_nothing() -> None:
    wanted = [MqttSubscription("a/+"), MqttSubscription("b", qos=1), MqttSubscription("#")]

    assert batches(wanted, is_paced=False) == [tuple(wanted)]


@given(st.lists(st.integers(1, 20_000), max_size=300), st.booleans())
def test_every_subscription_is_in_one_batch_of_bounded_size(lengths: list[int], is_paced: bool) -> None:  # noqa: FBT001
    wanted = [MqttSubscription("x" * length) for length in lengths]
    made = list(batches(wanted, is_paced=is_paced))
    assert [one for batch in made for one in batch] == wanted
    for batch in made:
        assert len(batch) <= MAX_SUBSCRIPTIONS
        assert len(batch) == 1 or sum(len(one.filter) for one in batch) <= MAX_CHARACTERS
