"""The tree of filters, held to MQTT's own rule of matching."""

from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.filter_tree import FilterIndex
from homebot.mqtt.topics import topic_matches

LEVELS = st.sampled_from(["a", "b", "", "$x"])
TOPICS = st.lists(LEVELS, min_size=1, max_size=4).map("/".join).filter(bool)
FILTERS = st.builds(
    lambda levels, end: "/".join((*levels, *end)),
    st.lists(st.sampled_from(["a", "b", "", "$x", "+"]), min_size=1, max_size=4),
    st.sampled_from([(), ("#",)]),
).filter(bool)


@given(st.lists(FILTERS, max_size=8), TOPICS, st.sets(st.integers(0, 7)))
def test_a_topic_finds_exactly_what_matches_and_was_not_removed(
    filters: list[str], topic: str, removed: set[int]
) -> None:
    tree: FilterIndex[int] = FilterIndex()
    for number, one in enumerate(filters):
        tree.add(one, number)
    for number in removed:
        if number < len(filters):
            tree.remove(filters[number], number)
    wanted = {number for number, one in enumerate(filters) if number not in removed and topic_matches(one, topic)}
    found = tree.match(topic)
    assert set(found) == wanted
    assert len(found) == len(wanted)
    assert tree.has_match(topic) is bool(wanted)


def test_removing_what_is_not_there_changes_nothing() -> None:
    tree: FilterIndex[str] = FilterIndex()
    tree.add("a/+", "x")
    tree.remove("a/#", "x")
    tree.remove("b", "x")
    assert tree.match("a/b") == ("x",)
