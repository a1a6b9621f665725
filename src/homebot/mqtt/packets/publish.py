"""PUBLISH and the four packets that acknowledge it. Source: MQTT 5.0, sections 3.3 to 3.7."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from homebot.errors import UsageError
from homebot.mqtt.packets.primitives import MAX_UINT16, Cursor, encode_text, encode_uint16, encode_varint
from homebot.mqtt.packets.properties import (
    NO_PROPERTIES,
    PacketType,
    Properties,
    decode_properties,
    decode_reason,
    encode_properties,
    encode_reason,
)
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion, ReasonCode, by_number


class Publish(NamedTuple):
    """A message on its way. A tuple and not a dataclass: it is made for every message, four times as fast.

    Attributes:
        topic: Topic name; empty where a topic alias stands for it (MQTT 5).
        qos: 0, 1 or 2.
        packet_id: 1 to 65,535 at QoS 1 and 2, None at QoS 0.
        properties: MQTT 5 only.
    """

    topic: str
    payload: bytes = b""
    qos: int = 0
    retain: bool = False
    dup: bool = False
    packet_id: int | None = None
    properties: Properties = NO_PROPERTIES


class Acknowledgement(NamedTuple):
    """An answer about one message; a tuple, as :class:`Publish`, because it comes as often."""

    packet_id: int
    reason: ReasonCode = ReasonCode.SUCCESS
    properties: Properties = NO_PROPERTIES


class Puback(Acknowledgement):
    """The answer to a PUBLISH at QoS 1."""

    __slots__ = ()


class Pubrec(Acknowledgement):
    """The first answer to a PUBLISH at QoS 2."""

    __slots__ = ()


class Pubrel(Acknowledgement):
    """The sender's answer to PUBREC: the packet id may be forgotten."""

    __slots__ = ()


class Pubcomp(Acknowledgement):
    """The end of a QoS 2 exchange."""

    __slots__ = ()


def decode_publish(flags: int, data: bytes, start: int, end: int, version: ProtocolVersion) -> Publish:
    """Decode the body of a PUBLISH that lies in ``data[start:end]``.

    Args:
        flags: The lower four bits of the packet's first byte.
        data: Bytes that hold at least the whole packet.
        start: Index of the first byte behind the fixed header.
        end: Index behind the last byte of the packet.

    Raises:
        PacketError: 0x81 malformed, 0x82 packet id 0 or a forbidden property, 0x90 a wildcard in the topic,
            0x94 a topic alias of 0.
    """
    if end - start < 2:
        raise PacketError("PUBLISH ends before its topic", data[start:end])
    position = start + 2 + (data[start] << 8 | data[start + 1])
    if position > end or flags in _ILLEGAL_FLAGS[version]:
        raise PacketError(f"PUBLISH has flags 0x{flags:x} or is too short", data[start:end])
    try:
        topic = data[start + 2 : position].decode()
    except UnicodeDecodeError:
        raise PacketError("the topic is not valid UTF-8", data[start:end]) from None
    if "+" in topic or "#" in topic or "\0" in topic:
        body = data[start:end]
        if "\0" in topic:
            raise PacketError("the topic has a NUL", body)
        raise PacketError("the topic has a wildcard", body, ReasonCode.TOPIC_NAME_INVALID)
    qos, retain, dup = _FLAGS[flags]
    packet_id: int | None = None
    if qos:
        packet_id = _read_packet_id("PUBLISH", data, position, end)
        position += 2
    properties = NO_PROPERTIES
    if version is ProtocolVersion.V5:
        if position < end and not data[position]:  # as in most
            position += 1
        else:
            cursor = Cursor(data[position:end])
            properties = decode_properties(cursor, PacketType.PUBLISH)
            position += cursor.position
    if not topic and properties.topic_alias is None:
        raise PacketError("PUBLISH has no topic", data[start:end], ReasonCode.PROTOCOL_ERROR)
    return Publish(topic, data[position:end], qos, retain, dup, packet_id, properties)


_FLAGS = tuple((flags >> 1 & 3, flags & 1 == 1, flags & 8 == 8) for flags in range(16))
"""QoS, retain and dup, by the flags of a PUBLISH."""

_OF_QOS_3 = frozenset({0x6, 0x7, 0xE, 0xF})
_ILLEGAL_FLAGS = dict.fromkeys(ProtocolVersion, _OF_QOS_3 | {0x8, 0x9}) | {ProtocolVersion.V31: _OF_QOS_3}
"""MQTT 3.1 lets a PUBLISH of QoS 0 be a duplicate."""


def _encode_publish(packet: Publish, version: ProtocolVersion) -> bytes:
    topic, payload, qos, retain, dup, packet_id, properties = packet
    encoded = encode_properties(properties, PacketType.PUBLISH) if version is ProtocolVersion.V5 else b""
    head, tail = encode_publish_parts(topic, payload, qos, retain, encoded, dup=dup)
    if qos == 0:
        if packet_id is not None:
            raise UsageError("a PUBLISH at QoS 0 has no packet id")
        return head + tail
    if packet_id is None or not 0 < packet_id <= MAX_UINT16:
        raise UsageError(f"a PUBLISH at QoS {qos} needs a packet id from 1 to 65535")
    return head + packet_id.to_bytes(2, "big") + tail


def encode_publish_parts(
    topic: str,
    payload: bytes,
    qos: int,
    retain: bool,  # noqa: FBT001 - made for every message, by position for speed
    properties: bytes,
    *,
    dup: bool = False,
) -> tuple[bytes, bytes]:
    """Encode the bytes before and behind the packet id, so that receivers with other ids can share both.

    At QoS 1 and 2 room for the packet id is counted. Arguments as the attributes of :class:`Publish`, but for the
    properties, which :func:`homebot.mqtt.packets.properties.encode_properties` has encoded; empty for MQTT 3.1.1.

    Raises:
        UsageError: A field does not fit its type.
    """
    if topic.isascii() and "\0" not in topic and len(topic) <= MAX_UINT16:  # as nearly all are
        name = len(topic).to_bytes(2, "big") + topic.encode()
    else:
        name = encode_text(topic)
    if properties:
        payload = properties + payload
    first = 0x30 | dup << 3 | qos << 1 | retain
    size = len(name) + len(payload) + (2 if qos else 0)
    if size < 0x80:
        return bytes((first, size)) + name, payload
    return first.to_bytes(1, "big") + encode_varint(size) + name, payload


def _decode_acknowledgement(packet_type: PacketType, body: bytes, version: ProtocolVersion) -> Acknowledgement:
    _, kind, reasons = _ACKNOWLEDGEMENTS[packet_type]
    packet_id = _read_packet_id(packet_type.name, body, 0, len(body))
    if len(body) == 2:
        return kind(packet_id)
    if version != ProtocolVersion.V5:
        raise PacketError(f"{packet_type.name} is longer than two bytes", body)
    return kind(packet_id, *decode_reason(body, 2, packet_type, reasons))


def _encode_acknowledgement(packet_type: PacketType, packet: Acknowledgement, version: ProtocolVersion) -> bytes:
    first = _ACKNOWLEDGEMENTS[packet_type][0]
    if version != ProtocolVersion.V5 or (packet.properties is NO_PROPERTIES and packet.reason is ReasonCode.SUCCESS):
        return first + b"\x02" + packet.packet_id.to_bytes(2, "big")
    body = encode_uint16(packet.packet_id) + encode_reason(packet.reason, packet.properties, packet_type)
    return first + encode_varint(len(body)) + body


_PUBLISH_REASONS = by_number(
    ReasonCode.SUCCESS,
    ReasonCode.NO_MATCHING_SUBSCRIBERS,
    ReasonCode.UNSPECIFIED_ERROR,
    ReasonCode.IMPLEMENTATION_SPECIFIC_ERROR,
    ReasonCode.NOT_AUTHORIZED,
    ReasonCode.TOPIC_NAME_INVALID,
    ReasonCode.PACKET_IDENTIFIER_IN_USE,
    ReasonCode.QUOTA_EXCEEDED,
    ReasonCode.PAYLOAD_FORMAT_INVALID,
)
_RELEASE_REASONS = by_number(ReasonCode.SUCCESS, ReasonCode.PACKET_IDENTIFIER_NOT_FOUND)

_ACKNOWLEDGEMENTS: dict[PacketType, tuple[bytes, type[Acknowledgement], dict[int, ReasonCode]]] = {
    PacketType.PUBACK: (b"\x40", Puback, _PUBLISH_REASONS),
    PacketType.PUBREC: (b"\x50", Pubrec, _PUBLISH_REASONS),
    PacketType.PUBREL: (b"\x62", Pubrel, _RELEASE_REASONS),
    PacketType.PUBCOMP: (b"\x70", Pubcomp, _RELEASE_REASONS),
}
DECODERS: dict[PacketType, Callable[[bytes, ProtocolVersion], Acknowledgement]] = {
    packet_type: partial(_decode_acknowledgement, packet_type) for packet_type in _ACKNOWLEDGEMENTS
}
ENCODERS: dict[type, Callable[..., bytes]] = {Publish: _encode_publish} | {
    kind: partial(_encode_acknowledgement, packet_type) for packet_type, (_, kind, _) in _ACKNOWLEDGEMENTS.items()
}


def _read_packet_id(name: str, data: bytes, position: int, end: int) -> int:
    if position + 2 > end:
        raise PacketError(f"{name} ends before its packet id", data[position:end])
    packet_id = data[position] << 8 | data[position + 1]
    if not packet_id:
        raise PacketError("packet id is 0", data[position:end], ReasonCode.PROTOCOL_ERROR)
    return packet_id
