"""DISCONNECT, AUTH and the two pings. Source: MQTT 5.0, sections 3.12 to 3.15."""

from __future__ import annotations

from dataclasses import dataclass

from homebot.errors import UsageError
from homebot.mqtt.packets.primitives import Cursor, encode_varint
from homebot.mqtt.packets.properties import (
    NO_PROPERTIES,
    PacketType,
    Properties,
    decode_properties,
    encode_properties,
)
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion, ReasonCode

__all__ = [
    "Auth",
    "Disconnect",
    "Pingreq",
    "Pingresp",
    "decode_auth",
    "decode_disconnect",
    "encode_auth",
    "encode_disconnect",
]


@dataclass(frozen=True, slots=True)
class Pingreq:
    """A client says that it lives."""


@dataclass(frozen=True, slots=True)
class Pingresp:
    """The broker says so too."""


@dataclass(frozen=True, slots=True)
class Disconnect:
    """The last packet of a connection; before MQTT 5 only clients send it, without reason and properties."""

    reason: ReasonCode = ReasonCode.SUCCESS
    properties: Properties = NO_PROPERTIES


@dataclass(frozen=True, slots=True)
class Auth:
    """A step of an extended authentication; MQTT 5 only."""

    reason: ReasonCode = ReasonCode.SUCCESS
    properties: Properties = NO_PROPERTIES


def decode_disconnect(body: bytes, version: ProtocolVersion) -> Disconnect:
    """Decode the body of a DISCONNECT.

    Raises:
        PacketError: 0x81 malformed, 0x82 an unknown reason.
    """
    if version != ProtocolVersion.V5 and body:
        raise PacketError("DISCONNECT has a body", body)
    return Disconnect(*_decode(body, PacketType.DISCONNECT, _DISCONNECT_REASONS))


def encode_disconnect(packet: Disconnect, version: ProtocolVersion) -> bytes:
    """The whole packet; before MQTT 5 reason and properties are left out."""
    if version != ProtocolVersion.V5:
        return b"\xe0\x00"
    return _encode(b"\xe0", packet.reason, packet.properties, PacketType.DISCONNECT)


def decode_auth(body: bytes, version: ProtocolVersion) -> Auth:
    """Decode the body of an AUTH.

    Raises:
        PacketError: 0x81 malformed, or before MQTT 5; 0x82 an unknown reason.
    """
    if version != ProtocolVersion.V5:
        raise PacketError("AUTH came on a connection older than MQTT 5", body)
    return Auth(*_decode(body, PacketType.AUTH, _AUTH_REASONS))


def encode_auth(packet: Auth, version: ProtocolVersion) -> bytes:
    """The whole packet.

    Raises:
        UsageError: The connection is older than MQTT 5.
    """
    if version != ProtocolVersion.V5:
        raise UsageError("AUTH needs MQTT 5")
    return _encode(b"\xf0", packet.reason, packet.properties, PacketType.AUTH)


_DISCONNECT_REASONS = {
    int(code): code
    for code in ReasonCode
    if code in (ReasonCode.SUCCESS, ReasonCode.DISCONNECT_WITH_WILL) or code.failed
}
_AUTH_REASONS = {
    int(code): code for code in (ReasonCode.SUCCESS, ReasonCode.CONTINUE_AUTHENTICATION, ReasonCode.REAUTHENTICATE)
}


def _decode(body: bytes, packet: PacketType, known: dict[int, ReasonCode]) -> tuple[ReasonCode, Properties]:
    if not body:
        return ReasonCode.SUCCESS, NO_PROPERTIES
    reason = known.get(body[0])
    if reason is None:
        raise PacketError(f"{packet.name} has reason 0x{body[0]:02x}", body, ReasonCode.PROTOCOL_ERROR)
    if len(body) == 1:
        return reason, NO_PROPERTIES
    cursor = Cursor(body)
    cursor.position = 1
    properties = decode_properties(cursor, packet)
    cursor.finish()
    return reason, properties


def _encode(first: bytes, reason: ReasonCode, properties: Properties, packet: PacketType) -> bytes:
    if properties is NO_PROPERTIES:
        return first + (b"\x00" if reason is ReasonCode.SUCCESS else bytes((1, reason)))
    body = reason.to_bytes(1, "big") + encode_properties(properties, packet)
    return first + encode_varint(len(body)) + body
