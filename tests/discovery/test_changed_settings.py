"""Changed settings, each with the value before it."""

from typing import TypeAlias

import pytest
from tests.discovery.announcements import announce, part_of, tell

from homebot.devices.value import PlainValue
from homebot.discovery import DeviceIndex

Change: TypeAlias = tuple[PlainValue, PlainValue, int]
"""The value before, the value, and since when the one before was reported."""


def put(index: DeviceIndex, gateway: str = "memory") -> None:
    lamp = announce("l", part_of("light", "on_off", "level", id="l"), ids=("mac:aabbccddeeff",), gateway=gateway)
    index.observe(lamp)
    index.changes.collects_settings = True


def report(
    index: DeviceIndex, value: PlainValue, at: float, *, gateway: str = "memory", retained: bool = False
) -> list[Change]:
    """Report a value, and return the changes since the last time."""
    capability = "level" if isinstance(value, float) else "on_off"
    lamp = announce("l", gateway=gateway)
    index.report(tell(lamp, capability, value, part="l", at=at, retained=retained), at)
    return changed(index)


def changed(index: DeviceIndex) -> list[Change]:
    return [(one.before.plain(), one.value.plain(), one.before_since.sec) for one in index.settings.pop()]


def test_a_change_has_the_known_value_before_it(index: DeviceIndex) -> None:
    put(index)
    assert report(index, value=False, at=1) == [(None, False, 0)]
    assert report(index, value=None, at=2) == [(False, None, 1)]
    assert report(index, value=False, at=3) == [(False, False, 1)]
    assert report(index, value=True, at=4) == [(False, True, 3)]


def test_a_retained_value_is_not_known_to_have_been_the_one_before(index: DeviceIndex) -> None:
    put(index)
    assert report(index, value=False, at=1, retained=True) == []
    assert report(index, value=True, at=2) == [(None, True, 0)]


@pytest.mark.parametrize(
    ("values", "changes"),
    [
        ((True, False, True), [(False, True, 1)]),
        ((True, None, False), [(False, True, 1), (True, False, 2)]),
        ((20.0, 30.0, 40.0), [(10.0, 40.0, 1)]),
        ((0.0, 30.0), [(10.0, 0.0, 1), (0.0, 30.0, 2)]),
    ],
)
def test_of_changes_at_once_each_has_the_one_that_is_published_before_it(
    index: DeviceIndex, values: tuple[PlainValue, ...], changes: list[Change]
) -> None:
    put(index)
    report(index, value=False, at=1)
    report(index, value=10.0, at=1)
    for at, value in enumerate(values, 2):
        capability = "level" if isinstance(value, float) else "on_off"
        index.report(tell(announce("l", gateway="memory"), capability, value, part="l", at=at), at)
    assert changed(index) == changes


def test_the_same_change_by_another_route_is_none(index: DeviceIndex) -> None:
    for gateway in ("memory", "radio"):
        put(index, gateway)
        report(index, value=False, at=1, gateway=gateway)
    assert len(index.devices()) == 1
    assert report(index, value=True, at=5) == [(False, True, 1)]
    assert report(index, value=True, at=6, gateway="radio") == [(True, True, 5)]
    assert report(index, value=False, at=7, gateway="radio") == [(True, False, 6)]
