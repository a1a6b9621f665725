"""The devices that a gateway has published, by key and by address. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from homebot.devices import RawMessage, Sighting
from homebot.devices.part import Part
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.last_messages import PartTexts
from homebot.gateways.announced.reported_device import ReportedDevice, sighting_template

__all__ = ["PublishedDevice", "PublishedDeviceTable"]

_KEPT = 10
_MAX_KEPT_PAYLOAD = 4096


@dataclass(slots=True, eq=False)
class PublishedDevice(ReportedDevice):
    """A device that a gateway has published.

    Attributes:
        device: Its description.
        texts: The last texts of its parts.
        raw: Its last 10 raw messages of at most 4 KiB, and when each came on the monotonic clock.
    """

    device: GatewayDevice
    texts: dict[str, PartTexts] = field(init=False)
    raw: deque[tuple[float, RawMessage]] = field(default_factory=lambda: deque(maxlen=_KEPT), init=False)

    def __post_init__(self) -> None:
        given = self.device
        template = sighting_template(
            self.gateway,
            self.key,
            name=given.name,
            parts=given.parts,
            metadata=given.metadata,
            identifiers=given.identifiers,
            area=given.area,
        )
        own = {name: getattr(given, name) for name in ("service_type", "address", "command_address")}
        self.template = Sighting.of_checked(**template.__dict__ | {name: text for name, text in own.items() if text})
        self.texts = {part.id: PartTexts() for part in given.parts}

    def part(self, part_id: str) -> Part | None:
        """Return the part of that id; None where it has none."""
        return next((part for part in self.device.parts if part.id == part_id), None)

    def keep_raw(self, message: RawMessage, now: float) -> None:
        """Remember a raw message that came at *now* on the monotonic clock, unless it is large."""
        if len(message.payload) <= _MAX_KEPT_PAYLOAD:
            self.raw.append((now, message))

    def take_over_state(self, before: PublishedDevice) -> None:
        """Take over what is known of the device from the description *before* this one."""
        self.is_confirmed, self.refresh_at = before.is_confirmed, before.refresh_at
        self.report_streams, self.reachable, self.raw = before.report_streams, before.reachable, before.raw
        self.texts |= {part: texts for part, texts in before.texts.items() if part in self.texts}


class PublishedDeviceTable:
    """The published devices, in the order in which they came."""

    def __init__(self) -> None:
        self._devices: dict[str, PublishedDevice] = {}
        self._by_address: dict[str, PublishedDevice] = {}

    def __len__(self) -> int:
        return len(self._devices)

    def __iter__(self) -> Iterator[str]:
        return iter(self._devices)

    def get(self, key: str) -> PublishedDevice | None:
        """Return the device of that key; None where there is none."""
        return self._devices.get(key)

    def at(self, address: str) -> PublishedDevice | None:
        """Return the device that reports raw messages on *address*; None where none does."""
        return self._by_address.get(address)

    def put(self, device: PublishedDevice) -> None:
        """Add a device, in place of one with the same key."""
        self.remove(device.key)
        self._devices[device.key] = device
        if device.device.address:
            self._by_address[device.device.address] = device

    def remove(self, key: str) -> PublishedDevice | None:
        """Remove the device of that key and return it; None where there is none."""
        device = self._devices.pop(key, None)
        if device is not None and self._by_address.get(device.device.address) is device:
            del self._by_address[device.device.address]
        return device
