"""Connections to devices with a declared profile: a few at once, made one after the other, and made again when lost.

While one stands, what the device notifies is reported, and it counts as present although it does not advertise. A
device that has none because there are no more to be had gets one for its next command, in place of that which was used
least.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from functools import partial
from random import Random
from typing import Protocol

import anyio
from anyio.abc import TaskGroup
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream

from homebot.clock import Clock
from homebot.conventions.bluetooth.advertisement import full_uuid
from homebot.conventions.bluetooth.gatt_profile import GattProfile, GattState
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.ble.known_device import BATTERY, KnownDevice
from homebot.gateways.ble.radio import BleLink, BleRadio, BluetoothUnavailableError
from homebot.isolation import run_as
from homebot.mqtt.backoff import Backoff

__all__ = ["ConnectionHost", "Connections"]

COMMAND_WITHIN = 25.0
"""Seconds that a command waits for a connection."""

LASTED = 60.0
"""Seconds for which a connection has stood that did not fail."""

POLL_EVERY = 10.0
"""Seconds between two readings of a device that does not notify."""

MAX_VALUES = 64
"""Notified values that wait; what is above is dropped, and the state read again."""

BATTERY_LEVEL = full_uuid("2a19")
DEVICE_INFORMATION = {
    "manufacturer": full_uuid("2a29"),
    "model": full_uuid("2a24"),
    "serial_number": full_uuid("2a25"),
    "firmware": full_uuid("2a26"),
    "hardware": full_uuid("2a27"),
}
_BACKOFF = Backoff(first=1.0, factor=2.0, cap=30.0, late_cap=120.0, late_after=300.0)
_LONGEST = 100
_FULL = 100


class ReportReachable(Protocol):
    """Publishes whether a device can be reached."""

    def __call__(self, key: str, *, reachable: bool | None) -> None: ...


@dataclass(frozen=True, slots=True)
class ConnectionHost:
    """The gateway, as connections see it.

    Attributes:
        owner: Its name, for errors.
        clock: Its clock.
        random: Its source of random numbers.
        described: Called when more is known of a device.
        report: Called with values of a part of a device, by key.
        deliver_raw: Called with what a device notified.
        reject: Called with what breaks its profile, and why.
        reachable: Called with whether a device can be reached; None for unknown.
        unavailable: Called when there is no adapter any more.
        failed: Called with the reason for which a connection failed.
    """

    owner: str
    clock: Clock
    random: Random
    described: Callable[[KnownDevice], None]
    report: Callable[[str, dict[str, PlainValue], str], Awaitable[None]]
    deliver_raw: Callable[[str, bytes], Awaitable[None]]
    reject: Callable[[str, bytes, str], None]
    reachable: ReportReachable
    unavailable: Callable[[], None]
    failed: Callable[[str], None]


@dataclass(slots=True)
class _Kept:
    """One device that a connection is kept to."""

    device: KnownDevice
    profile: GattProfile
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    state: GattState = field(default_factory=lambda: GattState({}))
    link: BleLink | None = None
    commands: anyio.Lock = field(default_factory=anyio.Lock)
    wake: anyio.Event = field(default_factory=anyio.Event)
    used_at: float = 0.0
    is_evicted: bool = False
    hang_up: Callable[[], None] = lambda: None


class Connections:
    """Keeps connections to devices.

    Args:
        radio: The adapter.
        host: The gateway.
        tasks: Its tasks.
        most: Connections that may stand at once.
    """

    def __init__(self, radio: BleRadio, host: ConnectionHost, tasks: TaskGroup, most: int) -> None:
        self._radio = radio
        self._host = host
        self._tasks = tasks
        self._most = most
        self._kept: dict[str, _Kept] = {}
        self._turn = anyio.Lock()
        self._taken: set[str] = set()
        self._urgent: set[str] = set()
        self._changed = anyio.Event()

    @property
    def connected(self) -> tuple[KnownDevice, ...]:
        """The devices that are connected now."""
        return tuple(one.device for one in self._kept.values() if one.link is not None)

    def keep(self, device: KnownDevice, *, is_back: bool) -> None:
        """Keep a connection to a device that has a profile.

        Args:
            device: The device.
            is_back: Whether it was heard after a while: then it is tried at once, and not when it is due.
        """
        kept = self._kept.get(device.key)
        if kept is not None:
            if is_back:
                kept.wake.set()
        elif device.profile is not None:
            kept = _Kept(device, device.profile, state=GattState.unknown(device.profile.level_max))
            self._kept[device.key] = kept
            self._tasks.start_soon(run_as, self._host.owner, partial(self._keep, kept))

    def let_go(self, key: str) -> None:
        """End the connection to a device, for good."""
        kept = self._kept.pop(key, None)
        if kept is not None:
            kept.scope.cancel()

    async def perform(self, key: str, capability: str, value: PlainValue) -> None:
        """Carry a command out, over the connection that stands, or one that is made for it.

        Raises:
            LinkError: The device cannot be reached.
            RefusedError: It refuses, or has no frame for that.
        """
        kept = self._kept.get(key)
        if kept is None:
            raise RefusedError(capability, "the device only broadcasts")
        async with kept.commands:
            kept.used_at = self._host.clock.monotonic()
            link = kept.link or await self._connect_now(kept)
            state = GattState(dict(kept.state.fields))
            data = kept.profile.write(capability, value, state)
            await link.write(kept.profile.command, data, response=kept.profile.response)
            kept.state = state
            if kept.profile.report and not link.has(kept.profile.reported_by, "notify", "indicate"):
                await self._take(kept, await link.read(kept.profile.reported_by))

    async def _connect_now(self, kept: _Kept) -> BleLink:
        key = kept.device.key
        self._urgent.add(key)
        try:
            if key not in self._taken and len(self._taken) >= self._most:
                await self._evict()
            kept.wake.set()
            self._tell()
            with anyio.move_on_after(COMMAND_WITHIN):
                while kept.link is None and key in self._kept:
                    await self._changed.wait()
        finally:
            self._urgent.discard(key)
        if kept.link is None:
            raise LinkError(f"{key} cannot be reached: no connection was made within {COMMAND_WITHIN:g} seconds")
        return kept.link

    async def _evict(self) -> None:
        idle = [one for one in self._kept.values() if one.link is not None and not one.commands.locked()]
        if idle:
            least = min(idle, key=lambda one: one.used_at)
            least.is_evicted = True
            if least.link is not None:
                await least.link.close()
            least.hang_up()  # not every backend tells of what it was asked for

    def _tell(self) -> None:
        self._changed.set()
        self._changed = anyio.Event()

    async def _keep(self, kept: _Kept) -> None:
        failures, since = 0, 0.0
        with kept.scope:
            while True:
                await self._take_place(kept.device.key)
                kept.wake = anyio.Event()
                began = self._host.clock.monotonic()
                try:
                    await self._connected(kept)
                except BluetoothUnavailableError:
                    self._host.unavailable()
                except (LinkError, RefusedError) as exc:
                    self._host.failed(f"{kept.device.key}: {exc}")
                finally:
                    self._taken.discard(kept.device.key)
                    kept.link = None
                    self._tell()
                now = self._host.clock.monotonic()
                failures = 0 if now - began >= LASTED else failures + 1
                since = now if failures <= 1 else since
                self._host.reachable(kept.device.key, reachable=None if kept.is_evicted else False)
                kept.is_evicted = False
                with anyio.move_on_after(self._pause(failures, since)):
                    await kept.wake.wait()

    def _pause(self, failures: int, since: float) -> float:
        failing_for = self._host.clock.monotonic() - since if failures else 0.0
        return _BACKOFF.delay(max(1, failures), failing_for, self._host.random)

    async def _take_place(self, key: str) -> None:
        """Wait until one more connection may be made, and it is this device's turn."""
        while len(self._taken) >= self._most or (self._urgent and key not in self._urgent):
            await self._changed.wait()
        self._taken.add(key)

    async def _connected(self, kept: _Kept) -> None:
        """Connect, and stay so until the connection is lost.

        Raises:
            LinkError: No connection can be made.
            RefusedError: The device does not have what its profile says.
        """
        values_in, values = anyio.create_memory_object_stream[tuple[str, bytes]](MAX_VALUES)
        kept.hang_up = values_in.close
        link: BleLink | None = None
        try:
            async with self._turn:
                link = await self._radio.connect(kept.device.address, values_in.close)
            if not link.has(kept.profile.command):
                raise RefusedError(kept.device.key, f"it has no characteristic {kept.profile.command}")
            await self._learn(kept, link, values_in)
            kept.link = link
            self._host.reachable(kept.device.key, reachable=True)
            self._tell()
            async with values:
                await self._listen(kept, link, values)
        finally:
            kept.link = None
            values_in.close()
            values.close()
            if link is not None:
                await link.close()

    async def _learn(self, kept: _Kept, link: BleLink, values_in: MemoryObjectSendStream[tuple[str, bytes]]) -> None:
        """Read what a device says of itself, and subscribe to what it notifies."""
        for fact, characteristic in DEVICE_INFORMATION.items():
            if link.has(characteristic, "read"):
                text = (await link.read(characteristic)).decode(errors="replace").strip("\0 ")
                if text.isprintable() and text:
                    kept.device.connected_facts[fact] = text[:_LONGEST]
        kept.device.has_battery = link.has(BATTERY_LEVEL, "read")
        self._host.described(kept.device)
        for characteristic in (BATTERY_LEVEL, *((kept.profile.reported_by,) if kept.profile.report else ())):
            if link.has(characteristic, "notify", "indicate"):
                await link.subscribe(characteristic, partial(self._put, values_in, characteristic))
            if link.has(characteristic, "read"):
                self._put(values_in, characteristic, await link.read(characteristic))

    def _put(self, values_in: MemoryObjectSendStream[tuple[str, bytes]], characteristic: str, data: bytes) -> None:
        try:
            values_in.send_nowait((characteristic, data))
        except anyio.WouldBlock:
            self._host.reject("", data, "it notifies faster than it can be read")
        except (anyio.ClosedResourceError, anyio.BrokenResourceError):
            return  # it was lost

    async def _listen(self, kept: _Kept, link: BleLink, values: MemoryObjectReceiveStream[tuple[str, bytes]]) -> None:
        is_polled = bool(kept.profile.report) and not link.has(kept.profile.reported_by, "notify", "indicate")
        while link.is_open:
            found: tuple[str, bytes] | None = None
            with anyio.move_on_after(POLL_EVERY):
                try:
                    found = await values.receive()
                except anyio.EndOfStream:
                    return
            if found is None and is_polled:
                found = kept.profile.reported_by, await link.read(kept.profile.reported_by)
            if found is not None and found[0] == BATTERY_LEVEL:
                await self._take_battery(kept.device.key, found[1])
            elif found is not None:
                await self._take(kept, found[1])

    async def _take_battery(self, key: str, data: bytes) -> None:
        if len(data) != 1 or data[0] > _FULL:
            self._host.reject(key, data, "its battery level is not 0 to 100 percent")
            return
        await self._host.report(key, {"battery": float(data[0])}, BATTERY)

    async def _take(self, kept: _Kept, data: bytes) -> None:
        key = kept.device.key
        try:
            values = kept.profile.read(data, kept.state)
        except WireError as exc:
            self._host.reject(key, data, str(exc))
            return
        await self._host.deliver_raw(key, data)
        await self._host.report(key, values, "")
