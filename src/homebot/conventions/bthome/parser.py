"""Reads BTHome v2, the broadcasts of Shelly BLU and of many sensors that people build. Pure.

Source: https://bthome.io/format. A device sends each packet several times; the packet id tells packets apart. One that
is older than the last, by its id, came late, and is left out. Devices without packet ids are said to repeat a packet as
long as its bytes are the same without a pause of four seconds (as the library ``bthome-ble`` does).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from homebot.conventions.bluetooth.advertisement import Advertisement
from homebot.conventions.bluetooth.broadcast import Broadcast, BroadcastParser, BroadcastValue
from homebot.conventions.bthome.objects import BTHomeObject
from homebot.conventions.bthome.packet import BTHOME_UUID, BTHomePacket, Measured, read_frame, read_objects
from homebot.conventions.units import sensor_type
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.errors import WireError

if TYPE_CHECKING:
    from homebot.conventions.bthome.encryption import BindKey

__all__ = ["BTHomeParser"]

REPEATS_WITHIN = 4.0
"""Seconds."""

NEWER_BY = 64
"""Packet ids ahead of the last one, modulo 256, up to which one is newer than that."""

ON_BATTERY = 300.0
"""Seconds for which a device on a battery may be silent: it saves power."""

TRIGGER_BASED = 86_400.0
"""Seconds for which one may be silent that sends nothing until something happens."""

MAX_PARTS = 64
"""Parts of one device: a packet has room for fewer, but they may change."""

MAX_DEVICES = 10_000
_TAGS: Mapping[str, str] = {"door": "door", "window": "window", "garage_door": "garage_door"}


class _BTHomeSender:
    """The packets of one device so far, as far as they matter."""

    def __init__(self, key: BindKey | None) -> None:
        self.key = key
        self.parts: dict[str, Part] = {}
        self.metadata: dict[str, str] = {}
        self.packet_id: int | None = None
        self.data = b""
        self.heard_at = float("-inf")
        self.silence = 0.0
        self.was_read = False


class BTHomeParser(BroadcastParser):
    """Reads BTHome v2.

    Args:
        bind_keys: The keys of devices that encrypt, by address; of these, what is not encrypted is refused.
    """

    def __init__(self, bind_keys: Mapping[str, bytes]) -> None:
        super().__init__(bind_keys)
        self._devices: dict[str, _BTHomeSender] = {}

    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether there are service data of BTHome."""
        return BTHOME_UUID in advertisement.service_data

    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return the measurements and events of a packet that is new, and all parts known.

        Raises:
            WireError: It is not BTHome v2, or does not open with the bind key.
        """
        data = advertisement.service_data[BTHOME_UUID]
        frame = read_frame(data)
        known = self._devices.get(advertisement.address)
        device = known or _BTHomeSender(self._bind_key(advertisement.address))
        values: tuple[BroadcastValue, ...] = ()
        problem = ""
        if frame.is_encrypted and device.key is None:
            problem = "it encrypts, and its bind key is not configured"
        elif device.key is not None and not frame.is_encrypted:
            raise WireError("BTHome: it does not encrypt although it has a bind key", data)
        elif not (device.was_read and self._is_repeated(device, data, now)):
            body = frame.body if device.key is None else device.key.open(frame)
            values = self._take(device, read_objects(body), now)
        device.data, device.heard_at = data, now
        if frame.is_trigger_based:
            device.silence = TRIGGER_BASED
        if known is None and len(self._devices) < MAX_DEVICES:
            self._devices[advertisement.address] = device
        own = (":".join(f"{one:02X}" for one in frame.address),) if frame.address else ()
        return Broadcast(
            name=advertisement.name,
            parts=tuple(device.parts.values()),
            values=values,
            metadata={"format": "BTHome v2", **device.metadata},
            identifiers=own,
            silence=device.silence,
            problem=problem,
        )

    def forget(self, address: str) -> None:
        """Forget a device."""
        self._devices.pop(address, None)

    def _bind_key(self, address: str) -> BindKey | None:
        key = self.bind_keys.get(address)
        if key is None:
            return None
        from homebot.conventions.bthome.encryption import BindKey  # noqa: PLC0415 - cryptography only where it is used

        digits = address.replace(":", "")
        try:
            return BindKey(key, bytes.fromhex(digits))
        except ValueError as exc:  # on macOS a device has no address that is known
            raise WireError(f"BTHome: {address[:40]} is no address, so that nothing can be decrypted") from exc

    def _is_repeated(self, device: _BTHomeSender, data: bytes, now: float) -> bool:
        return data == device.data and (device.packet_id is not None or now - device.heard_at <= REPEATS_WITHIN)

    def _take(self, device: _BTHomeSender, packet: BTHomePacket, now: float) -> tuple[BroadcastValue, ...]:
        """Keep what a packet says, and return its values; none where it is older than the last."""
        number, last = packet.packet_id, device.packet_id
        if (
            number is not None
            and last is not None
            and now - device.heard_at <= REPEATS_WITHIN
            and not 0 < (number - last) % 256 < NEWER_BY
        ):
            return ()
        device.was_read = True
        device.packet_id = number
        if packet.firmware:
            device.metadata["firmware"] = packet.firmware
        if packet.device_type is not None:
            device.metadata["device_type"] = str(packet.device_type)
        self._add_parts(device, packet.values)
        return tuple(
            BroadcastValue(one.part, one.object.capability, one.value)
            for one in packet.values
            if one.part in device.parts and not (one.value is None and CAPABILITIES[one.object.capability].is_event)
        )

    def _add_parts(self, device: _BTHomeSender, values: Iterable[Measured]) -> None:
        for one in values:
            if one.part not in device.parts and len(device.parts) < MAX_PARTS:
                device.parts[one.part] = _part(one.part, one.object)
            if one.object.capability.startswith("battery"):
                device.silence = max(device.silence, ON_BATTERY)


def _part(part_id: str, kind: BTHomeObject) -> Part:
    return Part(
        id=part_id,
        service_type=sensor_type(kind.capability),
        tag=_TAGS.get(kind.name, ""),
        category="diagnostic" if kind.is_diagnostic else "",
        capabilities=(Capability(name=kind.capability, unit=kind.unit),),
    )
