"""The last packet of a connection that the broker ends. No I/O."""

from __future__ import annotations

from homebot.mqtt.packets import (
    Connack,
    Disconnect,
    PacketError,
    Properties,
    ProtocolVersion,
    ReasonCode,
    encode,
)

__all__ = ["goodbye", "unread_connect_answer"]

_MAX_REASON = 200  # a client gets the gist, not its own 64 KiB topic back


def goodbye(reason: ReasonCode, reason_string: str, max_packet_size: int) -> bytes:
    """The DISCONNECT for an MQTT 5 client.

    Args:
        reason: Why.
        reason_string: The same for people, cut to 200 characters; left out where it is empty or does not fit.
        max_packet_size: The largest packet the client takes.
    """
    plain = encode(Disconnect(reason))
    if not reason_string:
        return plain
    full = encode(Disconnect(reason, Properties(reason_string=reason_string[:_MAX_REASON])))
    return full if len(full) <= max_packet_size else plain


def unread_connect_answer(error: PacketError) -> bytes:
    """The CONNACK for a CONNECT that could not be read, in the version it seems to have; nothing where unknown."""
    if error.code is ReasonCode.UNSUPPORTED_PROTOCOL_VERSION:
        newer = error.frame[:6] == b"\0\4MQTT" and error.frame[6:7] > b"\5"
        return encode(Connack(reason=error.code), ProtocolVersion.V5 if newer else ProtocolVersion.V311)
    if b"\0\4MQTT\5" in error.frame[:16]:
        return encode(Connack(reason=error.code), ProtocolVersion.V5)
    return b""
