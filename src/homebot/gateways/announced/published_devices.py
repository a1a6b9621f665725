"""The devices that a gateway publishes, with all that the graph expects of it.

Everything is published in the order of the calls. Commands to different parts are carried out side by side; an inbox
that is full holds a report up for a moment, as :class:`homebot.gateways.raw_delivery.RawDelivery` says.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.devices import RawMessage
from homebot.devices.capabilities import EVENTS
from homebot.devices.command import Command
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import text_address
from homebot.devices.part import Part
from homebot.devices.report import Reading
from homebot.devices.text.encode import encode_state
from homebot.devices.value import PlainValue, Value
from homebot.errors import RefusedError, UnableError
from homebot.gateways.announced.command_server import CommandServer, Perform
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.device_table import PublishedDevice, PublishedDeviceTable
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.reported_device import SightingKind
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.text_service import FindSource, SendRaw, TextService
from homebot.gateways.announced.value_check import can_report, check_command
from homebot.gateways.base import Gateway
from homebot.log import LogLimit

__all__ = ["PublishedDevices"]

REFUSED = "gateway.reading_refused"
TOO_MANY = "gateway.devices_refused"

MAX_DEVICES = 10_000


class PublishedDevices:
    """Publishes the devices of a gateway, and takes their commands.

    It serves the graph names of :mod:`homebot.gateways.base` that are duties, but ``state``, and those of raw messages
    and texts.

    Args:
        gateway: The gateway.
        perform: Carries out commands that fit the part they are for.
        send_raw: Sends raw commands to addresses; None for a protocol that has none.
        find_source: Says whose an address of raw messages is; by default each is a device's of its own.
        stale_after: Seconds of silence after which a device counts as stale.
        inboxes: Whether nodes get raw messages and texts in their inboxes, rather than on a topic for each device.
        max_devices: Devices that may be known at once.

    Attributes:
        counters: What it did.
        problems: What is wrong now, as text; the health service shows it.
    """

    def __init__(
        self,
        gateway: Gateway,
        perform: Perform,
        *,
        send_raw: SendRaw | None = None,
        find_source: FindSource | None = None,
        stale_after: float = 3600.0,
        inboxes: bool = True,
        max_devices: int = MAX_DEVICES,
    ) -> None:
        self.counters = GatewayCounters()
        self.problems: tuple[str, ...] = ()
        self._gateway = gateway
        self._perform = perform
        self._max_devices = max_devices
        self._devices = PublishedDeviceTable()
        self._reporter = DeviceReporter(gateway, stale_after)
        self._limit = LogLimit(gateway.node.graph.clock)
        commands = CommandServer(gateway, self._checked, self._find_part, self.counters)
        self._texts = TextService(
            gateway, self._devices, commands, self.counters, send_raw, find_source, inboxes=inboxes
        )
        gateway.node.create_service(GetHealth, gateway.names.health, self._health)

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of all devices, in the order in which they came."""
        return tuple(self._devices)

    def put(self, device: GatewayDevice, why: str, *, confirmed: bool = True) -> None:
        """Publish a device that is new, or described anew, or still there.

        Args:
            device: The device; one of the same key is replaced, and keeps its last reports.
            why: The reason, as text.
            confirmed: Whether the device itself was heard, rather than a note kept of it.
        """
        self._reporter.refresh_time()
        before = self._devices.get(device.key)
        if before is None and len(self._devices) >= self._max_devices:
            self.counters.devices_refused += 1
            self._warn(TOO_MANY, f"{device.key[:100]} is one too many: {self._max_devices:,} devices are known")
            return
        now = PublishedDevice(self._gateway.node.name, device.key, device)
        if before is not None:
            now.take_over_state(before)
        self._devices.put(now)
        is_news = before is None or not before.publishes_the_same(now) or confirmed is not before.is_confirmed
        if is_news or self._reporter.now >= now.refresh_at:
            kind: SightingKind = "appeared" if before is None else "updated"
            self._reporter.publish_sighting(now, kind, why, confirmed=confirmed)

    def remove(self, key: str, why: str) -> None:
        """Publish that a device was taken out of the house, and keep nothing of it; no device is nothing new."""
        self._reporter.refresh_time()
        device = self._devices.remove(key)
        if device is not None:
            self._reporter.dispose_all(device)
            self._reporter.publish_sighting(device, "removed", why, confirmed=True)

    async def report(
        self, key: str, values: Mapping[str, PlainValue], part: str = "", *, retained: bool = False
    ) -> None:
        """Publish what a part reported; values that it cannot have reported are refused, and counted.

        Args:
            key: The device.
            values: Values by capability, in the unit of the vocabulary; None for unknown.
            part: The part.
            retained: Whether that was kept from before: what was, not what is.
        """
        device = self._devices.get(key)
        described = None if device is None else device.part(part)
        if device is None or described is None:
            self._refuse(len(values), f"{key[:100]} has no part {part[:100]!r}")
            return
        known = {name: value for name, value in values.items() if can_report(described, name, value)}
        if len(known) < len(values):
            refused = ", ".join(f"{name[:40]} {str(values[name])[:40]!r}" for name in values.keys() - known.keys())
            self._refuse(len(values) - len(known), f"{key[:100]} cannot have reported {refused[:200]}")
        if not known:
            return
        self._reporter.refresh_time()
        self.counters.reports += 1
        if not retained:
            self._seen(device)
        readings = tuple(Reading(part=part, capability=name, value=Value.of(value)) for name, value in known.items())
        self._reporter.publish_readings(device, readings, part, "", retained=retained)
        await self._deliver_text(device, part, known, retained=retained)

    def report_reachable(self, key: str, part: str = "", *, reachable: bool | None) -> None:
        """Publish whether a device, or one of its parts, can be reached; None for unknown. It is there either way."""
        device = self._devices.get(key)
        if device is None or (part in device.reachable and device.reachable[part] is reachable):
            return
        self._reporter.refresh_time()
        device.reachable[part] = reachable
        self._reporter.report_reachable(device, part, "", reachable=reachable, retained=False)

    async def deliver_raw(self, key: str, payload: bytes, *, retained: bool = False) -> None:
        """Deliver a raw message of a device, to who listens to its address."""
        device = self._devices.get(key)
        if device is not None:
            self._reporter.refresh_time()
            message = self._message(device, device.template.address, payload, retained=retained)
            device.keep_raw(message, self._reporter.now)
            await self._texts.deliver(message)

    def _seen(self, device: PublishedDevice) -> None:
        if not device.is_confirmed or self._reporter.now >= device.refresh_at:
            # First: to a directory that has forgotten the device, a report alone is of nobody.
            self._reporter.publish_sighting(device, "updated", "it reported", confirmed=True)

    async def _deliver_text(
        self, device: PublishedDevice, part: str, values: Mapping[str, PlainValue], *, retained: bool
    ) -> None:
        if retained:
            values = {name: value for name, value in values.items() if name not in EVENTS}
        text = encode_state(values)
        if text is None:
            return
        message = self._message(device, text_address(device.key, part), text.encode(), retained=retained)
        device.texts[part].keep(message, self._reporter.now, is_event=not EVENTS.isdisjoint(values))
        await self._texts.deliver(message)

    def _message(self, device: PublishedDevice, address: str, payload: bytes, *, retained: bool) -> RawMessage:
        return RawMessage(
            gateway=device.gateway,
            key=device.key,
            address=address,
            payload=payload,
            retained=retained,
            received_at=self._reporter.stamp,
        )

    async def _checked(self, command: Command) -> None:
        """Carry *command* out where it fits the part.

        Raises:
            UnableError: It does not; says what would.
        """
        part = self._find_part(command.key, command.part)
        try:
            check_command(part, command.capability, command.value.plain())
        except RefusedError as exc:
            raise UnableError(str(exc)) from exc
        await self._perform(command)

    def _find_part(self, key: str, part_id: str) -> Part:
        device = self._devices.get(key)
        if device is None:
            raise UnableError(f"a command to {key[:100]} was refused: no device has that key")
        part = device.part(part_id)
        if part is None:
            known = ", ".join(repr(one.id) for one in device.device.parts[:10]) or "none"
            raise UnableError(f"{key[:100]} has no part {part_id[:100]!r}; it has {known}")
        return part

    def _refuse(self, count: int, problem: str) -> None:
        self.counters.readings_refused += count
        self._warn(REFUSED, problem)

    def _warn(self, event: str, problem: str) -> None:
        if self._limit.allows(event) is not None:
            self._gateway.node.log.warning(event, message=problem)

    def _health(self, request: HealthRequest) -> HealthResponse:
        del request
        return HealthResponse(counts=self.counters.counts(), troubles=self.problems)
