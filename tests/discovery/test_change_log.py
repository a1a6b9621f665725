"""How many changes are kept for late askers, and of how long devices."""

import gc
import tracemalloc

import pytest

from homebot.devices import Device, DeviceChange, KeyValue
from homebot.devices.device import DevicePart
from homebot.devices.part import Capability, Part
from homebot.discovery.changes import ChangeLog
from homebot.messages import Time


def change(sequence: int, *options: str, name: str = "D", fact: str = "") -> DeviceChange:
    part = Part(id="", service_type="select", capabilities=(Capability(name="option", options=options),))
    at = Time(sec=0, nanosec=0)
    device = Device(
        id="d",
        name=name,
        service_type="select",
        endpoints=(),
        metadata=(KeyValue(key="model", value=fact),),
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
    log = ChangeLog(0, max_size=550_000)
    for sequence in range(1, 10):
        log.append(change(sequence, *(f"{sequence:040}" for _ in range(3000))))
    assert numbers(log) == [8, 9]
    for sequence in range(10, 60):
        log.append(change(sequence))
    assert numbers(log) == list(range(9, 60))
    assert log.forgotten == 8


@pytest.mark.parametrize("long", [{"name": "x" * 20_000}, {"fact": "x" * 20_000}])
def test_every_text_of_a_device_counts(long: dict[str, str]) -> None:
    log = ChangeLog(0, max_size=10_000)
    log.append(change(1, **long))
    assert (len(log), log.forgotten) == (0, 1)


def test_the_bound_is_no_less_than_what_is_kept() -> None:
    """Short devices, of which each change keeps the whole."""

    def filled() -> ChangeLog:
        log = ChangeLog(0, most=100_000, max_size=1024 * 1024)
        for sequence in range(1, 2000):
            log.append(change(sequence, name=f"Device {sequence}", fact=f"Model {sequence}"))
        return log

    filled()  # what is made when code runs for the first time is none of the log's
    gc.collect()
    tracemalloc.start()
    log = filled()
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(log) < 1000
    assert 256 * 1024 < kept < 1024 * 1024


def test_one_that_is_too_long_by_itself_is_not_kept() -> None:
    log = ChangeLog(0, max_size=10_000)
    log.append(change(1, "x" * 20_000))
    assert (len(log), log.forgotten) == (0, 1)
    log.append(change(2))
    assert numbers(log) == [2]
