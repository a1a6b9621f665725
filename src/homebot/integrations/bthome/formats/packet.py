"""One broadcast of BTHome v2, as bytes and as values. Pure.

Source: https://bthome.io/format. The service data of the UUID 0xFCD2 begin with a byte of flags, bits 0 (encrypted),
1 (an address of six bytes follows), 2 (trigger based: nothing is sent until something happens) and 5 to 7 (the version,
2). Objects follow, each an id and data of the size that the id says, in ascending order of ids. Receivers stop at an
id that they do not know, as they cannot tell its size.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from decimal import Decimal
from typing import NamedTuple

from homebot.conventions.bluetooth.bthome_objects import (
    BTHOME_OBJECTS,
    BUTTON,
    BUTTON_PRESSES,
    COMMAND,
    COMMANDS,
    DEVICE_TYPE,
    DIMMER,
    DIMMER_TURNS,
    FIRMWARE_3,
    FIRMWARE_4,
    PACKET_ID,
    RAW,
    TEXT,
    TIMESTAMP,
    BTHomeObject,
)
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import WireError

BTHOME_UUID = "0000fcd2-0000-1000-8000-00805f9b34fb"
VERSION = 2
_ADDRESS = 6
_MAX_ARGUMENTS = 0x1F
_WORDS = {BUTTON: BUTTON_PRESSES, DIMMER: DIMMER_TURNS, COMMAND: COMMANDS}


class Measured(NamedTuple):
    """One value of a packet.

    Attributes:
        part: Its part: the name of its object, with ``_2`` and so on from the second of that name.
        value: In the unit of the vocabulary, or that of the object; of an event, its word.
    """

    part: str
    object: BTHomeObject
    value: PlainValue


@dataclass(frozen=True, slots=True)
class BTHomeFrame:
    """The outside of a packet.

    Attributes:
        address: The address in the packet; empty if it has none.
        body: The rest: the objects, plain or encrypted.
    """

    flags: int
    address: bytes
    body: bytes

    @property
    def is_encrypted(self) -> bool:
        """True if the body is encrypted."""
        return bool(self.flags & 1)

    @property
    def is_trigger_based(self) -> bool:
        """True if the device is silent until something happens."""
        return bool(self.flags & 4)


@dataclass(frozen=True, slots=True)
class BTHomePacket:
    """The inside of a packet.

    Attributes:
        packet_id: The number of the packet, 0 to 255; None if it has none.
        firmware: The version of the firmware; empty if it says none.
        device_type: The number of the model, a manufacturer's own; None if it says none.
        unread: Bytes at the end that begin with an object id which is not known.
    """

    packet_id: int | None = None
    values: tuple[Measured, ...] = field(default_factory=tuple)
    firmware: str = ""
    device_type: int | None = None
    unread: int = 0


def read_frame(data: bytes) -> BTHomeFrame:
    """Return the service *data* of BTHome, taken apart.

    Raises:
        WireError: They are too short, or of another version.
    """
    if not data:
        raise WireError("BTHome: there are no data", data)
    flags = data[0]
    if flags >> 5 != VERSION:
        raise WireError(f"BTHome: its version is {flags >> 5}, not {VERSION}", data)
    has_address = bool(flags & 2)
    if has_address and len(data) < 1 + _ADDRESS:
        raise WireError("BTHome: its address is cut off", data)
    body_at = 1 + _ADDRESS if has_address else 1
    return BTHomeFrame(flags, data[1:body_at][::-1], data[body_at:])


def read_objects(body: bytes) -> BTHomePacket:
    """Return the values of the objects of a packet.

    Raises:
        WireError: An object is cut off, or its text is no text.
    """
    packet_id: int | None = None
    device_type: int | None = None
    firmware = ""
    values: list[Measured] = []
    seen: dict[str, int] = {}
    read_to = 0
    for object_id, data, end in _objects(body):
        read_to = end
        if object_id == PACKET_ID:
            packet_id = data[0]
        elif object_id == DEVICE_TYPE:
            device_type = int.from_bytes(data, "little")
        elif object_id in {FIRMWARE_3, FIRMWARE_4}:
            firmware = ".".join(str(byte) for byte in reversed(data))
        else:
            kind = BTHOME_OBJECTS[object_id]
            count = seen[kind.name] = seen.get(kind.name, 0) + 1
            part = kind.name if count == 1 else f"{kind.name}_{count}"
            values.append(Measured(part, kind, _value(object_id, kind, data, body)))
    return BTHomePacket(packet_id, tuple(values), firmware, device_type, len(body) - read_to)


def _objects(body: bytes) -> Iterator[tuple[int, bytes, int]]:
    """Yield each object's id, its data, and where it ends, up to the first id that is not known."""
    at = 0
    while at < len(body):
        object_id = body[at]
        kind = BTHOME_OBJECTS.get(object_id)
        if kind is None:
            return
        begin, size = at + 1, kind.size
        if not size:
            if begin == len(body):
                raise WireError(f"BTHome: the object {object_id:#04x} has no length", body)
            size = body[begin] if object_id != COMMAND else 1 + (body[begin] & _MAX_ARGUMENTS)
            begin += 1
        at = begin + size
        if at > len(body):
            raise WireError(f"BTHome: the object {object_id:#04x} is cut off", body)
        yield object_id, body[begin:at], at


def _value(object_id: int, kind: BTHomeObject, data: bytes, body: bytes) -> PlainValue:
    if object_id in _WORDS:
        word = _WORDS[object_id].get(data[0])
        return f"{word} {data[1]}" if object_id == DIMMER and word is not None else word
    if object_id == TEXT:
        try:
            return data.decode()
        except UnicodeDecodeError as exc:
            raise WireError("BTHome: a text is not UTF-8", body) from exc
    if object_id == RAW:
        return data.hex()
    number = int.from_bytes(data, "little", signed=kind.signed)
    if object_id == TIMESTAMP:
        return datetime.fromtimestamp(number, tz=UTC).isoformat()
    if CAPABILITIES[kind.capability].kind == "bool":
        return bool(number) is not kind.is_inverted
    return float(number * Decimal(kind.factor))
