"""The properties of MQTT 5: one table of all of them, and their codec. Source: MQTT 5.0, section 2.2.2."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from homebot.errors import UsageError
from homebot.mqtt.packets.primitives import Cursor, encode_binary, encode_text, encode_uint16, encode_varint
from homebot.mqtt.packets.reason import PacketError, ReasonCode


class PacketType(IntEnum):
    """The type of a packet: the upper four bits of its first byte. WILL stands for a will's own properties."""

    WILL = 0
    CONNECT = 1
    CONNACK = 2
    PUBLISH = 3
    PUBACK = 4
    PUBREC = 5
    PUBREL = 6
    PUBCOMP = 7
    SUBSCRIBE = 8
    SUBACK = 9
    UNSUBSCRIBE = 10
    UNSUBACK = 11
    PINGREQ = 12
    PINGRESP = 13
    DISCONNECT = 14
    AUTH = 15


@dataclass(frozen=True, slots=True, kw_only=True)
class Properties:
    """The properties of one packet; None, or an empty tuple, where a property is absent.

    Intervals are in seconds. Which packet may carry which property is checked by the codec. Names and meanings
    are those of MQTT 5.0, section 2.2.2.2.
    """

    payload_format_indicator: int | None = None
    message_expiry_interval: int | None = None
    content_type: str | None = None
    response_topic: str | None = None
    correlation_data: bytes | None = None
    subscription_identifiers: tuple[int, ...] = ()
    session_expiry_interval: int | None = None
    assigned_client_identifier: str | None = None
    server_keep_alive: int | None = None
    authentication_method: str | None = None
    authentication_data: bytes | None = None
    request_problem_information: int | None = None
    will_delay_interval: int | None = None
    request_response_information: int | None = None
    response_information: str | None = None
    server_reference: str | None = None
    reason_string: str | None = None
    receive_maximum: int | None = None
    topic_alias_maximum: int | None = None
    topic_alias: int | None = None
    maximum_qos: int | None = None
    retain_available: int | None = None
    user_properties: tuple[tuple[str, str], ...] = ()
    maximum_packet_size: int | None = None
    wildcard_subscription_available: int | None = None
    subscription_identifier_available: int | None = None
    shared_subscription_available: int | None = None


NO_PROPERTIES = Properties()
"""The properties of a packet without any; compare with ``is`` where speed matters."""


def decode_properties(cursor: Cursor, packet: PacketType) -> Properties:
    """Read the property length and the properties that *packet* may carry.

    Raises:
        PacketError: 0x97 for more than 1,000 user properties or subscription identifiers; 0x81 for an unknown or
            cut property; 0x82 for one that is doubled, out of its range, or
            not allowed in this packet; 0x94 for a topic alias of 0.
    """
    size = cursor.varint()
    if size == 0:
        return NO_PROPERTIES
    stop = cursor.position + size
    whole_end = cursor.end
    if stop > whole_end:
        raise PacketError("the properties are longer than the packet", cursor.body)
    cursor.end = stop  # no property may run past the length that was announced
    fields: dict[str, object] = {}
    users: list[tuple[str, str]] = []
    identifiers: list[int] = []
    while cursor.position < stop:
        number = cursor.varint()
        row = _row_of(number, packet, cursor)
        if len(users) + len(identifiers) == _MAX_REPEATED:
            raise PacketError(f"more than {_MAX_REPEATED} properties", cursor.body, ReasonCode.QUOTA_EXCEEDED)
        if row.kind is _PAIR:
            users.append((cursor.text(), cursor.text()))
            continue
        value = row.kind.read(cursor)
        if row.check is not None:
            row.check(row.name, value, cursor)
        if number == _SUBSCRIPTION_IDENTIFIER and packet is PacketType.PUBLISH:
            identifiers.append(value)  # type: ignore[arg-type] # the table says varint
        elif row.name in fields:
            raise _not_allowed(f"{row.name} comes twice", cursor)
        else:
            fields[row.name] = (value,) if number == _SUBSCRIPTION_IDENTIFIER else value
    cursor.end = whole_end
    if identifiers:
        fields["subscription_identifiers"] = tuple(identifiers)
    return Properties(user_properties=tuple(users), **fields)  # type: ignore[arg-type] # the table has the types


def encode_properties(properties: Properties, packet: PacketType) -> bytes:
    """Encode the property length and the properties.

    Raises:
        UsageError: *packet* must not carry one of them, or a value does not fit its type.
    """
    if properties is NO_PROPERTIES:
        return b"\0"
    out = bytearray()
    for row in _TABLE:
        value = getattr(properties, row.name)
        if value is None or value == ():
            continue
        if packet not in row.packets:
            raise UsageError(f"{packet.name} must not carry {row.name}")
        for item in value if isinstance(value, tuple) else (value,):
            out.append(row.number)
            out += row.kind.write(item)
    return encode_varint(len(out)) + out


def decode_reason(
    body: bytes, start: int, packet: PacketType, known: Mapping[int, ReasonCode]
) -> tuple[ReasonCode, Properties]:
    """Decode the end of a packet from *start* on: a reason and properties, each of which may be missing.

    Raises:
        PacketError: 0x81 malformed, 0x82 a reason that is not *known*.
    """
    if len(body) == start:
        return ReasonCode.SUCCESS, NO_PROPERTIES
    reason = known.get(body[start])
    if reason is None:
        raise PacketError(f"{packet.name} has reason 0x{body[start]:02x}", body, ReasonCode.PROTOCOL_ERROR)
    if len(body) == start + 1:
        return reason, NO_PROPERTIES
    cursor = Cursor(body)
    cursor.position = start + 1
    properties = decode_properties(cursor, packet)
    cursor.finish()
    return reason, properties


def encode_reason(reason: ReasonCode, properties: Properties, packet: PacketType) -> bytes:
    """Encode the end of a packet, without optional parts."""
    if properties is NO_PROPERTIES:
        return b"" if reason is ReasonCode.SUCCESS else reason.to_bytes(1, "big")
    return reason.to_bytes(1, "big") + encode_properties(properties, packet)


class _PropertyKind(NamedTuple):
    read: Callable[[Cursor], object]
    write: Callable[..., bytes]


def _encode_uint8(value: int) -> bytes:
    if not 0 <= value <= 0xFF:
        raise UsageError(f"{value} does not fit into one byte")
    return value.to_bytes(1, "big")


def _encode_uint32(value: int) -> bytes:
    if not 0 <= value <= 0xFFFF_FFFF:
        raise UsageError(f"{value} does not fit into four bytes")
    return value.to_bytes(4, "big")


def _encode_pair(pair: tuple[str, str]) -> bytes:
    return encode_text(pair[0]) + encode_text(pair[1])


_UINT8 = _PropertyKind(Cursor.uint8, _encode_uint8)
_UINT16 = _PropertyKind(Cursor.uint16, encode_uint16)
_UINT32 = _PropertyKind(Cursor.uint32, _encode_uint32)
_VARINT = _PropertyKind(Cursor.varint, encode_varint)
_TEXT = _PropertyKind(Cursor.text, encode_text)
_BINARY = _PropertyKind(Cursor.binary, encode_binary)
_PAIR = _PropertyKind(Cursor.text, _encode_pair)


def _not_allowed(problem: str, cursor: Cursor) -> PacketError:
    return PacketError(problem, cursor.body, ReasonCode.PROTOCOL_ERROR)


def _flag(name: str, value: object, cursor: Cursor) -> None:
    if value not in (0, 1):
        raise _not_allowed(f"{name} is {value}, not 0 or 1", cursor)


def _not_zero(name: str, value: object, cursor: Cursor) -> None:
    if value == 0:
        raise _not_allowed(f"{name} is 0", cursor)


def _alias(name: str, value: object, cursor: Cursor) -> None:
    if value == 0:
        raise PacketError(f"{name} is 0", cursor.body, ReasonCode.TOPIC_ALIAS_INVALID)


def _plain_topic(name: str, value: object, cursor: Cursor) -> None:
    if not isinstance(value, str) or not value or "+" in value or "#" in value:
        raise _not_allowed(f"{name} is not a topic name", cursor)


class _Row(NamedTuple):
    number: int
    name: str
    kind: _PropertyKind
    packets: frozenset[PacketType]
    check: Callable[[str, object, Cursor], None] | None = None


def _in(*packets: PacketType) -> frozenset[PacketType]:
    return frozenset(packets)


_P = PacketType
_MESSAGE = _in(_P.PUBLISH, _P.WILL)
_SIGN_IN = _in(_P.CONNECT, _P.CONNACK)
_ANSWERS = (_P.CONNACK, _P.PUBACK, _P.PUBREC, _P.PUBREL, _P.PUBCOMP, _P.SUBACK, _P.UNSUBACK)
_SUBSCRIPTION_IDENTIFIER = 0x0B
_MAX_REPEATED = 1000  # each takes some hundred bytes and a microsecond

_TABLE = (
    _Row(0x01, "payload_format_indicator", _UINT8, _MESSAGE, _flag),
    _Row(0x02, "message_expiry_interval", _UINT32, _MESSAGE),
    _Row(0x03, "content_type", _TEXT, _MESSAGE),
    _Row(0x08, "response_topic", _TEXT, _MESSAGE, _plain_topic),
    _Row(0x09, "correlation_data", _BINARY, _MESSAGE),
    _Row(0x0B, "subscription_identifiers", _VARINT, _in(_P.PUBLISH, _P.SUBSCRIBE), _not_zero),
    _Row(0x11, "session_expiry_interval", _UINT32, _in(_P.CONNECT, _P.CONNACK, _P.DISCONNECT)),
    _Row(0x12, "assigned_client_identifier", _TEXT, _in(_P.CONNACK)),
    _Row(0x13, "server_keep_alive", _UINT16, _in(_P.CONNACK)),
    _Row(0x15, "authentication_method", _TEXT, _in(_P.CONNECT, _P.CONNACK, _P.AUTH)),
    _Row(0x16, "authentication_data", _BINARY, _in(_P.CONNECT, _P.CONNACK, _P.AUTH)),
    _Row(0x17, "request_problem_information", _UINT8, _in(_P.CONNECT), _flag),
    _Row(0x18, "will_delay_interval", _UINT32, _in(_P.WILL)),
    _Row(0x19, "request_response_information", _UINT8, _in(_P.CONNECT), _flag),
    _Row(0x1A, "response_information", _TEXT, _in(_P.CONNACK)),
    _Row(0x1C, "server_reference", _TEXT, _in(_P.CONNACK, _P.DISCONNECT)),
    _Row(0x1F, "reason_string", _TEXT, _in(*_ANSWERS, _P.DISCONNECT, _P.AUTH)),
    _Row(0x21, "receive_maximum", _UINT16, _SIGN_IN, _not_zero),
    _Row(0x22, "topic_alias_maximum", _UINT16, _SIGN_IN),
    _Row(0x23, "topic_alias", _UINT16, _in(_P.PUBLISH), _alias),
    _Row(0x24, "maximum_qos", _UINT8, _in(_P.CONNACK), _flag),
    _Row(0x25, "retain_available", _UINT8, _in(_P.CONNACK), _flag),
    _Row(0x26, "user_properties", _PAIR, frozenset(_P) - {_P.PINGREQ, _P.PINGRESP}),
    _Row(0x27, "maximum_packet_size", _UINT32, _SIGN_IN, _not_zero),
    _Row(0x28, "wildcard_subscription_available", _UINT8, _in(_P.CONNACK), _flag),
    _Row(0x29, "subscription_identifier_available", _UINT8, _in(_P.CONNACK), _flag),
    _Row(0x2A, "shared_subscription_available", _UINT8, _in(_P.CONNACK), _flag),
)
_BY_NUMBER = {row.number: row for row in _TABLE}


def _row_of(number: int, packet: PacketType, cursor: Cursor) -> _Row:
    row = _BY_NUMBER.get(number)
    if row is None:
        raise PacketError(f"unknown property 0x{number:02x}", cursor.body)
    if packet not in row.packets:
        raise _not_allowed(f"{packet.name} must not carry {row.name}", cursor)
    return row
