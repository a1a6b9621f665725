"""Watches the sensors of a home, and what is switched near them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final, final

import anyio

from homebot.clock import TimeSlice
from homebot.control.witnesses.activity import Place, RecentActivity
from homebot.control.witnesses.command_watch import CommandWatch
from homebot.control.witnesses.effect import ACTING, SENSED
from homebot.control.witnesses.finding import QUIET
from homebot.control.witnesses.home_state import HomeState
from homebot.control.witnesses.sensors import WitnessSensors, reading_of
from homebot.devices import DEVICE_CHANGES, DEVICE_STATES, FIND_DEVICES, Device, DeviceChange, FindDevices, StateChange
from homebot.devices.names import DIRECTORY_NODE
from homebot.devices.query import CanDo, Or, Query, query_terms
from homebot.devices.services import FindDevicesRequest
from homebot.devices.value import PlainValue
from homebot.errors import ServiceError
from homebot.graph import Node, Subscription

__all__ = ["HomeWatch"]

_PAUSE: Final = 0.5
"""Seconds in which changes of devices are gathered: to look at them together costs a busy house next to nothing."""

_DEPTH: Final = 100
"""Changes of a stream; the newest of each is never lost."""


@final
class HomeWatch:
    """Follows the sensors that may witness commands; what devices report is taken from the first of them on.

    Args:
        node: The node that follows.
        named: Queries, each with the sensor that the owner names; see `WitnessSensors`.
        settle: Seconds that something switched needs until sensors rest, where nothing better is known.

    Attributes:
        sensors: The sensors.
        activity: What was switched lately.
        on_change: Called with each change of what may change what sensors measure: part, capability and new value.
    """

    on_change: Callable[[Place, str, PlainValue], None]

    def __init__(self, node: Node, named: Iterable[tuple[Query, str]], settle: float) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settle = settle
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._watches: dict[str, CommandWatch] = {}
        self._states: Subscription[StateChange] | None = None
        self.sensors = WitnessSensors(named)
        self.activity = RecentActivity()
        self.on_change = _ignore

    def add(self, watch: CommandWatch) -> None:
        """Wake *watch* with each report of its sensors, until :meth:`discard`."""
        self._watches[watch.command.id] = watch

    def discard(self, command_id: str) -> None:
        """Wake a watch no more; one that is not there is fine."""
        self._watches.pop(command_id, None)

    async def state(self, watch: CommandWatch) -> HomeState:
        """Return what is known of the home now, with the devices that bear on *watch*."""
        lately = self.activity.since(watch.began - QUIET - self._settle, watch.command.id)
        ids = {watch.command.device.id, *(one.device.id for one in watch.marks), *(place[0] for _, place in lately)}
        return await self.state_of(ids)

    async def state_of(self, ids: Iterable[str]) -> HomeState:
        """Return what is known of the home now, with the devices *ids*."""
        devices = await self._devices(ids)
        return HomeState(self.activity, devices, self._clock.monotonic(), self._clock.now())

    async def run(self) -> None:
        """Follow the sensors until cancelled."""
        changes = self._node.create_subscription(DeviceChange, DEVICE_CHANGES, qos_profile=1, from_node=DIRECTORY_NODE)
        await self._find.wait_for_service()
        sensed = Or(tuple(CanDo(one) for one in sorted(SENSED)))
        try:
            found = (await self._find.call(FindDevicesRequest(query=query_terms(sensed)))).devices
        except ServiceError:
            found = ()  # they are told of when they change
        for device in found:
            if device.id not in self.sensors.ids:
                self._put(device)
        while True:
            await changes.mailbox.wait()
            await anyio.sleep(_PAUSE)
            work = TimeSlice(self._clock)
            while (change := changes.take()) is not None:
                self._change(change)
                if work.is_over:
                    await work.pause()

    def _change(self, change: DeviceChange) -> None:
        device = change.device
        if change.kind != "removed":
            for part in device.parts:
                if any(one.name in SENSED for one in part.part.capabilities):
                    self._put(device)
                    return
        if device.id in self.sensors.ids:
            self.sensors.remove(device.id)

    def _put(self, device: Device) -> None:
        self.sensors.put(device, self._clock.monotonic())
        if self.sensors.ids and self._states is None:
            self._states = self._node.create_subscription(
                StateChange, DEVICE_STATES, self._take, _DEPTH, from_node=DIRECTORY_NODE
            )

    async def _devices(self, ids: Iterable[str]) -> dict[str, Device]:
        """Return the devices with *ids*; none where the directory does not answer."""
        try:
            found = await self._find.call(FindDevicesRequest(ids=tuple(sorted(ids))))
        except ServiceError:
            return {}
        return {one.id: one for one in found.devices}

    def _take(self, change: StateChange) -> None:
        if not change.live or change.is_event:
            return
        now = self._clock.monotonic()
        for reading in change.readings:
            sensor = self.sensors[change.device, reading.part, reading.capability]
            value = None if sensor is None else reading_of(reading.value.plain())
            if sensor is not None and value is not None:
                sensor.history.note(value, now)
                for watch in self._watches.values():
                    if sensor in watch.marks:
                        watch.wake()
            if reading.capability in ACTING:
                place = change.device, reading.part
                self.activity.note(place, now)
                self.on_change(place, reading.capability, reading.value.plain())


def _ignore(_place: Place, _capability: str, _value: PlainValue) -> None:
    pass
