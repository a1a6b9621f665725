"""What a reader hears: each device appears first and is removed last, whatever the reader missed. Pure."""

from __future__ import annotations

from typing import Literal

from hypothesis import given
from hypothesis import strategies as st

from homebot.devices import Device, DeviceChange, Endpoint
from homebot.devices.live_query_state import LiveQueryState
from homebot.devices.query import And, type_is
from homebot.messages import Time

NOW = Time(sec=0, nanosec=0)

Kind = Literal["appeared", "changed", "stale", "returned", "removed"]


def device(device_id: str, *, service_type: str = "lights", name: str = "") -> Device:
    return Device(
        id=device_id,
        name=name or device_id,
        service_type=service_type,
        endpoints=(Endpoint(gateway="g", key=device_id, address="a", command_address="c"),),
        metadata=(),
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness="fresh",
    )


def change(kind: Kind, one: Device, sequence: int) -> DeviceChange:
    return DeviceChange(kind=kind, device=one, sequence=sequence, why="")


def told(followed: LiveQueryState, kind: Kind, one: Device, sequence: int) -> str | None:
    found = followed.take(change(kind, one, sequence))
    return found.kind if found else None


def test_the_changes_of_a_device_come_as_they_are() -> None:
    followed = LiveQueryState(type_is("lights"))
    lamp = device("lamp")
    kinds: tuple[Kind, ...] = ("appeared", "changed", "stale", "returned", "removed", "appeared")
    assert tuple(told(followed, kind, lamp, number) for number, kind in enumerate(kinds, 1)) == kinds


def test_the_first_that_a_reader_hears_of_a_device_is_that_it_appeared() -> None:
    """Also when it was too slow for the real appearance."""
    followed = LiveQueryState(And(()))
    assert told(followed, "stale", device("lamp"), 5) == "appeared"
    assert told(followed, "appeared", device("lamp"), 6) == "changed"


def test_what_was_never_there_for_the_reader_is_not_removed() -> None:
    assert told(LiveQueryState(type_is("lights")), "removed", device("lamp"), 1) is None


def test_a_device_of_another_type_is_nothing_to_the_reader() -> None:
    followed = LiveQueryState(type_is("lights"))
    assert told(followed, "appeared", device("motor", service_type="windows"), 1) is None


def test_a_device_that_offers_the_wanted_service_no_longer_is_removed() -> None:
    """And it may come back."""
    followed = LiveQueryState(type_is("lights"))
    followed.take(change("appeared", device("lamp"), 1))
    assert told(followed, "changed", device("lamp", service_type="plugs"), 2) == "removed"
    assert told(followed, "changed", device("lamp", service_type="plugs"), 3) is None
    assert told(followed, "changed", device("lamp"), 4) == "appeared"


def test_a_snapshot_tells_only_what_is_different() -> None:
    followed = LiveQueryState(type_is("lights"))
    first = list(followed.compare((device("a"), device("b"), device("c", service_type="windows")), 10))
    assert [(one.kind, one.device.id, one.sequence) for one in first] == [("appeared", "a", 10), ("appeared", "b", 10)]
    second = list(followed.compare((device("b", name="new"), device("d")), 20))
    assert [(one.kind, one.device.id) for one in second] == [("removed", "a"), ("changed", "b"), ("appeared", "d")]
    assert list(followed.compare((device("b", name="new"), device("d")), 30)) == []


def test_what_is_in_the_snapshot_is_not_told_again() -> None:
    followed = LiveQueryState(type_is("lights"))
    list(followed.compare((device("a"),), 10))
    assert told(followed, "appeared", device("a"), 10) is None
    assert told(followed, "changed", device("a"), 11) == "changed"


ids = st.sampled_from("abc")
types = st.sampled_from(["lights", "windows"])
kinds = st.sampled_from(["appeared", "changed", "stale", "returned", "removed"])
snapshots = st.dictionaries(ids, types)


@given(st.lists(st.one_of(st.tuples(kinds, ids, types), snapshots)))
def test_whatever_comes_the_reader_hears_a_consistent_story(
    events: list[tuple[Kind, str, str] | dict[str, str]],
) -> None:
    """Never twice appeared, never removed before, and in the end it knows who is there."""
    followed = LiveQueryState(type_is("lights"))
    there: set[str] = set()
    last: dict[str, str] = {}
    for sequence, event in enumerate(events, 1):
        if isinstance(event, dict):
            found = list(
                followed.compare(tuple(device(one, service_type=kind) for one, kind in event.items()), sequence)
            )
            last = dict(event)
        else:
            kind, one, service_type = event
            single = followed.take(change(kind, device(one, service_type=service_type), sequence))
            found = [single] if single else []
            last.pop(one, None)
            if kind != "removed":
                last[one] = service_type
        for heard in found:
            assert (heard.kind == "appeared") == (heard.device.id not in there)
            there.add(heard.device.id)
            if heard.kind == "removed":
                there.remove(heard.device.id)
        assert there == {one for one, service_type in last.items() if service_type == "lights"}
