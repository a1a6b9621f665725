"""The devices of a gateway, published with everything that the graph expects.

Messages are published in the order of the calls. Commands to different parts run concurrently; a full inbox delays
a report briefly, see :class:`homebot.gateways.raw_delivery.RawDelivery`.
"""

from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping
from typing import TypeAlias

import anyio.lowlevel

from homebot.devices import RawCommand, RawMessage
from homebot.devices.gateway_messages import Command
from homebot.devices.health import HealthResponse
from homebot.devices.part import check_setting
from homebot.devices.value import PlainValue, SetBy
from homebot.errors import RefusedError, UnableError, WireError
from homebot.gateways.announced.announcement import SightingKind, StoredAnnouncement
from homebot.gateways.announced.command_server import CommandServer, Perform, Refresh
from homebot.gateways.announced.engine import GatewayEngine
from homebot.gateways.announced.gateway_device import GatewayDevice, can_report
from homebot.gateways.announced.registry import DeviceRegistry, RegistryLimits
from homebot.gateways.base import Gateway, GatewaySettings
from homebot.gateways.raw_delivery import PartTexts, missed

REFUSED = "gateway.reading_refused"
TOO_MANY = "gateway.devices_refused"
REJECTED = "gateway.message_rejected"

MAX_DEVICES = 10_000

SendRaw: TypeAlias = Callable[[RawCommand], Awaitable[None]]
"""Sends a raw command to its address; raises :class:`RefusedError` or :class:`LinkError`."""

FindSource: TypeAlias = Callable[[str], tuple[str, str]]
"""Returns key and name of the device with raw messages on an address; may raise RefusedError.

The device need not be known yet.
"""


class PublishedDevices:
    """Publishes the devices of a gateway, and receives their commands.

    It serves the names of :mod:`homebot.gateways.base` of every gateway, except ``state``, and those of raw
    messages, texts and quarantine.

    Args:
        send_raw: Sends raw commands to addresses; None for a protocol without them.
        refresh: Asks a part for its values; None for a protocol that cannot.
        find_source: Returns the device of a raw address; by default the registered one with that address.
        settings: The keys that the tables of all gateways have in common.
        max_devices: Most devices known at once; see :class:`RegistryLimits` for the other limits.
        find_problems: Returns the current problems of devices, in words, for the health service.
        find_notes: Returns advice about devices that work, likewise.

    Attributes:
        gateway: The gateway, with the clock, log and random numbers that its devices use.
        engine: The underlying mechanisms, for a gateway that needs more of them.
        problems: The current problems of the gateway, in words; the health service shows them first.
    """

    def __init__(
        self,
        gateway: Gateway,
        perform: Perform,
        settings: GatewaySettings | None = None,
        *,
        send_raw: SendRaw | None = None,
        refresh: Refresh | None = None,
        find_source: FindSource | None = None,
        max_devices: int = MAX_DEVICES,
        find_problems: Callable[[], Iterable[str]] = tuple,
        find_notes: Callable[[], Iterable[str]] = tuple,
    ) -> None:
        settings = settings or GatewaySettings()
        self.gateway = gateway
        self._perform = perform
        self._given: dict[str, GatewayDevice] = {}
        self._registry = DeviceRegistry(gateway.node.name, RegistryLimits(announcements=max_devices))
        self._devices = self._registry.by_key
        self._send_raw = send_raw
        self._find_source = find_source
        self._by_address: dict[str, GatewayDevice] = {}
        self._last_raw: dict[str, PartTexts] = {}
        self.problems: tuple[str, ...] = ()
        self.engine: GatewayEngine[bytes] = GatewayEngine(
            gateway, self._devices, stale_after=settings.stale_after, inboxes=settings.delivery == "inbox"
        )
        self.counters = self.engine.counters
        self._reporter = self.engine.reporter
        CommandServer(
            self.engine,
            self._check,
            self,
            lambda: HealthResponse(counts=(), troubles=(*self.problems, *find_problems()), notes=tuple(find_notes())),
            keeps_states=True,
            refresh=refresh,
        )

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of all devices, oldest first."""
        return tuple(self._devices)

    def owner_of(self, address: str) -> tuple[str, str]:
        """Return key and name of the device with raw messages on *address*; the address itself if there is none yet."""
        device = self._by_address.get(address)
        return (address, address) if device is None else (device.key, device.name)

    def find_source(self, address: str, *, undeclared: bool) -> tuple[str, str]:  # noqa: ARG002 - as of the port
        """Return key and name of the device with raw messages on *address*."""
        return self.owner_of(address) if self._find_source is None else self._find_source(address)

    async def send_raw(self, command: RawCommand) -> None:
        """Send a raw command; see :class:`RawMessages`. Refused by a protocol without raw commands."""
        if self._send_raw is None:
            raise RefusedError("the command", "this protocol takes no raw commands; use a text address")
        await self._send_raw(command)

    def missed_by(self, address: str, since: float) -> tuple[RawMessage, ...]:
        """Return the kept raw messages on *address* since *since*, on the monotonic clock."""
        last = self._last_raw.get(address)
        return () if last is None else missed(last.kept, since)

    def put(self, device: GatewayDevice, why: str, *, confirmed: bool = True) -> None:
        """Publish a device that is new, has changed, or is still there.

        Args:
            device: Replaces the device with the same key, but keeps its last reports.
            confirmed: Whether the device itself was heard, rather than read from a cache or list.
        """
        self._reporter.refresh_time()
        before = self._devices.get(device.key)
        is_news = before is None or confirmed is not before.is_confirmed
        stored = before
        if stored is None or self._given[device.key] != device:
            try:
                stored = self._store(device)
            except WireError as exc:
                self.counters.devices_refused += 1
                self.engine.quarantine.log_limited(TOO_MANY, str(exc), source="")
                return
            is_news = is_news or before is None or not stored.publishes_the_same(before)
        self.engine.quarantine.budgets.accept(device.key, b"", self._reporter.now, is_valid=True)
        if is_news or self._reporter.now >= stored.refresh_at:
            kind: SightingKind = "appeared" if before is None else "updated"
            self._reporter.publish_sighting(stored, kind, why, confirmed=confirmed)

    async def confirm(self, keys: Iterable[str], why: str) -> None:
        """Publish that these devices are still there, except those that cannot be reached."""
        for key in tuple(keys):
            stored = self._devices.get(key)
            if stored is not None and stored.reachable.get("") is not False:
                self.put(self._given[key], why)
            await anyio.lowlevel.checkpoint()

    def remove(self, key: str, why: str) -> None:
        """Publish that a device has left the house, and forget it; an unknown *key* is ignored."""
        self._reporter.refresh_time()
        stored = self._registry.remove(key)
        if stored is None:
            return
        self._leave_address(self._given.pop(key))
        self.engine.quarantine.budgets.forget(key)
        self._reporter.dispose_all(stored)
        self._reporter.publish_sighting(stored, "removed", why, confirmed=True)
        stored.detach()

    async def report(
        self, key: str, values: Mapping[str, PlainValue], part: str = "", *, retained: bool = False, set_by: SetBy = ""
    ) -> None:
        """Publish the reported values of a part; values that it cannot report are refused and counted.

        Args:
            values: Values by capability, in the unit of the vocabulary; None for unknown.
            retained: Whether the report is of an earlier state.
            set_by: See :attr:`Report.set_by`.
        """
        stored = self._devices.get(key)
        described = None if stored is None else stored.parts.get(part)
        if described is None:
            self._refuse(len(values), f"{key[:100]} has no part {part[:100]!r}")
            return
        known = {name: value for name, value in values.items() if can_report(described.described.part, name, value)}
        if len(known) < len(values):
            refused = ", ".join(f"{name[:40]} {str(values[name])[:40]!r}" for name in values.keys() - known.keys())
            self._refuse(len(values) - len(known), f"{key[:100]} cannot have reported {refused[:200]}")
        if known:
            self._reporter.refresh_time()
            await self.engine.states.publish(described, known, retained=retained, set_by=set_by)

    def report_reachable(self, key: str, part: str = "", *, reachable: bool | None) -> None:
        """Publish whether a device, or one of its parts, can be reached; None for unknown. The device stays listed."""
        stored = self._devices.get(key)
        if stored is None or (part in stored.reachable and stored.reachable[part] is reachable):
            return
        self._reporter.refresh_time()
        stored.record_reachable(part, reachable)
        # A report without an address means that the device no longer reports this.
        address = "" if reachable is None else stored.template.address or key
        self._reporter.report_reachable(stored, part, address, reachable=reachable, retained=False)

    async def on_link_loss(self) -> None:
        """Publish for all devices that their reachability is unknown: the gateway has lost its link."""
        for key in self.keys:
            self.report_reachable(key, reachable=None)
            await anyio.lowlevel.checkpoint()

    async def deliver_raw(self, key: str, payload: bytes) -> None:
        """Deliver a raw message of a device to the listeners of its address."""
        stored = self._devices.get(key)
        if stored is None:
            return
        self._reporter.refresh_time()
        self.counters.received += 1
        message = RawMessage(
            gateway=stored.gateway,
            key=key,
            address=self._given[key].raw,
            payload=payload,
            retained=False,
            received_at=self._reporter.stamp,
        )
        if message.address in self._by_address:  # else listeners use its text address
            self._last_raw.setdefault(message.address, PartTexts()).record(message, self._reporter.now, is_event=False)
        await self.engine.listeners.deliver(message, wait_if_full=True)

    def admits(self, source: str) -> bool:
        """Return whether to read a message from *source*: False while that source breaks the rules too often.

        For messages that repeat, such as polled or broadcast values: one that is not admitted is dropped and counted.

        Args:
            source: The key of the device that sent it; for unknown senders, their network address.
        """
        self._reporter.refresh_time()
        return self.engine.quarantine.admits(source)

    def reject(self, source: str, payload: bytes, why: str) -> None:
        """Count a message that breaks the protocol, log it at a limited rate, and charge it to *source*."""
        self._reporter.refresh_time()
        self.counters.rejected += 1
        self.engine.quarantine.record_offence(source, len(payload), REJECTED, why)

    def _store(self, device: GatewayDevice) -> StoredAnnouncement:
        change = self._registry.put(device.described())
        device.complete(change.stored)
        if change.before is not None:
            change.before.detach()
            if self._given[device.key].raw != device.raw:
                self._leave_address(self._given[device.key])
        self._given[device.key] = device
        if device.raw:
            self._by_address[device.raw] = device
        return change.stored

    def _leave_address(self, device: GatewayDevice) -> None:
        last_there = self._by_address.get(device.raw)
        if last_there is not None and last_there.key == device.key:
            self._last_raw.pop(device.raw, None)
            del self._by_address[device.raw]

    async def _check(self, command: Command) -> Collection[str] | None:
        """Carry out *command* if it fits the part; see :data:`Perform`."""
        part = self.engine.find_part(command.key, command.part, command.topics).described.part
        try:
            check_setting(command.key[:100], part, command.capability, command.value.plain())
            for setting in command.also:
                check_setting(command.key[:100], part, setting.capability, setting.value.plain())
        except RefusedError as exc:
            raise UnableError(str(exc)) from exc
        return await self._perform(command)

    def _refuse(self, count: int, problem: str) -> None:
        self.counters.readings_refused += count
        self.engine.quarantine.log_limited(REFUSED, problem, source="")
