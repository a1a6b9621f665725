from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.subscriptions import MOST, MOST_CHARACTERS, batches


def test_plain_topics_are_asked_for_together_and_the_others_alone() -> None:
    wanted = [MqttSubscription(name) for name in ("a", "b", "c/+", "d", "#")] + [
        MqttSubscription("e", qos=1),
        MqttSubscription("f"),
    ]
    assert [[one.filter for one in batch] for batch in batches(wanted)] == [
        ["a", "b"],
        ["c/+"],
        ["d"],
        ["#"],
        ["e"],
        ["f"],
    ]


@given(st.lists(st.integers(1, 20_000), max_size=300))
def test_every_subscription_is_in_one_batch_of_bounded_size(lengths: list[int]) -> None:
    wanted = [MqttSubscription("x" * length) for length in lengths]
    made = list(batches(wanted))
    assert [one for batch in made for one in batch] == wanted
    for batch in made:
        assert len(batch) <= MOST
        assert len(batch) == 1 or sum(len(one.filter) for one in batch) <= MOST_CHARACTERS
