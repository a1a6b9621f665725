"""The directory: taking devices in, hearing them, and queries over all of them, in CPU time.

A plain script: ``python benchmarks/directory.py [DEVICES]`` prints one line for each figure.
"""

from __future__ import annotations

import gc
import resource
import sys
import time
from collections.abc import Callable, Iterable
from random import Random
from typing import TypeVar

from homebot.cli.serve import short_collections
from homebot.devices import KeyValue, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.part import Capability, Part
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex
from homebot.discovery.search.rank import rank, reasons
from homebot.messages import Time
from homebot.words.queries import parse_query

T = TypeVar("T")

DEVICES = 10_000
SHOWN = 20
ROOMS = ("kitchen", "living room", "bath", "garage", "bedroom", "hall", "office")
LIGHT = tuple(Capability(name=name, settable=True) for name in ("on_off", "level", "color_temperature"))
SENSOR = (Capability(name="temperature", unit="°C"),)
QUERIES = (
    "light",
    "on lights",
    "light and dimmable in kitchen",
    "lights in kitchen not on",
    "temperature < 3 in bath",
    "sensor with temperature not stale",
    "level > 97",
    'model="TRADFRI 7"',
    "kichen",
    "thing 4242",
)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else DEVICES
    dice = Random(1)
    sightings = [sighting(number, 0.0) for number in range(count)]
    again = [sighting(number, 5.0, confirmed=True) for number in range(count)]
    reports = [report(one, number, dice) for number, one in enumerate(sightings)]
    gc.collect()
    before = memory()
    index = DeviceIndex(forget_after=86_400.0)
    each("sighting taken in", sightings, index.observe)
    whole("told of", count, index.pop_changes)
    whole("sorted in for queries", count, index.sort)
    print(f"{'memory of a device':40} {(memory() - before) / count:8.1f} kB")
    each("sighting again", again, index.observe)
    each("report", reports, index.report)
    each("report of nothing new", reports, index.report)
    index.pop_changes()
    index.sort()
    for text in QUERIES:
        ask(index, text)


def ask(index: DeviceIndex, text: str) -> None:
    query = parse_query(text)
    found = index.find(query)
    plain = best(lambda: index.find(query))
    ranked = best(
        lambda: [reasons(query, one, index.postings) for _, one in rank(query, found, index.postings)[:SHOWN]]
    )
    print(f"{text:40} {plain * 1e3:8.3f} ms, ranked {ranked * 1e3:7.3f} ms, {len(found)} devices")


def each(name: str, things: Iterable[T], take: Callable[[T], object]) -> None:
    listed = list(things)
    start = time.process_time()
    for one in listed:
        take(one)
    print(f"{name:40} {(time.process_time() - start) / len(listed) * 1e6:8.1f} µs")


def whole(name: str, count: int, work: Callable[[], object]) -> None:
    start = time.process_time()
    work()
    print(f"{name:40} {(time.process_time() - start) / count * 1e6:8.1f} µs")


def best(work: Callable[[], object], times: int = 5) -> float:
    found = []
    for _ in range(times):
        start = time.process_time()
        work()
        found.append(time.process_time() - start)
    return min(found)


def memory() -> float:
    return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


def sighting(number: int, at: float, *, confirmed: bool = False) -> Sighting:
    is_light = number % 2 == 0
    service_type = "light" if is_light else "temperature_sensor"
    address = f"{number:016x}"
    room = ROOMS[number % len(ROOMS)]
    part = Part(
        id="main",
        service_type=service_type,
        capabilities=LIGHT if is_light else SENSOR,
        reads=(f"z/{number}",),
        writes=(f"z/{number}/set",) if is_light else (),
    )
    facts = {"manufacturer": "IKEA", "model": f"TRADFRI {number % 50}", "sw_version": "1.2.3", "via_device": "bridge"}
    return Sighting(
        gateway="mqtt",
        key=f"homeassistant:{service_type}/{address}",
        kind="updated",
        why="it was announced",
        name=f"{room} thing {number}",
        service_type=service_type,
        address="",
        command_address="",
        metadata=tuple(KeyValue(key=key, value=value) for key, value in facts.items()),
        convention="homeassistant",
        identifiers=(f"eui64:{address}", f"id:zigbee2mqtt_0x{address}"),
        area=room,
        parts=(part,),
        announced_on=f"homeassistant/{service_type}/{address}/config",
        seen_at=Time.from_seconds(at),
        expires_at=Time.from_seconds(at + 3600.0),
        confirmed=confirmed,
    )


def report(one: Sighting, number: int, dice: Random) -> Report:
    values = {"on_off": dice.random() < 0.5, "level": float(number % 100)}
    if number % 2:
        values = {"temperature": dice.random() * 40.0}
    return Report(
        gateway=one.gateway,
        key=one.key,
        readings=tuple(Reading(part="main", capability=name, value=Value.of(value)) for name, value in values.items()),
        address=f"z/{number}",
        retained=False,
        received_at=Time.from_seconds(10.0),
    )


if __name__ == "__main__":
    with short_collections():
        main()
