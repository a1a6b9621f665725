"""Measures how one gateway finds and loses devices: ``python discovery_worker.py HOUSE COUNT PATIENCE``.

It prints one JSON line when all devices have joined, and one when it has waited for all deaths to be noticed. On a
loopback interface of its own, whose counters then are its traffic alone, call it through ``unshare --net``.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import time
import tracemalloc
from pathlib import Path

import anyio

from discovery_houses import HOUSES, House, Joined, house_of
from homebot.devices import DEVICE_STATES, DeviceChange, StateChange
from homebot.devices.follow import Follow
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.log import configure_logging

__all__: list[str] = []

JOIN_WITHIN = 6.0
TRACED_WITHIN = 60.0
"""Both in seconds. Tracing allocations makes simulated devices many times slower, and no time is measured there."""

SETTLE = 0.3
"""Seconds between a device's appearance and its death, in which a driver connects to it."""

FRAMES = 25
OURS = tuple(f"{os.sep}homebot{os.sep}{package}{os.sep}" for package in ("gateways", "discovery"))
NOT_OURS = f"{os.sep}homebot{os.sep}house{os.sep}"


class Watch:
    """Notes when the directory says that a device has appeared, or that it has died."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._waiting: dict[str, Joined] = {}
        self._ids: dict[str, str] = {}
        self._died: dict[str, float] = {}
        self.news = anyio.Event()
        self.appeared: dict[str, float] = {}
        self.noticed: dict[str, tuple[float, str]] = {}

    def expect(self, name: str, joined: Joined) -> None:
        """Wait for a device from now on."""
        self._waiting[name] = joined

    def mourn(self, name: str) -> None:
        """Note that a device dies now."""
        self._died[name] = time.perf_counter()

    async def follow(self) -> None:
        """Read changes of devices until cancelled."""
        async for change in Follow(self._node):
            self._take(change)

    async def listen(self) -> None:
        """Read changes of states until cancelled: a tag that is taken away is no longer connected."""
        async for change in self._node.create_subscription(StateChange, DEVICE_STATES, qos_profile=1000):
            for state in change.states:
                if state.capability == "connectivity" and state.value.plain() is False:
                    self._notice(change.device, "connectivity: false")

    def _take(self, change: DeviceChange) -> None:
        device = change.device
        if device.id not in self._ids:
            text = str(device).lower()
            for name, joined in self._waiting.items():
                if any(mark in text for mark in joined.marks):
                    self._ids[device.id] = name
                    self.appeared[name] = time.perf_counter()
                    del self._waiting[name]
                    break
        if change.kind in {"stale", "removed"}:
            self._notice(device.id, change.kind)
        elif device.reachable.state == "no":
            self._notice(device.id, "unreachable")
        self.news.set()

    def _notice(self, device_id: str, how: str) -> None:
        name = self._ids.get(device_id, "")
        if name in self._died and name not in self.noticed:
            self.noticed[name] = (time.perf_counter() - self._died[name], how)
        self.news.set()

    async def until_appeared(self, name: str, within: float = JOIN_WITHIN) -> bool:
        """Wait for a device, not for ever."""
        with anyio.move_on_after(within):
            while name not in self.appeared:
                self.news = anyio.Event()
                await self.news.wait()
        return name in self.appeared

    async def until_noticed(self, name: str) -> None:
        """Wait until a death is noticed, not for ever."""
        with anyio.move_on_after(JOIN_WITHIN):
            while name not in self.noticed:
                self.news = anyio.Event()
                await self.news.wait()


async def measure(house_name: str, count: int, patience: float) -> None:
    """Let devices come and die."""
    async with (
        house_of(HOUSES[house_name]) as house,
        Node(house.graph, "watch") as node,
        anyio.create_task_group() as tasks,
    ):
        watch = Watch(node)
        tasks.start_soon(watch.follow)
        tasks.start_soon(watch.listen)
        await anyio.sleep(1.0)
        before = _traffic()
        times = await _come_and_go(house, watch, count)
        traffic = [(after - start) / count for start, after in zip(before, _traffic(), strict=True)]
        further = min(count, 20)
        memory, found = await _memory(house, watch, further)
        facts = {"times": times, "traffic": traffic, "memory": memory, "further": [found, further]}
        print(json.dumps(facts), flush=True)
        with anyio.move_on_after(patience):
            while len(watch.noticed) < len(times):
                watch.news = anyio.Event()
                await watch.news.wait()
        noticed = [found for name, found in watch.noticed.items() if name.startswith("bench")]
        print(json.dumps({"noticed": noticed}), flush=True)
        os._exit(0)  # all is measured; nobody needs an orderly end


async def _come_and_go(house: House, watch: Watch, count: int) -> list[float]:
    """Return the seconds until each device appeared that did."""
    times = []
    for number in range(count):
        name = f"bench{number:03}"
        started = time.perf_counter()
        joined = house.join(name)
        watch.expect(name, joined)
        if await watch.until_appeared(name):
            times.append(watch.appeared[name] - started)
            await anyio.sleep(SETTLE)
            watch.mourn(name)
        joined.cut_power()
        if house.is_for_one:
            await watch.until_noticed(name)
    return times


async def _memory(house: House, watch: Watch, count: int) -> tuple[float, int]:
    """Return the bytes that gateway and directory, and what they call, allocate for each further device; and how many
    of these were found.
    """
    gc.collect()
    tracemalloc.start(FRAMES)
    found = 0
    for number in range(count):
        name = f"extra{number:03}"
        joined = house.join(name)
        watch.expect(name, joined)
        found += await watch.until_appeared(name, TRACED_WITHIN)
        if house.is_for_one:
            watch.mourn(name)
            joined.cut_power()
            await watch.until_noticed(name)
    await anyio.sleep(1.0)
    gc.collect()
    snapshot = tracemalloc.take_snapshot()
    tracemalloc.stop()
    size = sum(trace.size for trace in snapshot.traces if _is_ours(trace.traceback))
    return size / max(1, found), found


def _is_ours(traceback: tracemalloc.Traceback) -> bool:
    files = {frame.filename for frame in traceback}
    return any(part in file for file in files for part in OURS) and not any(NOT_OURS in file for file in files)


def _traffic() -> tuple[int, int]:
    """Return bytes and packets on the loopback interface so far."""
    for line in Path("/proc/net/dev").read_text().splitlines():
        name, _, figures = line.partition(":")
        if name.strip() == "lo":
            numbers = figures.split()
            return int(numbers[0]), int(numbers[1])
    return 0, 0


if __name__ == "__main__":
    configure_logging(level="error")
    try:
        anyio.run(measure, sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
    except* UsageError as group:
        sys.exit(str(group.exceptions[0]))
