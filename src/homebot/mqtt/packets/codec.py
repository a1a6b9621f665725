"""One door to the codec: any packet to bytes and back."""

from __future__ import annotations

from collections.abc import Callable

from homebot.mqtt.packets.connect import (
    Auth,
    Connack,
    Connect,
    Disconnect,
    Pingreq,
    Pingresp,
    decode_auth,
    decode_connack,
    decode_connect,
    decode_disconnect,
    encode_auth,
    encode_connack,
    encode_connect,
    encode_disconnect,
)
from homebot.mqtt.packets.properties import PacketType
from homebot.mqtt.packets.publish import (
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    decode_acknowledgement,
    decode_publish,
    encode_acknowledgement,
    encode_publish,
)
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion
from homebot.mqtt.packets.subscribe import (
    Suback,
    Subscribe,
    Unsuback,
    Unsubscribe,
    decode_suback,
    decode_subscribe,
    decode_unsuback,
    decode_unsubscribe,
    encode_suback,
    encode_subscribe,
    encode_unsuback,
    encode_unsubscribe,
)

__all__ = ["Packet", "decode", "encode"]

Packet = (
    Connect
    | Connack
    | Publish
    | Puback
    | Pubrec
    | Pubrel
    | Pubcomp
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
        PacketError: The packet is malformed or not allowed; its ``code`` says which.
    """
    number = first >> 4
    if number == PacketType.PUBLISH:
        return decode_publish(first & 0x0F, body, 0, len(body), version)
    if number == 0 or not _may_have(first & 0x0F, number, version):
        raise PacketError(f"0x{first:02x} does not start a packet", body)
    packet_type = PacketType(number)
    if packet_type in _ACKNOWLEDGEMENTS:
        return decode_acknowledgement(packet_type, body, version)
    match packet_type:
        case PacketType.CONNECT:
            return decode_connect(body)
        case PacketType.PINGREQ | PacketType.PINGRESP:
            if body:
                raise PacketError(f"{packet_type.name} has a body", body)
            return Pingreq() if packet_type is PacketType.PINGREQ else Pingresp()
        case _:
            return _DECODERS[packet_type](body, version)


def encode(packet: Packet, version: ProtocolVersion = ProtocolVersion.V5) -> bytes:
    """Encode one packet; a CONNECT ignores *version* and takes its own.

    Raises:
        UsageError: A value does not fit its field, or this version has no such packet or property.
    """
    if isinstance(packet, Publish):
        return encode_publish(packet, version)
    if isinstance(packet, Puback | Pubrec | Pubrel | Pubcomp):
        return encode_acknowledgement(packet, version)
    if isinstance(packet, Connect):
        return encode_connect(packet)
    encoder = _ENCODERS[type(packet)]
    return encoder(packet, version)


def _may_have(flags: int, number: int, version: ProtocolVersion) -> bool:
    """Return whether a packet may have *flags*; 3.1, section 2.1, has DUP in more packets, later ones fix all bits."""
    if version == ProtocolVersion.V31:
        return number not in _FLAGS_2 or flags & 0b0110 == 0b0010
    return flags == (0b0010 if number in _FLAGS_2 else 0)


def _encode_ping(packet: Pingreq | Pingresp, _version: ProtocolVersion) -> bytes:
    return b"\xc0\x00" if isinstance(packet, Pingreq) else b"\xd0\x00"


_FLAGS_2 = (PacketType.PUBREL, PacketType.SUBSCRIBE, PacketType.UNSUBSCRIBE)
_ACKNOWLEDGEMENTS = (PacketType.PUBACK, PacketType.PUBREC, PacketType.PUBREL, PacketType.PUBCOMP)
_DECODERS: dict[PacketType, Callable[[bytes, ProtocolVersion], Packet]] = {
    PacketType.CONNACK: decode_connack,
    PacketType.SUBSCRIBE: decode_subscribe,
    PacketType.SUBACK: decode_suback,
    PacketType.UNSUBSCRIBE: decode_unsubscribe,
    PacketType.UNSUBACK: decode_unsuback,
    PacketType.DISCONNECT: decode_disconnect,
    PacketType.AUTH: decode_auth,
}
_ENCODERS: dict[type, Callable[..., bytes]] = {
    Connack: encode_connack,
    Subscribe: encode_subscribe,
    Suback: encode_suback,
    Unsubscribe: encode_unsubscribe,
    Unsuback: encode_unsuback,
    Pingreq: _encode_ping,
    Pingresp: _encode_ping,
    Disconnect: encode_disconnect,
    Auth: encode_auth,
}
