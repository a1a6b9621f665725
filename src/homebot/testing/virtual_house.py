"""A house in a test with virtual time: a day passes in well under a second."""

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from random import Random

import anyio

from homebot.clock import LoopClock
from homebot.config import Config
from homebot.errors import UsageError
from homebot.feature_context import RunObserver
from homebot.gateways.mqtt.settings import EMBEDDED
from homebot.house import SimulatedHouse, World
from homebot.house.family import family_of
from homebot.house.faults import unwrap
from homebot.house.simulated_device import Placed
from homebot.mqtt.broker import BrokerLimits
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime
from homebot.runtime.simulated_house import identifiers
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing.contexts import in_background, plain_logs
from homebot.testing.house import DEFAULT_WAIT, EVERYTHING, TestHouse, house_config
from homebot.units import parse_duration
from homebot.words.times import read_time


def parse_time(when: str | datetime) -> datetime:
    """Parse a point in time; return it in UTC.

    Args:
        when: A date-time, or a text such as ``2026-01-01`` or ``2026-01-01 22:00``; UTC without a time zone.

    Raises:
        UsageError: It is invalid.
    """
    if isinstance(when, str):
        try:
            when = datetime.fromisoformat(when.strip())
        except ValueError:
            raise UsageError(f"{when!r} is not a time; write it like 22:00 or 2026-01-01 22:00") from None
    return when.replace(tzinfo=UTC) if when.tzinfo is None else when.astimezone(UTC)


def next_moment(now: datetime, when: str | datetime) -> datetime:
    """Return the next point in time described by *when*, later than *now*.

    Args:
        now: The present, in UTC.
        when: As for :func:`parse_time`, or a time of day in UTC such as ``22:00`` or ``22:00:30``; tomorrow's if it is
            that time now.

    Raises:
        UsageError: It is invalid or in the past.
    """
    with suppress(UsageError):
        moment = datetime.combine(now, read_time(when), now.tzinfo)
        return moment if moment > now else moment + timedelta(days=1)
    moment = parse_time(when)
    if moment < now:
        raise UsageError(f"{moment:%Y-%m-%d %H:%M:%S} is in the past: the house is at {now:%Y-%m-%d %H:%M:%S}")
    return moment


START = "2026-01-01 00:00"
"""Default start of time in a virtual house, in UTC."""

HEARTBEAT = 300.0
"""Seconds after which a simulated device repeats its last state: as mains-powered devices do, and little work."""

_KEEP_ALIVE = 3_600
_SHOWN = 60


class VirtualHouse(TestHouse):
    """A :class:`TestHouse` in virtual time and without sockets; time passes only while the test waits.

    Attributes:
        broker: The broker; tests may stop it, or cut and freeze connections.
        simulated: The simulated house, which connects the devices of ``world`` to the broker.
    """

    def __init__(
        self,
        runtime: Runtime,
        field: MqttConnection,
        options: MqttOptions,
        broker: MemoryBroker,
        clock: LoopClock,
        simulated: SimulatedHouse,
    ) -> None:
        super().__init__(runtime, field, options, broker.make_client)
        self.broker = broker
        self.clock = clock
        self.simulated = simulated

    @property
    def world(self) -> World:
        """The simulated world, read-only for tests."""
        return self.simulated.world

    @property
    def now(self) -> datetime:
        """The date and time in the house, in UTC."""
        return datetime.fromtimestamp(self.clock.now(), UTC)

    async def run_for(self, duration: str | float) -> None:
        """Let time pass; on return, all events due by then have happened.

        Args:
            duration: Such as ``"90s"``, ``"8h"`` or ``"1h30m"``; a number is seconds.

        Raises:
            UsageError: *duration* is not a duration.
        """
        __tracebackhide__ = True
        await anyio.sleep(parse_duration(duration))
        await self.settle()

    async def run_until(self, when: str | datetime) -> None:
        """Let time pass until *when*; on return, all events due by then have happened.

        Args:
            when: A time of day in UTC, such as ``"22:00"``: the next one; or a date-time, such as
                ``"2026-01-02 07:30"``.

        Raises:
            UsageError: *when* is not a time, or has passed.
        """
        __tracebackhide__ = True
        moment = next_moment(self.now, when)
        await anyio.sleep(max(0.0, moment.timestamp() - self.clock.now()))
        await self.settle()

    async def press(self, device_id: str, command: str) -> None:
        """Operate a simulated device by hand; return after its immediate effects.

        Raises:
            UsageError: There is no such device or command; the message lists the existing ones.
        """
        __tracebackhide__ = True
        placed = self._place(device_id)
        if not placed.device.knows(command):
            known = ", ".join(placed.device.commands()) or "nothing by hand"
            raise UsageError(f"{device_id} does not know {command[:_SHOWN]!r}; it takes: {known}")
        self.simulated.press(device_id, command)
        await self.settle()

    async def sense(self, device_id: str, **values: bool | float) -> None:
        """Let a simulated sensor sense a value until the next one; return after its immediate effects.

        Args:
            values: One value, by the property of its handle: ``occupied=True``, ``is_open=False``, ``lux=12``,
                ``watts=140`` or, of a thermostat, ``temperature=17.5``.

        Raises:
            UsageError: There is no such device, or it does not sense this; the message lists what it senses.
        """
        __tracebackhide__ = True
        device = unwrap(self._place(device_id).device)
        word, kind = device.senses or ("nothing", bool)
        given = ", ".join(f"{name}={value!r}" for name, value in values.items())
        fits = [*values] == [word] and isinstance(values[word], bool) is (kind is bool)
        if not fits:
            example = "True or False" if kind is bool else "a number"
            known = f"{word}={example}" if device.senses else word
            raise UsageError(f"{device_id} cannot sense {given or 'nothing'}; it senses {known}")
        self.simulated.press(device_id, device.sensing(float(values[word])))
        await self.settle()

    async def becomes(self, device: str, *, within: str | float = DEFAULT_WAIT, **values: object) -> None:
        """Return once *device* has *values*; like :meth:`TestHouse.becomes`, in the time of the house."""
        __tracebackhide__ = True
        await super().becomes(device, within=within, **values)
        await self.settle()

    def _place(self, device_id: str) -> Placed:
        __tracebackhide__ = True
        placed = self.world.devices.get(device_id)
        if placed is None:
            there = ", ".join(self.world.devices) or "none"
            raise UsageError(f"there is no device {device_id!r}; in the house are: {there}")
        return placed

    async def settle(self) -> None:
        """Wait until everything due now has happened, without passing time."""
        self.simulated.catch_up()
        await _virtual_loop().settled()


@asynccontextmanager
async def virtual_house_of(
    *apps: str,
    world: World | None = None,
    root: str = "home425",
    start: str | datetime = START,
    seed: int = 0,
    heartbeat: str | float = HEARTBEAT,
    config: Config | Mapping[str, object] | None = None,
    observers: Mapping[str, RunObserver] | None = None,
    is_dry_run: bool = False,
) -> AsyncIterator[VirtualHouse]:
    """Run *apps* in a homebot like :func:`homebot.testing.house_of`, on a :class:`VirtualTimeLoop`.

    Args:
        world: A simulated world in it, from the midnight before *start*; the test may play other devices.
        start: The date and time at which the test starts; UTC without a time zone.
        seed: The seed of all random numbers; the same test and seed give the same run.
        heartbeat: The time after which a simulated device repeats its last report.
        observers: Functions that observe the run from before its apps until after them, by name.

    Raises:
        UsageError: The running event loop is not virtual, or an argument or the configuration is invalid.
    """
    _virtual_loop()
    world = _on_a_broker(world)
    clock, random = LoopClock(parse_time(start).timestamp()), Random(seed)  # noqa: S311 - a simulation has no secrets
    with plain_logs(clock):
        async with MemoryBroker(clock=clock, random=random, limits=_limits(len(world.devices))) as broker:
            runtime = Runtime(
                _with_rooms(house_config(apps, root, EMBEDDED, config), world, root),
                with_door=False,
                clock=clock,
                services=[HostedBroker.in_memory(broker)],
                random=random,
                trusts_apps=True,
                observers=observers or {},
                is_dry_run=is_dry_run,
            )
            for mistake in runtime.app_host.left_out.values():
                raise mistake
            async with runtime, _inhabit(runtime, broker, clock, world, root, parse_duration(heartbeat)) as house:
                yield house


def _on_a_broker(world: World | None) -> World:
    if world is None:
        return World.of()
    if not isinstance(world, World):
        raise UsageError(f"world is a World, such as load_world(Path('house.toml')) returns, got {world!r}")
    if served := [name for name in world.families() if isinstance(family_of(name), type)]:
        raise UsageError(f"world: {', '.join(served)} needs a network, and a virtual house has a broker alone")
    return world


@asynccontextmanager
async def _inhabit(
    runtime: Runtime, broker: MemoryBroker, clock: LoopClock, world: World, root: str, heartbeat: float
) -> AsyncIterator[VirtualHouse]:
    random, make_client = runtime.random, broker.make_client
    options = MqttOptions.from_url(broker.url, client_id="test", keep_alive=_KEEP_ALIVE)
    async with MqttConnection(options, make_client, status_topic=None, clock=clock, random=random) as field:
        await field.subscribe(EVERYTHING)
        await field.wait_connected()
        simulated = SimulatedHouse(
            broker.url, root, world, clock, make_client=make_client, random=random, heartbeat=heartbeat
        )
        house = VirtualHouse(runtime, field, options, broker, clock, simulated)
        async with in_background(house.listen, simulated.serve):
            await house.settle()
            yield house


def _with_rooms(config: Config, world: World, root: str) -> Config:
    """Return *config* with the names and rooms of the devices of *world*, unless it has places of its own."""
    if config.places:
        return config
    devices = {
        name: {"room": placed.room, "aliases": [name], "identifiers": identifiers(placed, root)}
        for name, placed in world.devices.items()
    }
    return config.model_copy(update={"places": {"devices": devices}})


def _limits(devices: int) -> BrokerLimits:
    """Return the limits of a broker with *devices* and the usual other clients."""
    usual = BrokerLimits()
    return replace(
        usual, max_connections=usual.max_connections + devices, max_sessions=usual.max_sessions + 2 * devices
    )


def _virtual_loop() -> VirtualTimeLoop:
    loop = asyncio.get_running_loop()
    if not isinstance(loop, VirtualTimeLoop):
        raise UsageError(
            "a virtual house needs a loop of virtual time: asyncio.Runner(loop_factory=VirtualTimeLoop).run(...), "
            "with VirtualTimeLoop from homebot.testing"
        )
    return loop
