"""One door to the codec: any packet to bytes and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from homebot.mqtt.packets import connect, publish, subscribe
from homebot.mqtt.packets.connect import Auth, Connack, Connect, Disconnect, Pingreq, Pingresp
from homebot.mqtt.packets.properties import PacketType
from homebot.mqtt.packets.publish import Acknowledgement, Publish, decode_publish
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion
from homebot.mqtt.packets.subscribe import Suback, Subscribe, Unsuback, Unsubscribe

__all__ = ["Packet", "decode", "encode"]

Packet: TypeAlias = (
    Connect
    | Connack
    | Publish
    | Acknowledgement
    | Subscribe
    | Suback
    | Unsubscribe
    | Unsuback
    | Pingreq
    | Pingresp
    | Disconnect
    | Auth
)


def decode(first: int, body: bytes, version: ProtocolVersion) -> Packet:
    """Decode one packet.

    Args:
        first: The first byte: type and flags.
        version: Protocol version of the connection; a CONNECT brings its own.

    Raises:
        PacketError: 0x81 the packet is malformed, 0x82 it has something forbidden, 0x84 it asks for another protocol,
            0x8F a filter breaks the rules for filters, 0x90 a topic is no topic name, 0x94 a topic alias is 0, 0x97
            there is too much of something.
    """
    number = first >> 4
    if number == PacketType.PUBLISH:
        return decode_publish(first & 0x0F, body, 0, len(body), version)
    if number == 0 or not _may_have(first & 0x0F, number, version):
        raise PacketError(f"0x{first:02x} does not start a packet", body)
    return _DECODERS[PacketType(number)](body, version)


def encode(packet: Packet, version: ProtocolVersion = ProtocolVersion.V5) -> bytes:
    """Encode one packet; a CONNECT ignores *version* and takes its own.

    Raises:
        UsageError: A value does not fit its field, or this version has no such packet or property.
    """
    return _ENCODERS[type(packet)](packet, version)


def _may_have(flags: int, number: int, version: ProtocolVersion) -> bool:
    """Return whether a packet may have *flags*; 3.1, section 2.1, has DUP in more packets, later ones fix all bits."""
    if version == ProtocolVersion.V31:
        return number not in _FLAGS_2 or flags & 0b0110 == 0b0010
    return flags == (0b0010 if number in _FLAGS_2 else 0)


_FLAGS_2 = (PacketType.PUBREL, PacketType.SUBSCRIBE, PacketType.UNSUBSCRIBE)
_DECODERS: dict[PacketType, Callable[[bytes, ProtocolVersion], Packet]] = {
    **connect.DECODERS,
    **publish.DECODERS,
    **subscribe.DECODERS,
}
_ENCODERS: dict[type, Callable[..., bytes]] = connect.ENCODERS | publish.ENCODERS | subscribe.ENCODERS
