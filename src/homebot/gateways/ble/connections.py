"""Connections to devices with a declared profile: a few at once, opened one at a time, and reopened when lost.

While a device is connected, its notifications are reported, and it counts as present although it does not advertise. If
there are more devices than an adapter can connect to at once, they take turns. A command for a device without a
connection closes the least recently used one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskGroup
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream

from homebot.conventions.bluetooth.broadcast import full_uuid
from homebot.conventions.bluetooth.gatt_profile import GattProfile, GattState
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.ble.connection_slots import ConnectionSlots
from homebot.gateways.ble.intake import BluetoothUnavailableError
from homebot.gateways.ble.known_device import BATTERY, KnownDevice
from homebot.support.backoff import Backoff, BackoffCounter
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from homebot.gateways.ble.bleak_adapter import BleLink, BleRadio

COMMAND_WITHIN = 25.0
"""Seconds that a command waits for a connection."""

LASTED = 60.0
"""Seconds after which a connection that is lost counts as a first failure."""

POLL_EVERY = 10.0
"""Seconds between two reads of a device that does not notify."""

TURN = 10.0
"""Seconds after which a connection that is not in use is closed if another device waits for one."""

IN_USE = 60.0
"""Seconds after a command for which its connection is in use."""

IN_RANGE = 30.0
"""Seconds of silence after which a device is not connected to, unless there is a command for it."""

MAX_VALUES = 64
"""Notified values that wait to be read; more are dropped and counted as rejected messages."""

UNREACHABLE = "gateway.unreachable"

BATTERY_LEVEL = full_uuid("2a19")
DEVICE_INFORMATION = {
    "manufacturer": full_uuid("2a29"),
    "model": full_uuid("2a24"),
    "serial_number": full_uuid("2a25"),
    "firmware": full_uuid("2a26"),
    "hardware": full_uuid("2a27"),
}
_BACKOFF = Backoff(first=1.0, factor=2.0, cap=30.0, late_cap=120.0, late_after=300.0)
_MAX_CHARACTERS = 100
_FULL = 100


@dataclass(slots=True)
class _ManagedDevice:
    device: KnownDevice
    profile: GattProfile
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    state: GattState = field(default_factory=dict)
    link: BleLink | None = None
    commands: anyio.Lock = field(default_factory=anyio.Lock)
    wake: anyio.Event = field(default_factory=anyio.Event)
    used_at: float = float("-inf")
    preempted: bool = False
    on_closed: Callable[[], None] = lambda: None


class Connections:
    """The connections to devices with a profile."""

    def __init__(
        self,
        radio: BleRadio,
        devices: PublishedDevices,
        tasks: TaskGroup,
        most: int,
        *,
        on_described: Callable[[KnownDevice], None],
        on_unavailable: Callable[[], None],
    ) -> None:
        self._radio = radio
        gateway = devices.gateway
        self._owner, self._clock, self._random = gateway.node.full_name, gateway.node.graph.clock, gateway.random
        self._devices = devices
        self._tasks = tasks
        self._on_described = on_described
        self._on_unavailable = on_unavailable
        self._kept: dict[str, _ManagedDevice] = {}
        self._slots = ConnectionSlots(most, self._is_in_range)

    @property
    def connected(self) -> tuple[KnownDevice, ...]:
        """The devices that are connected."""
        return tuple(kept.device for kept in self._kept.values() if kept.link is not None)

    def connect(self, device: KnownDevice, *, is_back: bool) -> None:
        """Keep a connection to a device that has a profile.

        Args:
            is_back: Whether it was silent for a while: then the next attempt is made at once.
        """
        kept = self._kept.get(device.key)
        if kept is not None:
            if is_back:
                kept.wake.set()
                self._slots.notify()
        elif device.profile is not None:
            kept = _ManagedDevice(device, device.profile, state=device.profile.unknown_state())
            self._kept[device.key] = kept
            self._tasks.start_soon(run_as, self._owner, partial(self._run, kept))

    def close(self, key: str) -> None:
        """End the connection to a device, for good."""
        kept = self._kept.pop(key, None)
        if kept is not None:
            kept.scope.cancel()

    async def perform(self, key: str, capability: str, value: PlainValue) -> None:
        """Send a command, over the connection of the device or one that is opened for it.

        Raises:
            LinkError: The device cannot be reached.
            RefusedError: It refuses, or its profile has no frame for that.
        """
        kept = self._kept.get(key)
        if kept is None:
            raise RefusedError(capability, "the device only broadcasts")
        async with kept.commands:
            kept.used_at = self._clock.monotonic()
            link = kept.link or await self._connect_now(kept)
            state = dict(kept.state)
            for data in kept.profile.write_frames(capability, value, state):
                await link.write(kept.profile.command, data, response=kept.profile.response)
            kept.state = state
            if kept.profile.report and not link.has(kept.profile.reported_by, "notify", "indicate"):
                await self._report(kept, await link.read(kept.profile.reported_by))

    async def _connect_now(self, kept: _ManagedDevice) -> BleLink:
        key = kept.device.key
        self._slots.prefer(key)
        try:
            if self._slots.is_full_for(key):
                idle = [kept for kept in self._kept.values() if kept.link is not None and not kept.commands.locked()]
                if idle:
                    least = min(idle, key=lambda kept: kept.used_at)
                    least.preempted = True
                    if least.link is not None:
                        await least.link.close()
                    least.on_closed()  # some backends do not report a disconnection that was asked for
            kept.wake.set()
            with anyio.move_on_after(COMMAND_WITHIN):
                while kept.link is None and key in self._kept:
                    await self._slots.changed()
        finally:
            self._slots.unprefer(key)
        if kept.link is None:
            raise LinkError(f"{key} cannot be reached: no connection was made within {COMMAND_WITHIN:g} seconds")
        return kept.link

    async def _run(self, kept: _ManagedDevice) -> None:
        """Connect whenever there is a slot, until cancelled."""
        key = kept.device.key
        retries = BackoffCounter(self._clock, self._random, LASTED)
        with kept.scope:
            while True:
                await self._slots.acquire(key)
                kept.wake = anyio.Event()
                kept.preempted = False
                retries.begin()
                try:
                    await self._connected(kept)
                except BluetoothUnavailableError:
                    self._on_unavailable()
                except (LinkError, RefusedError) as exc:
                    self._devices.engine.quarantine.log_limited(UNREACHABLE, f"{key}: {exc}", source="")
                finally:
                    kept.link = None
                    self._slots.release(key)
                if kept.preempted:
                    retries.succeed()
                    continue
                self._devices.report_reachable(key, reachable=False)
                with anyio.move_on_after(retries.fail(_BACKOFF)):
                    await kept.wake.wait()

    def _is_in_range(self, key: str) -> bool:
        kept = self._kept.get(key)
        return kept is not None and self._clock.monotonic() - kept.device.presence.last_heard <= IN_RANGE

    async def _connected(self, kept: _ManagedDevice) -> None:
        """Connect, and return when the connection is lost or given to another device."""
        values_in, values = anyio.create_memory_object_stream[tuple[str, bytes]](MAX_VALUES)
        kept.on_closed = values_in.close
        link: BleLink | None = None
        try:
            link = await self._radio.connect(kept.device.address, values_in.close)
            self._slots.opened(kept.device.key)
            if not link.has(kept.profile.command):
                raise RefusedError(kept.device.key, f"it has no characteristic {kept.profile.command}")
            await self._learn(kept, link, values_in)
            kept.link = link
            self._devices.report_reachable(kept.device.key, reachable=True)
            self._slots.notify()
            async with values:
                await self._listen(kept, link, values)
        finally:
            kept.link = None
            values_in.close()
            values.close()
            if link is not None:
                await link.close()

    async def _learn(
        self, kept: _ManagedDevice, link: BleLink, values_in: MemoryObjectSendStream[tuple[str, bytes]]
    ) -> None:
        """Read the device information, the battery and the state of a device, and subscribe to changes."""
        for fact, characteristic in DEVICE_INFORMATION.items():
            if link.has(characteristic, "read"):
                text = (await link.read(characteristic)).decode(errors="replace").strip("\0 ")
                if text.isprintable() and text:
                    kept.device.connected_facts[fact] = text[:_MAX_CHARACTERS]
        kept.device.has_battery = link.has(BATTERY_LEVEL, "read")
        self._on_described(kept.device)
        for characteristic in (BATTERY_LEVEL, *((kept.profile.reported_by,) if kept.profile.report else ())):
            if link.has(characteristic, "notify", "indicate"):
                await link.subscribe(characteristic, partial(self._put, values_in, characteristic))
            if link.has(characteristic, "read"):
                self._put(values_in, characteristic, await link.read(characteristic))

    def _put(self, values_in: MemoryObjectSendStream[tuple[str, bytes]], characteristic: str, data: bytes) -> None:
        try:
            values_in.send_nowait((characteristic, data))
        except anyio.WouldBlock:
            self._devices.reject("", data, "it notifies faster than it can be read")
        except (anyio.ClosedResourceError, anyio.BrokenResourceError):
            return  # the connection was lost

    async def _listen(
        self, kept: _ManagedDevice, link: BleLink, values: MemoryObjectReceiveStream[tuple[str, bytes]]
    ) -> None:
        is_polled = bool(kept.profile.report) and not link.has(kept.profile.reported_by, "notify", "indicate")
        opened = self._clock.monotonic()
        while link.is_open:
            now = self._clock.monotonic()
            is_in_use = kept.commands.locked() or now - kept.used_at < IN_USE
            if self._slots.is_wanted and not is_in_use and now - opened >= TURN:
                kept.preempted = True
                return
            received: tuple[str, bytes] | None = None
            with anyio.move_on_after(POLL_EVERY):
                try:
                    received = await values.receive()
                except anyio.EndOfStream:
                    return
            if received is None and is_polled:
                received = kept.profile.reported_by, await link.read(kept.profile.reported_by)
            if received is not None and received[0] == BATTERY_LEVEL:
                await self._report_battery(kept.device.key, received[1])
            elif received is not None:
                await self._report(kept, received[1])

    async def _report_battery(self, key: str, data: bytes) -> None:
        if len(data) != 1 or data[0] > _FULL:
            self._devices.reject(key, data, "its battery level is not 0 to 100 percent")
            return
        await self._devices.report(key, {"battery": float(data[0])}, BATTERY)

    async def _report(self, kept: _ManagedDevice, data: bytes) -> None:
        key = kept.device.key
        try:
            values = kept.profile.read(data, kept.state)
        except WireError as exc:
            self._devices.reject(key, data, str(exc))
            return
        await self._devices.deliver_raw(key, data)
        await self._devices.report(key, values, "")
