"""Bounded map."""

from homebot.support.bounded_map import BoundedMap


def test_the_oldest_entry_is_dropped_and_an_assignment_makes_an_entry_new() -> None:
    entries: BoundedMap[str, int] = BoundedMap(2)
    entries["a"] = 1
    entries["b"] = 2
    entries["a"] = 3
    entries["c"] = 4
    assert dict(entries) == {"a": 3, "c": 4}


def test_a_removed_entry_leaves_room() -> None:
    entries: BoundedMap[str, int] = BoundedMap(2)
    for key in "abc":
        entries[key] = 0
    del entries["b"]
    entries["d"] = 0
    assert list(entries) == ["c", "d"]


def test_a_dropped_entry_is_handed_to_its_owner() -> None:
    dropped: list[tuple[str, int]] = []
    entries: BoundedMap[str, int] = BoundedMap(1, lambda key, value: dropped.append((key, value)))
    entries["a"] = 1
    entries["b"] = 2
    assert dropped == [("a", 1)]
