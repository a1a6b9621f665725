"""CONNECT, CONNACK, DISCONNECT, AUTH and the two pings. Source: MQTT 5.0, sections 3.1, 3.2 and 3.12 to 3.15."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from homebot.errors import UsageError
from homebot.mqtt.packets.primitives import Cursor, encode_binary, encode_text, encode_uint16, encode_varint
from homebot.mqtt.packets.properties import (
    NO_PROPERTIES,
    PacketType,
    Properties,
    decode_properties,
    decode_reason,
    encode_properties,
    encode_reason,
)
from homebot.mqtt.packets.reason import FAILURES, PacketError, ProtocolVersion, ReasonCode, by_number


@dataclass(frozen=True, slots=True)
class Will:
    """The message the broker publishes when a client is lost.

    Attributes:
        payload: 0 to 65,535 bytes.
        qos: 0, 1 or 2.
        properties: MQTT 5 only; the delay is in ``will_delay_interval``.
    """

    topic: str
    payload: bytes = b""
    qos: int = 0
    retain: bool = False
    properties: Properties = NO_PROPERTIES


@dataclass(frozen=True, slots=True)
class Connect:
    """A client asks for a session.

    Attributes:
        client_id: May be empty; the broker then chooses one.
        clean_start: Forget a session kept under this id; before MQTT 5 also: keep none afterwards.
        keep_alive: The longest silence of the client, in seconds; 0 is no limit.
        username: None where absent.
        password: None where absent; never in the representation.
        is_bridge: Whether another broker asks, which says so in the highest bit of the protocol level, as Mosquitto and
            others do before MQTT 5; no standard has it.
    """

    client_id: str = ""
    version: ProtocolVersion = ProtocolVersion.V5
    clean_start: bool = True
    keep_alive: int = 60
    username: str | None = None
    password: bytes | None = field(default=None, repr=False)
    will: Will | None = None
    properties: Properties = NO_PROPERTIES
    is_bridge: bool = False


class Connack(NamedTuple):
    """The broker's answer to CONNECT; *reason* is an MQTT 5 code for every version."""

    session_present: bool = False
    reason: ReasonCode = ReasonCode.SUCCESS
    properties: Properties = NO_PROPERTIES


@dataclass(frozen=True, slots=True)
class Pingreq:
    """The client's ping."""


@dataclass(frozen=True, slots=True)
class Pingresp:
    """The broker's answer to a ping."""


class Disconnect(NamedTuple):
    """The last packet of a connection; before MQTT 5 only clients send it, without reason and properties."""

    reason: ReasonCode = ReasonCode.SUCCESS
    properties: Properties = NO_PROPERTIES


class Auth(NamedTuple):
    """A step of an extended authentication; MQTT 5 only."""

    reason: ReasonCode = ReasonCode.SUCCESS
    properties: Properties = NO_PROPERTIES


def _decode_connect(body: bytes, _version: ProtocolVersion) -> Connect:
    cursor = Cursor(body)
    version, is_bridge = _decode_protocol(cursor)
    flags = cursor.uint8()
    will_qos = flags >> 3 & 3
    if flags & 1:
        raise PacketError("CONNECT has its reserved flag set", body)
    if will_qos == 3 or (not flags & _WILL and (will_qos or flags & _WILL_RETAIN)):
        raise PacketError("CONNECT has impossible will flags", body)
    if flags & _PASSWORD and not flags & _USERNAME and version != ProtocolVersion.V5:
        raise PacketError("CONNECT has a password without a user name", body)
    keep_alive = cursor.uint16()
    is_v5 = version is ProtocolVersion.V5
    properties = decode_properties(cursor, PacketType.CONNECT) if is_v5 else NO_PROPERTIES
    client_id = cursor.text()
    will = _decode_will(cursor, flags, is_v5=is_v5) if flags & _WILL else None
    username = cursor.text() if flags & _USERNAME else None
    password = cursor.binary() if flags & _PASSWORD else None
    cursor.finish()
    clean = bool(flags & _CLEAN_START)
    return Connect(client_id, version, clean, keep_alive, username, password, will, properties, is_bridge)


def _encode_connect(packet: Connect, _version: ProtocolVersion) -> bytes:
    is_v5 = packet.version is ProtocolVersion.V5
    if packet.password is not None and packet.username is None and not is_v5:
        raise UsageError("before MQTT 5 a password needs a user name")
    if packet.is_bridge and is_v5:
        raise UsageError("a bridge says that it is one before MQTT 5 alone")
    body = encode_text(_NAMES[packet.version]) + (packet.version | packet.is_bridge * _BRIDGE).to_bytes(1, "big")
    tail = encode_properties(packet.properties, PacketType.CONNECT) if is_v5 else b""
    tail += encode_text(packet.client_id)
    will = packet.will
    if will is not None:
        tail += encode_properties(will.properties, PacketType.WILL) if is_v5 else b""
        tail += encode_text(will.topic) + encode_binary(will.payload)
    if packet.username is not None:
        tail += encode_text(packet.username)
    if packet.password is not None:
        tail += encode_binary(packet.password)
    body += _flags_of(packet).to_bytes(1, "big") + encode_uint16(packet.keep_alive) + tail
    return b"\x10" + encode_varint(len(body)) + body


def _flags_of(packet: Connect) -> int:
    flags = _CLEAN_START if packet.clean_start else 0
    if packet.username is not None:
        flags |= _USERNAME
    if packet.password is not None:
        flags |= _PASSWORD
    if packet.will is not None:
        flags |= _WILL | packet.will.qos << 3 | (_WILL_RETAIN if packet.will.retain else 0)
    return flags


def _decode_connack(body: bytes, version: ProtocolVersion) -> Connack:
    cursor = Cursor(body)
    flags = cursor.uint8()
    if flags & 0xFE:
        raise PacketError("CONNACK has reserved flags", body)
    number = cursor.uint8()
    reason = _FROM_V3.get(number) if version != ProtocolVersion.V5 else _V5_REASONS.get(number)
    if reason is None:
        raise PacketError(f"CONNACK has reason 0x{number:02x}", body, ReasonCode.PROTOCOL_ERROR)
    properties = NO_PROPERTIES
    if version == ProtocolVersion.V5:
        properties = decode_properties(cursor, PacketType.CONNACK)
    cursor.finish()
    return Connack(bool(flags), reason, properties)


def _encode_connack(packet: Connack, version: ProtocolVersion) -> bytes:
    """Encode the whole packet; before MQTT 5 the reason becomes the nearest of that version's five refusals."""
    if version != ProtocolVersion.V5:
        number = _TO_V3.get(packet.reason, _V3_UNAVAILABLE) if packet.reason else 0
        present = packet.session_present and version == ProtocolVersion.V311
        return bytes((0x20, 2, present, number))
    body = bytes((packet.session_present, packet.reason))
    body += encode_properties(packet.properties, PacketType.CONNACK)
    return b"\x20" + encode_varint(len(body)) + body


_CLEAN_START = 0x02
_WILL = 0x04
_WILL_RETAIN = 0x20
_PASSWORD = 0x40
_USERNAME = 0x80
_BRIDGE = 0x80  # of the protocol level

_NAMES = {ProtocolVersion.V31: "MQIsdp", ProtocolVersion.V311: "MQTT", ProtocolVersion.V5: "MQTT"}

_V3_UNAVAILABLE = 3
_FROM_V3 = {
    0: ReasonCode.SUCCESS,
    1: ReasonCode.UNSUPPORTED_PROTOCOL_VERSION,
    2: ReasonCode.CLIENT_IDENTIFIER_NOT_VALID,
    _V3_UNAVAILABLE: ReasonCode.SERVER_UNAVAILABLE,
    4: ReasonCode.BAD_USER_NAME_OR_PASSWORD,
    5: ReasonCode.NOT_AUTHORIZED,
}
_TO_V3 = {code: number for number, code in _FROM_V3.items()} | {
    ReasonCode.BANNED: 5,
    ReasonCode.BAD_AUTHENTICATION_METHOD: 5,
}
_V5_REASONS = by_number(ReasonCode.SUCCESS, *FAILURES)


def _decode_protocol(cursor: Cursor) -> tuple[ProtocolVersion, bool]:
    """Return the version, and whether a bridge asks."""
    name = cursor.binary()
    level = cursor.uint8()
    if name == b"MQTT" and level == ProtocolVersion.V5:
        return ProtocolVersion.V5, False
    version = {b"MQTT": ProtocolVersion.V311, b"MQIsdp": ProtocolVersion.V31}.get(name)
    if version is not None and level & ~_BRIDGE == version:
        return version, bool(level & _BRIDGE)
    raise PacketError(
        f"protocol {name[:16]!r} level {level} is not MQTT 3.1, 3.1.1 or 5",
        cursor.body,
        ReasonCode.UNSUPPORTED_PROTOCOL_VERSION,
    )


def _decode_will(cursor: Cursor, flags: int, *, is_v5: bool) -> Will:
    properties = decode_properties(cursor, PacketType.WILL) if is_v5 else NO_PROPERTIES
    topic = cursor.text()
    if not topic or "+" in topic or "#" in topic:
        raise PacketError("the will's topic is not a topic name", cursor.body, ReasonCode.TOPIC_NAME_INVALID)
    return Will(topic, cursor.binary(), flags >> 3 & 3, bool(flags & _WILL_RETAIN), properties)


def _decode_ping(packet_type: PacketType, body: bytes, _version: ProtocolVersion) -> Pingreq | Pingresp:
    if body:
        raise PacketError(f"{packet_type.name} has a body", body)
    return Pingreq() if packet_type is PacketType.PINGREQ else Pingresp()


def _decode_disconnect(body: bytes, version: ProtocolVersion) -> Disconnect:
    if version != ProtocolVersion.V5 and body:
        raise PacketError("DISCONNECT has a body", body)
    return Disconnect(*decode_reason(body, 0, PacketType.DISCONNECT, _DISCONNECT_REASONS))


def _encode_disconnect(packet: Disconnect, version: ProtocolVersion) -> bytes:
    """Encode the whole packet; before MQTT 5 reason and properties are left out."""
    if version != ProtocolVersion.V5:
        return b"\xe0\x00"
    body = encode_reason(packet.reason, packet.properties, PacketType.DISCONNECT)
    return b"\xe0" + encode_varint(len(body)) + body


def _decode_auth(body: bytes, version: ProtocolVersion) -> Auth:
    if version != ProtocolVersion.V5:
        raise PacketError("AUTH came on a connection older than MQTT 5", body)
    return Auth(*decode_reason(body, 0, PacketType.AUTH, _AUTH_REASONS))


def _encode_auth(packet: Auth, version: ProtocolVersion) -> bytes:
    if version != ProtocolVersion.V5:
        raise UsageError("AUTH needs MQTT 5")
    body = encode_reason(packet.reason, packet.properties, PacketType.AUTH)
    return b"\xf0" + encode_varint(len(body)) + body


_DISCONNECT_REASONS = by_number(ReasonCode.SUCCESS, ReasonCode.DISCONNECT_WITH_WILL, *FAILURES)
_AUTH_REASONS = by_number(ReasonCode.SUCCESS, ReasonCode.CONTINUE_AUTHENTICATION, ReasonCode.REAUTHENTICATE)

DECODERS: dict[
    PacketType, Callable[[bytes, ProtocolVersion], Connect | Connack | Pingreq | Pingresp | Disconnect | Auth]
] = {
    PacketType.CONNECT: _decode_connect,
    PacketType.CONNACK: _decode_connack,
    PacketType.PINGREQ: partial(_decode_ping, PacketType.PINGREQ),
    PacketType.PINGRESP: partial(_decode_ping, PacketType.PINGRESP),
    PacketType.DISCONNECT: _decode_disconnect,
    PacketType.AUTH: _decode_auth,
}
ENCODERS: dict[type, Callable[..., bytes]] = {
    Connect: _encode_connect,
    Connack: _encode_connack,
    Pingreq: lambda _packet, _version: b"\xc0\x00",
    Pingresp: lambda _packet, _version: b"\xd0\x00",
    Disconnect: _encode_disconnect,
    Auth: _encode_auth,
}
