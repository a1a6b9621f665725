"""SUBSCRIBE, UNSUBSCRIBE and their answers. Source: MQTT 5.0, sections 3.8 to 3.11."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from homebot.errors import InvalidNameError, UsageError
from homebot.mqtt.packets.primitives import Cursor, encode_text, encode_uint16, encode_varint
from homebot.mqtt.packets.properties import (
    NO_PROPERTIES,
    PacketType,
    Properties,
    decode_properties,
    encode_properties,
)
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion, ReasonCode, by_number
from homebot.mqtt.topics import validate_filter


class MqttSubscription(NamedTuple):
    """One topic filter and how its messages should come; before MQTT 5 the QoS alone counts.

    Attributes:
        filter: Topic filter, or ``$share/GROUP/FILTER``; ``+`` is one level, a final ``#`` is the rest.
        qos: Highest delivery level wanted, 0 to 2.
        no_local: Exclude this client's own publications.
        retain_as_published: Keep the sender's retain flag on live messages.
        retain_handling: Retained messages come 0: always, 1: only with a new subscription, 2: never.

    Source: MQTT Version 5.0, section 3.8.3.1.
    """

    filter: str
    qos: int = 0
    no_local: bool = False
    retain_as_published: bool = False
    retain_handling: int = 0


class Subscribe(NamedTuple):
    """A client asks for messages; *filters* has one entry or more."""

    packet_id: int
    filters: tuple[MqttSubscription, ...]
    properties: Properties = NO_PROPERTIES


class Suback(NamedTuple):
    """The answer to SUBSCRIBE: one reason per filter in the same order; 0 to 2 are the granted QoS."""

    packet_id: int
    reasons: tuple[ReasonCode, ...]
    properties: Properties = NO_PROPERTIES


class Unsubscribe(NamedTuple):
    """A client wants no more messages; *filters* has one entry or more."""

    packet_id: int
    filters: tuple[str, ...]
    properties: Properties = NO_PROPERTIES


class Unsuback(NamedTuple):
    """The answer to UNSUBSCRIBE: one reason per filter in the same order; before MQTT 5 none at all."""

    packet_id: int
    reasons: tuple[ReasonCode, ...] = ()
    properties: Properties = NO_PROPERTIES


def _decode_subscribe(body: bytes, version: ProtocolVersion) -> Subscribe:
    cursor, packet_id, properties = _open(body, PacketType.SUBSCRIBE, version)
    filters: list[MqttSubscription] = []
    while cursor.left:
        _check_number(filters, body)
        name = _filter(cursor)
        options = cursor.uint8()
        qos = options & 3
        reserved = 0xC0 if version == ProtocolVersion.V5 else 0xFC
        if qos == 3 or options & reserved:
            raise PacketError(f"SUBSCRIBE has options 0x{options:02x}", body)
        handling = options >> 4 & 3
        no_local = bool(options & 4)
        if handling == 3 or (no_local and name.startswith("$share/")):
            raise PacketError(f"SUBSCRIBE has options 0x{options:02x}", body, ReasonCode.PROTOCOL_ERROR)
        filters.append(MqttSubscription(name, qos, no_local, bool(options & 8), handling))
    if not filters:
        raise PacketError("SUBSCRIBE has no filter", body, ReasonCode.PROTOCOL_ERROR)
    return Subscribe(packet_id, tuple(filters), properties)


def _encode_subscribe(packet: Subscribe, version: ProtocolVersion) -> bytes:
    if not packet.filters:
        raise UsageError("SUBSCRIBE needs at least one filter")
    body = b"".join(
        [encode_text(subscription.filter) + _encode_options(subscription, version) for subscription in packet.filters]
    )
    return _close(b"\x82", packet, PacketType.SUBSCRIBE, version, body)


def _decode_suback(body: bytes, version: ProtocolVersion) -> Suback:
    cursor, packet_id, properties = _open(body, PacketType.SUBACK, version)
    return Suback(packet_id, _reasons(cursor, _SUBACK_REASONS), properties)


def _encode_suback(packet: Suback, version: ProtocolVersion) -> bytes:
    """Encode the whole packet; before MQTT 5 every failure becomes 0x80."""
    reasons: Sequence[int] = packet.reasons
    if version != ProtocolVersion.V5:
        reasons = [min(reason, 0x80) for reason in reasons]
    return _close(b"\x90", packet, PacketType.SUBACK, version, bytes(reasons))


def _decode_unsubscribe(body: bytes, version: ProtocolVersion) -> Unsubscribe:
    cursor, packet_id, properties = _open(body, PacketType.UNSUBSCRIBE, version)
    filters: list[str] = []
    while cursor.left:
        _check_number(filters, body)
        filters.append(_filter(cursor))
    if not filters:
        raise PacketError("UNSUBSCRIBE has no filter", body, ReasonCode.PROTOCOL_ERROR)
    return Unsubscribe(packet_id, tuple(filters), properties)


def _encode_unsubscribe(packet: Unsubscribe, version: ProtocolVersion) -> bytes:
    if not packet.filters:
        raise UsageError("UNSUBSCRIBE needs at least one filter")
    return _close(b"\xa2", packet, PacketType.UNSUBSCRIBE, version, b"".join(map(encode_text, packet.filters)))


def _decode_unsuback(body: bytes, version: ProtocolVersion) -> Unsuback:
    cursor, packet_id, properties = _open(body, PacketType.UNSUBACK, version)
    if version != ProtocolVersion.V5:
        cursor.finish()
        return Unsuback(packet_id)
    return Unsuback(packet_id, _reasons(cursor, _UNSUBACK_REASONS), properties)


def _encode_unsuback(packet: Unsuback, version: ProtocolVersion) -> bytes:
    """Encode the whole packet; before MQTT 5 the reasons are left out."""
    body = bytes(packet.reasons) if version == ProtocolVersion.V5 else b""
    return _close(b"\xb0", packet, PacketType.UNSUBACK, version, body)


DECODERS: dict[PacketType, Callable[[bytes, ProtocolVersion], Subscribe | Suback | Unsubscribe | Unsuback]] = {
    PacketType.SUBSCRIBE: _decode_subscribe,
    PacketType.SUBACK: _decode_suback,
    PacketType.UNSUBSCRIBE: _decode_unsubscribe,
    PacketType.UNSUBACK: _decode_unsuback,
}
ENCODERS: dict[type, Callable[..., bytes]] = {
    Subscribe: _encode_subscribe,
    Suback: _encode_suback,
    Unsubscribe: _encode_unsubscribe,
    Unsuback: _encode_unsuback,
}

_MAX_FILTERS: Final = 5000  # of one packet, which is read in one piece

_COMMON_REASONS = by_number(
    ReasonCode.SUCCESS,
    ReasonCode.UNSPECIFIED_ERROR,
    ReasonCode.IMPLEMENTATION_SPECIFIC_ERROR,
    ReasonCode.NOT_AUTHORIZED,
    ReasonCode.TOPIC_FILTER_INVALID,
    ReasonCode.PACKET_IDENTIFIER_IN_USE,
)
_UNSUBACK_REASONS = _COMMON_REASONS | by_number(ReasonCode.NO_SUBSCRIPTION_EXISTED)
_SUBACK_REASONS = _COMMON_REASONS | by_number(
    ReasonCode.GRANTED_QOS_1,
    ReasonCode.GRANTED_QOS_2,
    ReasonCode.QUOTA_EXCEEDED,
    ReasonCode.SHARED_SUBSCRIPTIONS_NOT_SUPPORTED,
    ReasonCode.SUBSCRIPTION_IDENTIFIERS_NOT_SUPPORTED,
    ReasonCode.WILDCARD_SUBSCRIPTIONS_NOT_SUPPORTED,
)


def _open(body: bytes, packet: PacketType, version: ProtocolVersion) -> tuple[Cursor, int, Properties]:
    cursor = Cursor(body)
    packet_id = cursor.uint16()
    if not packet_id:
        raise PacketError("packet id is 0", body, ReasonCode.PROTOCOL_ERROR)
    properties = NO_PROPERTIES
    if version == ProtocolVersion.V5:
        properties = decode_properties(cursor, packet)
    return cursor, packet_id, properties


def _close(
    first: bytes,
    packet: Subscribe | Suback | Unsubscribe | Unsuback,
    packet_type: PacketType,
    version: ProtocolVersion,
    body: bytes,
) -> bytes:
    head = encode_uint16(packet.packet_id)
    if version == ProtocolVersion.V5:
        head += b"\0" if packet.properties is NO_PROPERTIES else encode_properties(packet.properties, packet_type)
    return first + encode_varint(len(head) + len(body)) + head + body


def _check_number(filters: Sequence[object], body: bytes) -> None:
    if len(filters) == _MAX_FILTERS:
        raise PacketError(f"more than {_MAX_FILTERS} filters", body, ReasonCode.QUOTA_EXCEEDED)


def _filter(cursor: Cursor) -> str:
    name = cursor.text()
    try:
        validate_filter(name)
    except InvalidNameError as error:
        problem = f"topic filter {name[:40]!r} {error.problem}"
        raise PacketError(problem, cursor.body, ReasonCode.TOPIC_FILTER_INVALID) from None
    return name


def _encode_options(request: MqttSubscription, version: ProtocolVersion) -> bytes:
    options = request.qos
    if version == ProtocolVersion.V5:
        options |= request.no_local << 2 | request.retain_as_published << 3 | request.retain_handling << 4
    return options.to_bytes(1, "big")


def _reasons(cursor: Cursor, known: dict[int, ReasonCode]) -> tuple[ReasonCode, ...]:
    numbers = cursor.read(cursor.left)
    if not numbers or not known.keys() >= set(numbers):
        raise PacketError("there is no reason, or an unknown one", cursor.body, ReasonCode.PROTOCOL_ERROR)
    return tuple([known[number] for number in numbers])
