from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.subscriptions import MAX_CHARACTERS, MAX_SUBSCRIPTIONS, batches


@given(st.lists(st.tuples(st.integers(1, 20_000), st.integers(1, 300)), max_size=300))
def test_every_subscription_is_in_one_request_of_bounded_size_and_burst(wanted: list[tuple[int, int]]) -> None:
    brought = {MqttSubscription(f"{number:05}" + "x" * length): burst for number, (length, burst) in enumerate(wanted)}
    made = batches(brought, brought.__getitem__)
    assert [one for batch in made for one in batch] == list(brought)
    for batch in made:
        assert len(batch) == 1 or sum(brought[one] for one in batch) <= MAX_SUBSCRIPTIONS
        assert len(batch) == 1 or sum(len(one.filter) for one in batch) <= MAX_CHARACTERS
