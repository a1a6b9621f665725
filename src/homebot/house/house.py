"""A world on its networks: one loop advances the world, and each of its devices is a client or a server."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from random import Random
from types import MappingProxyType
from typing import ClassVar

import anyio
from anyio.abc import TaskStatus
from anyio.lowlevel import checkpoint

from homebot.clock import Clock
from homebot.errors import UsageError
from homebot.house.connected_device import ConnectedDevice
from homebot.house.dialect import BridgeDialect, DeviceState, Dialect, SimulatedDeviceInfo, state_of
from homebot.house.event_log import Event
from homebot.house.family import family_names, family_of
from homebot.house.faults import unwrap
from homebot.house.mqtt_device import HouseCounters, MqttDevice
from homebot.house.network import HouseNetwork
from homebot.house.simulated_device import Placed
from homebot.house.world import World
from homebot.log import LogLimit
from homebot.mqtt.client import MqttClient
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Will
from homebot.mqtt.topics import validate_filter
from homebot.support.isolation import run_as

HEARTBEAT = 2.0
"""Seconds between heartbeats, short enough to watch."""

TICK = 1e-6
"""Seconds within which an event counts as due, because loop timers cannot wait for less."""

STRIDE = 3600.0
"""Most seconds of the world in one turn of the loop, after a clock was set or a computer slept."""

MIN_KEEP_ALIVE_S = 30
MAX_KEEP_ALIVE_S = 65_535


class SimulatedHouse:
    """Connects a world to a broker.

    The world's first day is the day, in UTC, on which the house is created: its time is the clock's since that day's
    midnight, or has its own pace (:class:`~homebot.house.rooms.WorldTime`). Earlier events of that day are not
    published, but determine the initial states. A world that has already run for some days continues with the next.

    Args:
        url: The broker, ``mqtt://host:port``.
        home: First level of the devices' topics.
        world: The world, which only this object may advance.
        random: Source of the jitter of reconnects, seeded for reproducible runs.
        heartbeat: Seconds after which devices repeat their last state, as real ones do.
        dialects: Families of devices on MQTT by the names used in the world, besides the installed ones.
        network: The networks of served families; by default its own.

    Attributes:
        Host: The class of the service that can host one.
        WITHOUT_HOST: Why no gateway of a configuration can, in words.

    Raises:
        UsageError: The heartbeat is not above 0, a device's name is not valid on MQTT, or a dialect, or its kind of
            device, does not exist.
    """

    Host: ClassVar[type[HostedBroker]] = HostedBroker
    WITHOUT_HOST: ClassVar[str] = (
        "none uses the embedded broker; give that of the simulated house by --mqtt, or add [gateways.mqtt] without url"
    )

    def __init__(
        self,
        url: str,
        home: str,
        world: World,
        clock: Clock,
        *,
        make_client: Callable[[MqttOptions], MqttClient] = NativeClient,
        random: Random | None = None,
        heartbeat: float = HEARTBEAT,
        dialects: Mapping[str, Dialect] = MappingProxyType({}),
        network: HouseNetwork | None = None,
    ) -> None:
        if not heartbeat > 0:
            raise UsageError(f"a heartbeat of {heartbeat:g} s is not above 0")
        self.world = world
        self.counters = HouseCounters()
        self._url = url
        self._home = home
        self._clock = clock
        self._make_client = make_client
        self._random = Random() if random is None else random  # noqa: S311 - jitter is no secret
        self._heartbeat = heartbeat
        families = ((name, family_of(name)) for name in world.families())
        self._dialects = {name: family for name, family in families if isinstance(family, Dialect)} | dict(dialects)
        self._lines = LogLimit(clock)
        self._midnight = world.time.first_midnight(clock.now(), world.now)
        self._changed = anyio.Event()
        self._is_served = False
        infos = {name: self._device_info(placed) for name, placed in world.devices.items()}
        self._network = network or HouseNetwork(world.families())
        self._devices = {name: self._connect(infos[name], placed.dialect) for name, placed in world.devices.items()}
        self._bridges = self._bound(world, infos)

    @classmethod
    def hosted_by(
        cls,
        host: HostedBroker,
        home: str,
        world: World,
        clock: Clock,
        *,
        random: Random | None = None,
        network: HouseNetwork | None = None,
    ) -> SimulatedHouse:
        """Return a house whose devices connect to the broker of *host*; further arguments as for the class."""
        make_client = host.make_client or NativeClient
        return cls(host.url, home, world, clock, make_client=make_client, random=random, network=network)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Run the house until cancelled."""
        self.world.run_until(self._now())
        for name, connected in self._devices.items():
            device = self.world.device(name)
            connected.begin(self._state_of(name, device.state()), has_power=device.has_power)
        self._is_served = True
        async with anyio.create_task_group() as tasks:
            for client in (*self._bridges, *self._devices.values()):
                tasks.start_soon(run_as, "a simulated device", client.live)
            tasks.start_soon(run_as, "the simulated house", self._beat)
            task_status.started()
            await self._move()

    def catch_up(self) -> None:
        """Advance the world to the present, or by an hour, without publishing anything."""
        if self._is_served:
            self._show(self.world.run_until(self._within_reach()))

    def command(self, device_id: str, command: str, command_id: str = "") -> None:
        """Give *command*, which may have an id, to a device, as its radio does.

        Raises:
            UsageError: There is no such device.
        """
        self._show(self.world.command(device_id, command, self._within_reach(), command_id))
        self._changed.set()

    def press(self, device_id: str, command: str) -> None:
        """Operate a device by hand, with the effect of *command*.

        Raises:
            UsageError: There is no such device.
        """
        self._show(self.world.press(device_id, command, self._within_reach()))
        self._changed.set()

    async def _move(self) -> None:
        while True:
            self.catch_up()
            self._changed = anyio.Event()
            wait = (self.world.next_event() - self._now()) / self.world.time.pace
            if wait > TICK:
                alarm = asyncio.get_running_loop().call_later(wait, self._changed.set)
                try:
                    await self._changed.wait()
                finally:
                    alarm.cancel()
            else:
                await checkpoint()

    async def _beat(self) -> None:
        while True:
            await anyio.sleep(self._heartbeat)
            for name, device in self._devices.items():
                reports = self.world.device(name).heartbeat()
                if reports is None:
                    device.repeat()
                else:
                    for text in reports:
                        device.publish(self._state_of(name, text))

    def _now(self) -> float:
        return (self._clock.now() - self._midnight) * self.world.time.pace

    def _within_reach(self) -> float:
        now, due = self._now(), self.world.next_event()
        return min(due if now < due <= now + TICK * self.world.time.pace else now, self.world.now + STRIDE)

    def _show(self, events: Iterable[Event]) -> None:
        for event in events:
            if event.verb == "says":
                self._devices[event.who].publish(self._state_of(event.who, event.what))
            elif event.verb == "power":
                self._devices[event.who].power(on=event.what == "on")

    def _state_of(self, name: str, text: str) -> DeviceState:
        return state_of(unwrap(self.world.device(name)), text)

    def _device_info(self, placed: Placed) -> SimulatedDeviceInfo:
        device = placed.device
        family = self._dialects.get(placed.dialect) or family_of(placed.dialect)
        if family is None:
            known = ", ".join((*family_names(), *self._dialects))
            raise UsageError(f"{device.device_id!r} speaks {placed.dialect!r}; known are {known}")
        kind = unwrap(device).kind
        if kind not in family.kinds:
            raise UsageError(f"{device.device_id!r} speaks {placed.dialect!r}, which has no {kind}")
        return SimulatedDeviceInfo(
            self._home, kind, device.device_id, device.service_type, placed.room, unwrap(device).commands()
        )

    def _bound(self, world: World, infos: Mapping[str, SimulatedDeviceInfo]) -> list[MqttDevice]:
        """Return the bridges of the families with one in this house."""
        bridges = []
        for name in world.families():
            if name not in self._dialects:
                continue
            bound = [infos[device_id] for device_id, placed in world.devices.items() if placed.dialect == name]
            if (bridge := self._dialects[name].bridge(bound)) is not None:
                info = SimulatedDeviceInfo(self._home, "bridge", f"{name} bridge", "bridge", "")
                bridges.append(self._mqtt_device(info, BridgeDialect(bridge)))
        return bridges

    def _connect(self, info: SimulatedDeviceInfo, family: str) -> ConnectedDevice:
        if family in self._dialects:
            return self._mqtt_device(info, self._dialects[family])
        return self._network.connect(family, info, partial(self.command, info.device_id))

    def _mqtt_device(self, info: SimulatedDeviceInfo, dialect: Dialect) -> MqttDevice:
        for topic in (*dialect.filters(info), *(message.topic for message in dialect.birth(info))):
            validate_filter(topic)
        will = dialect.will(info)
        options = MqttOptions.from_url(
            self._url,
            client_id=f"{self._home}-{info.device_id}",
            # A client that publishes this often needs few pings.
            keep_alive=math.ceil(min(max(MIN_KEEP_ALIVE_S, 12 * self._heartbeat), MAX_KEEP_ALIVE_S)),
            will=None if will is None else Will(will.topic, will.payload, will.qos, will.retain),
        )
        connection = MqttConnection(
            options, self._make_client, status_topic=None, clock=self._clock, random=self._random
        )
        return MqttDevice(info, dialect, connection, partial(self.command, info.device_id), self.counters, self._lines)
