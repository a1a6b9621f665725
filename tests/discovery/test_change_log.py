"""How many changes are kept for late askers, and of how long devices."""

from __future__ import annotations

from homebot.devices import Device, DeviceChange
from homebot.devices.device import DevicePart
from homebot.devices.part import Capability, Part
from homebot.discovery.change_log import ChangeLog
from homebot.messages import Time


def change(sequence: int, *options: str) -> DeviceChange:
    part = Part(id="", service_type="select", capabilities=(Capability(name="option", options=options),))
    at = Time(sec=0, nanosec=0)
    device = Device(
        id="d",
        name="D",
        service_type="select",
        endpoints=(),
        metadata=(),
        first_seen=at,
        last_seen=at,
        expires=at,
        freshness="fresh",
        parts=(DevicePart(id="", part=part, routes=()),),
    )
    return DeviceChange(kind="changed", device=device, sequence=sequence, why="")


def numbers(log: ChangeLog, since: int = 0) -> list[int]:
    return [one.sequence for one in log.since(since)]


def test_of_too_many_the_oldest_are_forgotten() -> None:
    log = ChangeLog(0, most=3)
    for sequence in range(1, 6):
        log.append(change(sequence))
    assert numbers(log) == [3, 4, 5]
    assert numbers(log, 4) == [5]
    assert log.forgotten == 2


def test_of_too_long_ones_the_oldest_are_forgotten_and_short_ones_have_room_again() -> None:
    """A device of a long list that comes and goes again and again would be kept once for each time."""
    log = ChangeLog(0, max_size=100_000)
    for sequence in range(1, 10):
        log.append(change(sequence, *(f"{sequence:040}" for _ in range(500))))
    assert numbers(log) == [8, 9]
    for sequence in range(10, 60):
        log.append(change(sequence))
    assert numbers(log) == list(range(9, 60))
    assert log.forgotten == 8


def test_one_that_is_too_long_by_itself_is_not_kept() -> None:
    log = ChangeLog(0, max_size=10_000)
    log.append(change(1, "x" * 20_000))
    assert (len(log), log.forgotten) == (0, 1)
    log.append(change(2))
    assert numbers(log) == [2]
