import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import WireError
from homebot.gateways.mqtt.state_topics import StateTopics, pop_filters


def topics(*announcements: str, others: tuple[str, ...] = (), most: int = 100) -> StateTopics:
    return StateTopics(announcements, others, most)


@given(st.lists(st.tuples(st.booleans(), st.sampled_from("abc"), st.booleans())))
def test_exactly_the_needed_topics_are_subscribed_to(steps: list[tuple[bool, str, bool]]) -> None:
    wanted = topics()
    users = dict.fromkeys("abc", 0)
    subscribed: set[str] = set()
    for uses, name, brings_up in steps:
        if uses:
            wanted.use(name)
            users[name] += 1
        else:
            wanted.leave(name)
            users[name] = max(0, users[name] - 1)
        if brings_up:
            new, old = pop_filters(wanted.wanted, 10), pop_filters(wanted.unwanted, 10)
            assert not subscribed.intersection(new)
            subscribed = subscribed.union(new).difference(old)
            assert subscribed == {name for name, count in users.items() if count}
    assert len(wanted.users) == sum(1 for count in users.values() if count)


def test_no_more_is_taken_than_was_asked_for() -> None:
    wanted = topics()
    for name in "abc":
        wanted.use(name)
    assert pop_filters(wanted.wanted, 2) == ("a", "b")
    assert pop_filters(wanted.wanted, 2) == ("c",)


def test_a_plain_topic_is_covered_by_what_comes_anyway_and_a_filter_never() -> None:
    wanted = topics("home/+")
    assert wanted.is_covered("home/a")
    assert not wanted.is_covered("home/a/b")
    assert not wanted.is_covered("home/+")


def test_the_filter_of_an_announcement_is_asked_for_again_and_never_given_up() -> None:
    """Zigbee2MQTT announces on a topic that entities of its bridge name as their state."""
    for name in ("bridge/info", "shelly/+/relay/+"):
        wanted = topics(name)
        wanted.use(name)
        assert pop_filters(wanted.wanted, 10) == (name,)
        assert not wanted.is_covered(name)
        wanted.leave(name)
        assert pop_filters(wanted.unwanted, 10) == ()


def test_a_filter_of_a_higher_qos_is_never_touched() -> None:
    wanted = topics(others=("home",))
    wanted.use("home")
    wanted.leave("home")
    assert pop_filters(wanted.wanted, 10) == pop_filters(wanted.unwanted, 10) == ()


def test_one_topic_too_many_is_refused_and_a_known_one_is_not() -> None:
    wanted = topics(most=1)
    wanted.use("a")
    wanted.use("a")
    with pytest.raises(WireError, match="exceeds the limit of 1 state topics"):
        wanted.use("b")


def test_a_filter_that_begins_with_wildcards_is_taken_where_the_rest_tells_one_device_from_others() -> None:
    wanted = topics()
    wanted.use("+/+/BTtoMQTT/A4C138000011")
    for greedy in ("#", "+", "+/#", "+/state", "+/+/state", "+/BTtoMQTT/A4C138000011/#"):
        with pytest.raises(WireError, match="does not belong to this device alone"):
            wanted.use(greedy)
    assert pop_filters(wanted.wanted, 10) == ("+/+/BTtoMQTT/A4C138000011",)
