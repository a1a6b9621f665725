"""A day on the network, in virtual time."""

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from functools import partial

from homebot.errors import LinkError, UsageError
from homebot.house.world import World
from homebot.mqtt.client.memory_transport import MemoryLink
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing.day import Day
from homebot.testing.day_event import DayEvent, write_time
from homebot.testing.virtual_house import HEARTBEAT, START, VirtualHouse, parse_time, virtual_house_of

ROOT = "home425"


def live_day(day: Day, *apps: str, root: str = ROOT, seed: int = 0, heartbeat: str | float = HEARTBEAT) -> World:
    """Play *day* with *apps* on the network, in virtual time, from a test without ``async``.

    Args:
        apps: Plug-in names or ``module:Class``.
        seed: The seed of random numbers on the network; the same day and seed give the same run.

    Returns:
        The house at the end of the day, with its ``event log``.

    Raises:
        AssertionError: An app crashed.
        UsageError: An argument is invalid, or the test has ``async`` and should ``await day.live(house)``.
    """
    _need_no_loop()

    async def lived() -> World:
        world = day.world()
        world.run_until(day.start)  # earlier events are not published
        start = parse_time(START) + timedelta(seconds=day.start)
        async with virtual_house_of(
            *apps, world=world, root=root, start=start, seed=seed, heartbeat=heartbeat
        ) as house:
            await live(day, house, root=root)
            if house.crashed:
                raise AssertionError(f"crashed: {', '.join(house.crashed)}")
        return world

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(lived())


async def live(day: Day, house: VirtualHouse, *, root: str = ROOT) -> tuple[DayEvent, ...]:
    """Play *day* in *house*; see :meth:`homebot.testing.day.Day.live`."""
    midnight = house.now.replace(hour=0, minute=0, second=0, microsecond=0)
    start = midnight + timedelta(seconds=day.start)
    if house.now > start:
        raise UsageError(f"the day begins at {write_time(day.start)}, but the house is already at {house.now:%H:%M:%S}")
    if missing := {happening.device for happening in day.happenings if happening.device} - set(house.world.devices):
        raise UsageError(f"there is no device {min(missing)!r} in the house")
    wire = _Wire(house, root)
    undone = []
    for at, event, act in _plan(day, wire):
        await _sleep_until(house, midnight + timedelta(seconds=at))
        if not await act():
            undone.append(event)
        await house.settle()
    await _sleep_until(house, midnight + timedelta(seconds=day.end))
    return tuple(undone)


@dataclass(eq=False)
class _Wire:
    """The acts of a day in a house. Each returns whether it had an effect."""

    house: VirtualHouse
    root: str
    frozen: Counter[MemoryLink] = field(default_factory=Counter)
    outages: int = 0
    forget: bool = False

    async def press(self, event: DayEvent) -> bool:
        self.house.simulated.press(event.device, event.command)  # random days also press missing devices
        await self.house.settle()
        return True

    async def send(self, event: DayEvent) -> bool:
        service_type = self.house.world.devices[event.device].device.service_type
        try:
            await self.house.says(f"{self.root}/{service_type}/{event.device}/in", event.command)
        except LinkError:
            return False
        return True

    async def cut(self, event: DayEvent) -> bool:
        link = self._link(event.device)
        if link is not None:
            link.abort()
        return link is not None

    async def pull(self, event: DayEvent, links: list[MemoryLink]) -> bool:
        link = self._link(event.device)
        if link is None:
            return False
        self.frozen[link] += 1
        link.freeze()
        links.append(link)
        return True

    async def plug_in(self, links: list[MemoryLink]) -> bool:
        for link in links:
            self.frozen[link] -= 1
            if not self.frozen[link]:
                link.thaw()
        return True

    async def stop(self, event: DayEvent) -> bool:
        self.outages += 1
        self.forget |= event.forget
        await self.house.broker.stop()
        return True

    async def start(self) -> bool:
        self.outages -= 1
        if not self.outages:
            await self.house.broker.restart(keep_sessions=not self.forget)
            self.forget = False
        return True

    def _link(self, device: str) -> MemoryLink | None:
        name = f"{self.root}-{device}"
        return next((link for link in self.house.broker.links if link.peer.client_id == name), None)


_Step = tuple[float, DayEvent, Callable[[], Awaitable[bool]]]


def _plan(day: Day, wire: _Wire) -> list[_Step]:
    """Return the acts with their times; lasting ones end with the day at the latest."""
    steps: list[_Step] = []
    for event in day.happenings:
        ends = min(event.at + event.lasts, day.end)
        match event.what:
            case "press":
                steps.append((event.at, event, partial(wire.press, event)))
            case "tell":
                steps.append((event.at, event, partial(wire.send, event)))
            case "cut":
                steps.append((event.at, event, partial(wire.cut, event)))
            case "pull":
                links: list[MemoryLink] = []
                steps.append((event.at, event, partial(wire.pull, event, links)))
                steps.append((ends, event, partial(wire.plug_in, links)))
            case "restart":
                steps.append((event.at, event, partial(wire.stop, event)))
                steps.append((ends, event, wire.start))
    return sorted(steps, key=lambda step: step[0])


def _need_no_loop() -> None:
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return
    raise UsageError("live_day is for tests without async; in a house of your own: await day.live(house)")


async def _sleep_until(house: VirtualHouse, moment: datetime) -> None:
    if moment > house.now:
        await house.run_until(moment)
