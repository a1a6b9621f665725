"""The Bluetooth gateway: receives advertisements, and connects to devices with a declared profile."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, ClassVar, cast

import anyio
import anyio.lowlevel
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.clock import Clock
from homebot.conventions.bluetooth.beacons import BeaconParser
from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, BroadcastParser
from homebot.conventions.bluetooth.gatt_profile import GattProfile
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, PluginError, UsageError, WireError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext, HostService
from homebot.gateways.ble.connections import Connections
from homebot.gateways.ble.intake import BluetoothUnavailableError, Intake
from homebot.gateways.ble.known_device import KnownDevice
from homebot.gateways.ble.settings import PARSERS, BleDeviceSettings, BleGatewaySettings
from homebot.gateways.ble_proxies.proxy import ListedProxies
from homebot.graph import Graph, Node
from homebot.plugins import check_extra, load_plugin
from homebot.support.backoff import LINK_BACKOFF, BackoffCounter
from homebot.support.ble_backend import BleBackend
from homebot.support.ble_proxies import BleProxies
from homebot.support.isolation import run_as
from homebot.support.limits import RateLimit

if TYPE_CHECKING:
    from homebot.gateways.ble.bleak_adapter import BleRadio
    from homebot.gateways.ble_proxies.hub import ProxyHub

QUIET = 30.0
"""Seconds without any advertisement after which the scan is restarted: an adapter that is gone does not say so."""

MAX_PROBLEMS = 20

MAX_SCANNED = 5_000
"""Addresses after which the scan is restarted: bleak keeps every address of a scan."""

BACK_AFTER = 10.0
"""Seconds of silence after which a device that is heard again counts as returned."""

TICK = 5.0
SIGNAL_EVERY = 5.0
"""Both in seconds."""

PUT_EVERY = 1.0
"""Seconds between two sightings of a device that has not changed."""

NEW_AT_ONCE, NEW_PER_SECOND = 200, 5.0
"""New devices that are accepted: any radio may advertise, and a house has fewer, so that more are probably fake."""

SETTLED_AFTER = 60.0
"""Seconds after which a device is not removed to make room for another."""


class BleGateway(Gateway):
    """Brings Bluetooth devices nearby onto the graph.

    Args:
        context: Services of the host; a :class:`BleBackend` replaces the Bluetooth stack of the operating system.
    """

    Settings: ClassVar[type[BaseModel]] = BleGatewaySettings

    def __init__(self, node: Node, settings: BleGatewaySettings, context: GatewayContext | None = None) -> None:
        """Make the gateway; scanning starts with :meth:`serve`."""
        super().__init__(node, settings, context)
        clock = node.graph.clock
        self._settings = settings
        self._clock = clock
        self._profiles = {profile.service: profile for profile in settings.profiles.values()}
        self._parsers = _find_parsers(settings)
        self._known: dict[str, KnownDevice] = {}
        self._keys: dict[str, str] = {}
        self._newcomers = RateLimit(NEW_PER_SECOND, NEW_AT_ONCE)
        self._ignored = 0
        self._connections: Connections | None = None
        self._restart = anyio.Event()
        self._listens_since: float | None = None
        self._reason = "it has not started"
        self._told: dict[str, int] = {}
        self.intake = Intake(clock)
        self._hub = cast("ProxyHub | None", self.context.service(BleProxies))
        self.devices = PublishedDevices(self, self._perform, settings, max_devices=settings.max_devices)
        self._proxies = ListedProxies(settings.listed_proxies, self.devices)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Look for bleak, the parsers and the bind keys."""
        check_extra('the gateway "ble"', "ble", "bleak", "cryptography")
        if isinstance(settings, BleGatewaySettings):
            _find_parsers(settings)
            if settings.proxies:
                ListedProxies.check(settings.listed_proxies)

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:
        """Return the place where proxies are handed over, if there shall be any."""
        if not isinstance(settings, BleGatewaySettings) or not settings.proxies:
            return ()

        @asynccontextmanager
        async def start(_graph: Graph, clock: Clock) -> AsyncIterator[BleProxies]:
            from homebot.gateways.ble_proxies.hub import ProxyHub  # noqa: PLC0415 - an extra

            with ProxyHub(clock, takes_found=settings.proxies is True).running() as hub:
                yield hub

        return (HostService(BleProxies, start, "Bluetooth proxies"),)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Run the scan and the connections until cancelled; ready after the first attempt to scan."""
        from homebot.gateways.ble.bleak_adapter import BleRadio  # noqa: PLC0415 - only where it runs

        backend = self.context.service(BleBackend)
        is_passive = self._settings.scan == "passive"
        radio = BleRadio(backend, self._settings.adapter, is_passive=is_passive, proxies=self._hub)
        listening = nullcontext() if self._hub is None else self._hub.listening(self._hear, self._publish_state)
        async with anyio.create_task_group() as tasks:
            self._connections = Connections(
                radio,
                self.devices,
                tasks,
                self._settings.max_connections,
                on_described=partial(self._put, why="it was connected"),
                on_unavailable=self._restart_scan,
            )
            for work in (self._read, self._look_around):
                tasks.start_soon(run_as, self.node.full_name, work)
            self._proxies.start(tasks, self._hub)
            with listening:
                await self._scan(radio, task_status)

    def _hear_locally(self, advertisement: Advertisement) -> None:
        self.intake.heard_at = self._clock.monotonic()
        if self._hub is None:
            self._hear(advertisement, counts=True)
        else:
            self._hub.hear_locally(advertisement)

    def _hear(self, advertisement: Advertisement, *, counts: bool) -> None:
        device = self._known.get(self._keys.get(advertisement.address, advertisement.address))
        if device is not None:
            device.hearing.add(advertisement.receiver, advertisement.rssi, self._clock.monotonic())
        if counts:
            self.intake.put(advertisement)

    @property
    def _has_proxy(self) -> bool:
        return self._hub is not None and self._hub.has_proxy

    def _publish_state(self) -> None:
        """Publish whether any receiver listens, and the problem of the adapter."""
        if self._reason and not self._has_proxy:
            self._listens_since = None
            self.publish_state("unavailable", self._reason)
            return
        if self._listens_since is None:
            self._listens_since = self._clock.monotonic()
        self.publish_state("active", self._reason)

    def _restart_scan(self) -> None:
        self._restart.set()

    async def _scan(self, radio: BleRadio, task_status: TaskStatus[None]) -> None:
        retries = BackoffCounter(self._clock, self.random)
        while True:
            try:
                async with radio.scanning(self._hear_locally):
                    retries.succeed()
                    self._reason = ""
                    self._publish_state()
                    self.mark_ready(task_status)
                    await self._until_done(radio)
                continue
            except BluetoothUnavailableError as exc:
                self._reason = str(exc)
                self._publish_state()
            self.mark_ready(task_status)
            await anyio.sleep(retries.fail(LINK_BACKOFF))

    async def _until_done(self, radio: BleRadio) -> None:
        self._restart = anyio.Event()
        began = self._clock.monotonic()
        while radio.heard < MAX_SCANNED:
            with anyio.move_on_after(TICK):
                await self._restart.wait()
                return
            if self._clock.monotonic() - max(began, self.intake.heard_at) >= QUIET:
                return

    async def _read(self) -> None:
        while True:
            advertisement = await self.intake.next()
            await self._read_advertisement(advertisement)
            await anyio.lowlevel.checkpoint()

    async def _read_advertisement(self, advertisement: Advertisement) -> None:
        source = self._keys.get(advertisement.address, advertisement.address)
        broadcast: Broadcast | None = None
        for parser in self._parsers:
            if not parser.concerns(advertisement):
                continue
            if not self.devices.admits(source):
                return
            try:
                broadcast = parser.read(advertisement, self._clock.monotonic())
            except WireError as exc:
                self.devices.reject(source, exc.frame, str(exc))
                return
            except Exception as exc:  # noqa: BLE001 - a parser of a plug-in must not end the gateway
                self.devices.engine.quarantine.record_plugin_failure(source, type(parser).__name__, exc)
                return
            if broadcast is not None:
                break
        await self._update_device(advertisement, broadcast)

    async def _update_device(self, advertisement: Advertisement, broadcast: Broadcast | None) -> None:
        now = self._clock.monotonic()
        device = self._sender_of(advertisement, broadcast, now)
        if device is None:
            self._forget_address(advertisement.address)
            return
        key = device.key
        is_back = now - device.presence.last_heard >= BACK_AFTER
        device.update(advertisement, broadcast, now)
        self._keys[advertisement.address] = key
        values = () if broadcast is None else broadcast.values
        if values or now - device.put_at >= PUT_EVERY:
            self._put(device, "it was heard")
        if device.profile is not None and self._connections is not None:
            self._connections.connect(device, is_back=is_back)
        if values:
            for data in (*advertisement.service_data.values(), *advertisement.manufacturer_data.values()):
                await self.devices.deliver_raw(key, data)
            for value in values:
                await self.devices.report(key, {value.capability: value.value}, value.part)
        if now - device.reported_at < SIGNAL_EVERY:
            return
        device.reported_at = now
        if self._hub is not None:
            device.heard_by, device.guess = self._hub.place_of(device.hearing, self._settings.room, now)
        if self._settings.signal:
            for part, signal in device.signal_values(self._settings.rssi_at_1m, now).items():
                await self.devices.report(device.key, signal, part)

    def _sender_of(self, advertisement: Advertisement, broadcast: Broadcast | None, now: float) -> KnownDevice | None:
        before = self._keys.get(advertisement.address, advertisement.address)
        key = before if broadcast is None else broadcast.key or advertisement.address
        if key == advertisement.address != before and self._known.pop(before, None) is not None:
            self.devices.remove(before, "it is a sensor, whose beacon others send as well")
        device = self._known.get(key) or self._admit(key, advertisement, broadcast, now)
        if device is not None and self._keys.get(device.address) == key:
            del self._keys[device.address]  # a beacon may have another address now
        return device

    def _admit(
        self, key: str, advertisement: Advertisement, broadcast: Broadcast | None, now: float
    ) -> KnownDevice | None:
        """Return a new device; None if it should not be listed, or there is no room."""
        declared = self._settings.devices.get(advertisement.address)
        profile = self._profile_of(advertisement, declared)
        is_understood = broadcast is not None or profile is not None or declared is not None
        if not is_understood and not self._lists_unknown(advertisement.name):
            return None
        if declared is None and not self._newcomers.admits(now):
            self._ignored += 1
            return None
        if len(self._known) >= self._settings.max_devices and not self._make_room():
            self.devices.counters.devices_refused += 1
            return None
        device = self._known[key] = KnownDevice(key, declared or BleDeviceSettings(), profile, now)
        device.hearing.add(advertisement.receiver, advertisement.rssi, now)
        return device

    def _lists_unknown(self, name: str) -> bool:
        return self._settings.listed == "all" or (self._settings.listed == "named" and bool(name))

    def _make_room(self) -> bool:
        """Forget the longest silent device of those heard only briefly; return whether there was one."""
        known = ((device, device.presence) for device in self._known.values())
        brief = [device for device, heard in known if heard.last_heard - heard.first_heard < SETTLED_AFTER]
        if not brief:
            return False
        dispensable = min(brief, key=lambda device: device.presence.last_heard)
        self._forget(dispensable, "too many devices are nearby, and it was heard only briefly")
        return True

    def _profile_of(self, advertisement: Advertisement, declared: BleDeviceSettings | None) -> GattProfile | None:
        if declared is not None and declared.profile:
            return self._settings.profiles[declared.profile]
        return next((self._profiles[uuid] for uuid in advertisement.service_uuids if uuid in self._profiles), None)

    def _put(self, device: KnownDevice, why: str) -> None:
        device.put_at = self._clock.monotonic()
        self.devices.put(device.describe(signal=self._settings.signal), why)

    def _forget(self, device: KnownDevice, why: str) -> None:
        del self._known[device.key]
        self._keys.pop(device.address, None)
        self._forget_address(device.address)
        if self._connections is not None:
            self._connections.close(device.key)
        self.devices.remove(device.key, why)

    def _forget_address(self, address: str) -> None:
        for parser in self._parsers:
            parser.forget(address)

    async def _look_around(self) -> None:
        while True:
            await anyio.sleep(TICK)
            now = self._clock.monotonic()
            for device in self._connections.connected if self._connections is not None else ():
                device.presence.record(now)
                self._put(device, "it is connected")
            if self._listens_since is not None:
                heard_since = self._listens_since
                silent = [
                    device
                    for device in self._known.values()
                    if now - max(device.presence.last_heard, heard_since) > self._settings.forget_after
                ]
                for device in silent:
                    self._forget(device, f"it was not heard for {self._settings.forget_after:g} seconds")
            self.devices.problems = self._problems()

    def _problems(self) -> tuple[str, ...]:
        """Return the current problems, as text; of overflows, only those since the last call."""
        problems = [f"{device.key}: {device.problem}" for device in self._known.values() if device.problem][
            :MAX_PROBLEMS
        ]
        problems += [f"the proxy {address}: {why}" for address, why in self._proxies.problems.items()][:MAX_PROBLEMS]
        counts = {
            "advertisements were dropped: more arrived than can be read": self.intake.dropped,
            "advertisements of unknown devices were ignored: too many devices appear": self._ignored,
            "advertisements of proxies were dropped: too many, or impossible": 0
            if self._hub is None
            else self._hub.refused,
        }
        for what, count in counts.items():
            if count > self._told.get(what, 0):
                problems.append(f"{count - self._told.get(what, 0)} {what}")
            self._told[what] = count
        return tuple(problems)

    async def _perform(self, command: Command) -> None:
        if self._connections is None or (self._reason and not self._has_proxy):
            raise LinkError(f"no device is reachable: {self._reason}")
        await self._connections.perform(command.key, command.capability, command.value.plain())


def _find_parsers(settings: BleGatewaySettings) -> tuple[BroadcastParser, ...]:
    keys = settings.bind_keys()
    parsers: list[BroadcastParser] = []
    for name in dict.fromkeys(settings.parsers):
        kind = load_plugin(PARSERS, name)
        if not issubclass(kind, BroadcastParser):
            raise PluginError(name, "is not a BroadcastParser")
        parsers.append(kind(keys))
    if keys and not parsers:
        raise UsageError("bind keys are configured, but no parser that uses them")
    return tuple(
        sorted(parsers, key=lambda parser: isinstance(parser, BeaconParser))
    )  # many sensors are iBeacons as well
