"""Parser of BTHome v2, the broadcasts of Shelly BLU and of many sensors that people build. Pure.

Source: https://bthome.io/format. A device sends each packet several times; the packet id tells packets apart. A packet
with an older id than the last one is late, and is ignored. Without packet ids, the same bytes are the same packet until
there is a pause of four seconds, as in the library ``bthome-ble``. An encrypted packet is read once, with any id.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from homebot.conventions.bluetooth.broadcast import (
    Advertisement,
    Broadcast,
    BroadcastParser,
    BroadcastValue,
    sensor_part,
)
from homebot.conventions.bluetooth.bthome_objects import TAGS, model_called
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Category, Part
from homebot.errors import WireError
from homebot.integrations.bthome.formats.packet import (
    BTHOME_UUID,
    BTHomeFrame,
    BTHomePacket,
    Measured,
    read_frame,
    read_objects,
)

if TYPE_CHECKING:
    from homebot.integrations.bthome.formats.encryption import BindKey

REPEATS_WITHIN = 4.0
"""Seconds."""

NEWER_BY = 64
"""A packet id is newer than the last one if it is ahead by less than this, modulo 256."""

ON_BATTERY = 300.0
"""Seconds for which a battery-powered device may be silent."""

TRIGGER_BASED = 86_400.0
"""Seconds for which a device may be silent that sends only when something happens."""

MAX_PARTS = 64
"""Parts of one device over all its packets; further ones are ignored."""

MAX_DEVICES = 10_000
KEY_SIZE = 16
"""Bytes of a bind key."""


class _BTHomeSender:
    """The state of one device, over all its packets."""

    def __init__(self) -> None:
        self.model = model_called("")
        self.parts: dict[str, Part] = {}
        self.metadata: dict[str, str] = {}
        self.packet_id: int | None = None
        self.data = b""
        self.received_at = float("-inf")
        self.silence = 0.0
        self.was_read = False

    def read(self, data: bytes, frame: BTHomeFrame, key: BindKey | None, now: float) -> tuple[BroadcastValue, ...]:
        """Return the new values in *data*; none if they are the last packet again.

        Raises:
            WireError: They cannot be decrypted, are a replay, or an object in them is invalid.
        """
        is_recent = self.packet_id is not None or now - self.received_at <= REPEATS_WITHIN
        if self.was_read and data == self.data and is_recent:
            return ()
        body = frame.body if key is None else key.open(frame, now)
        return () if body is None else self._record_packet(read_objects(body), now)

    def _record_packet(self, packet: BTHomePacket, now: float) -> tuple[BroadcastValue, ...]:
        """Store the parts of a packet, and return its values; none if it is older than the last one."""
        number, last = packet.packet_id, self.packet_id
        is_newer = number is None or last is None or 0 < (number - last) % 256 < NEWER_BY
        if not is_newer and now - self.received_at <= REPEATS_WITHIN:
            return ()
        self.was_read, self.packet_id = True, packet.packet_id
        if packet.firmware:
            self.metadata["firmware"] = packet.firmware
        if packet.device_type is not None:
            self.metadata["device_type"] = str(packet.device_type)
        values = tuple(map(self._meant, packet.values))
        for value in values:
            if value.part not in self.parts and len(self.parts) < MAX_PARTS:
                kind = value.object
                category: Category = "diagnostic" if kind.is_diagnostic else ""
                tag = TAGS.get(kind.name, "")
                self.parts[value.part] = sensor_part(
                    value.part, kind.capability, unit=kind.unit, tag=tag, category=category
                )
            if value.object.capability.startswith("battery"):
                self.silence = max(self.silence, ON_BATTERY)
        return tuple(
            BroadcastValue(value.part, value.object.capability, value.value)
            for value in values
            if value.part in self.parts and not (value.value is None and CAPABILITIES[value.object.capability].is_event)
        )

    def broadcast(
        self, advertisement: Advertisement, address: bytes, values: tuple[BroadcastValue, ...], *, is_locked: bool
    ) -> Broadcast:
        """Return all that is known of the device, with new *values*."""
        return Broadcast(
            name=self.model.name_at(advertisement.address) if self.model.code else advertisement.name,
            parts=tuple(self.parts.values()),
            values=values,
            metadata={"format": "BTHome v2", **self.model.facts, **self.metadata},
            identifiers=(address.hex(":").upper(),) if address else (),
            silence=self.silence,
            problem="it is encrypted, and no bind key is configured for it" if is_locked else "",
        )

    def _meant(self, measured: Measured) -> Measured:
        own = self.model.objects.get(measured.part)
        return measured if own is None else measured._replace(part=own.name, object=own)


class BTHomeParser(BroadcastParser):
    """Reads BTHome v2.

    Args:
        bind_keys: The keys of devices that encrypt, by address; their packets are refused if they are not encrypted.
    """

    def __init__(self, bind_keys: Mapping[str, bytes]) -> None:
        super().__init__(bind_keys)
        self._devices: dict[str, _BTHomeSender] = {}
        self._keys: dict[str, BindKey] = {}  # kept for ever: a forgotten counter would let replays through

    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether it has service data of BTHome."""
        return BTHOME_UUID in advertisement.service_data

    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return all known parts, and the measurements and events of a packet that is new.

        Raises:
            WireError: It is not BTHome v2, cannot be decrypted with the bind key, or is a replay.
        """
        data = advertisement.service_data[BTHOME_UUID]
        frame = read_frame(data)
        known = self._devices.get(advertisement.address)
        device = known or _BTHomeSender()
        if advertisement.name:
            device.model = model_called(advertisement.name)
        key = self._bind_key(advertisement.address)
        if key is not None and not frame.is_encrypted:
            raise WireError("BTHome: it is not encrypted, although a bind key is configured for it", data)
        is_locked = frame.is_encrypted and key is None
        values = () if is_locked else device.read(data, frame, key, now)
        device.data, device.received_at = data, now
        if frame.is_trigger_based:
            device.silence = TRIGGER_BASED
        if known is None and len(self._devices) < MAX_DEVICES:
            self._devices[advertisement.address] = device
        return device.broadcast(advertisement, frame.address, values, is_locked=is_locked)

    def forget(self, address: str) -> None:
        """Forget a device, but not the counter of its bind key."""
        self._devices.pop(address, None)

    def _bind_key(self, address: str) -> BindKey | None:
        key = self.bind_keys.get(address)
        if key is None or address in self._keys:
            return self._keys.get(address)
        from homebot.integrations.bthome.formats.encryption import BindKey  # noqa: PLC0415 - cryptography only where it is used

        try:
            mac = bytes.fromhex(address.replace(":", ""))
        except ValueError as exc:  # macOS shows a UUID instead of the address
            raise WireError(f"BTHome: {address[:40]} is not a MAC address, which decryption needs") from exc
        if len(key) != KEY_SIZE:
            raise WireError(f"BTHome: its bind key has {len(key)} bytes, not {KEY_SIZE}")
        bind_key = self._keys[address] = BindKey(key, mac)
        return bind_key
