"""Topic names and filters, and the tree of filters."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import InvalidNameError
from homebot.mqtt.filter_tree import FilterIndex
from homebot.mqtt.topics import SharedFilter, parse_shared_filter, topic_matches, validate_filter, validate_topic

LEVELS = st.lists(st.sampled_from(["a", "b", "", "$x", "ä"]), min_size=1, max_size=4)


@pytest.mark.parametrize("topic", ["a", "/", "a//b", " ", "$SYS/x", "Küche/Lampe 1", "a" * 65_535])
def test_a_legal_topic_is_accepted(topic: str) -> None:
    validate_topic(topic)


@pytest.mark.parametrize(
    ("topic", "problem", "position"),
    [
        ("", "is empty", None),
        ("a/+", "has a wildcard", 2),
        ("a#", "has a wildcard", 1),
        ("a\0", "has a NUL", 1),
        ("a\ud800", "cannot be encoded as UTF-8", 1),
        ("ä" * 32_768, "65536 bytes", None),
    ],
)
def test_an_illegal_topic_is_refused_with_its_place(topic: str, problem: str, position: int | None) -> None:
    with pytest.raises(InvalidNameError, match=problem) as caught:
        validate_topic(topic)
    assert caught.value.position == position


@pytest.mark.parametrize("name", ["#", "+", "a/#", "+/+/#", "/+", "$share/g/#", "$share/g//", "$shared/x", "$share"])
def test_a_legal_filter_is_accepted(name: str) -> None:
    validate_filter(name)


@pytest.mark.parametrize(
    ("name", "position"),
    [
        ("#/a", 0),
        ("a/#/b", 2),
        ("a#", 1),
        ("a/b+", 3),
        ("+a/b", 0),
        ("$share/g/a/#/b", 11),
        ("$share/g+/a", 7),
        ("$share/g", None),
        ("$share//a", None),
        ("$share/g/", None),
    ],
)
def test_an_illegal_filter_is_refused_with_its_place(name: str, position: int | None) -> None:
    with pytest.raises(InvalidNameError) as caught:
        validate_filter(name)
    assert caught.value.position == position


@pytest.mark.parametrize(
    ("name", "topic", "matches"),
    [
        ("a/b", "a/b", True),
        ("a/b", "a/b/c", False),
        ("a/+", "a/", True),
        ("a/+", "a", False),
        ("a/#", "a", True),
        ("a/#", "a/b/c", True),
        ("a/#", "ab", False),
        ("#", "a/b", True),
        ("#", "$SYS/a", False),
        ("+/a", "$SYS/a", False),
        ("$SYS/#", "$SYS/a", True),
        ("+/+", "/a", True),
        ("/+", "/a", True),
        ("+", "/a", False),
        ("$share/g/a/+", "a/b", True),
        ("$share/g/+/b", "$a/b", False),
    ],
)
def test_a_filter_matches_as_the_standard_says(name: str, topic: str, *, matches: bool) -> None:
    assert topic_matches(name, topic) is matches


def test_a_shared_filter_has_a_group_and_a_filter() -> None:
    assert parse_shared_filter("$share/group/a/+/b") == SharedFilter("group", "a/+/b")
    assert parse_shared_filter("$shared/group/a") is None


@given(LEVELS)
def test_every_topic_matches_itself(levels: list[str]) -> None:
    topic = "/".join(levels)
    assert topic_matches(topic or "/", topic or "/")


@given(LEVELS, LEVELS)
def test_hash_matches_all_below_and_the_level_itself(above: list[str], below: list[str]) -> None:
    parent = "/".join(["top", *above])
    assert topic_matches(f"{parent}/#", parent)
    assert topic_matches(f"{parent}/#", "/".join([parent, *below]))


@given(st.text(max_size=30))
def test_any_text_is_a_filter_that_can_be_matched_or_an_error(text: str) -> None:
    try:
        validate_filter(text)
    except InvalidNameError:
        return
    assert topic_matches(text, "a") in (True, False)


TREE_LEVELS = st.sampled_from(["a", "b", "", "$x"])
TREE_TOPICS = st.lists(TREE_LEVELS, min_size=1, max_size=4).map("/".join).filter(bool)
TREE_FILTERS = st.builds(
    lambda levels, end: "/".join((*levels, *end)),
    st.lists(st.sampled_from(["a", "b", "", "$x", "+"]), min_size=1, max_size=4),
    st.sampled_from([(), ("#",)]),
).filter(bool)


@given(st.lists(TREE_FILTERS, max_size=8), TREE_TOPICS, st.sets(st.integers(0, 7)))
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
