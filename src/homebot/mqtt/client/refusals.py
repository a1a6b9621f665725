"""MQTT reason codes as errors and words: which no is final for now, and which only means later."""

from __future__ import annotations

from typing import Final

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client.port import SessionGrant
from homebot.mqtt.packets.reason import ReasonCode

__all__ = ["check_granted", "disconnect_error", "login_error", "reason_text"]

_TRY_LATER: Final = {
    ReasonCode.SERVER_UNAVAILABLE,
    ReasonCode.SERVER_BUSY,
    ReasonCode.QUOTA_EXCEEDED,
    ReasonCode.CONNECTION_RATE_EXCEEDED,
}
_THROWN_OUT: Final = {
    ReasonCode.NOT_AUTHORIZED,
    ReasonCode.BANNED,
    ReasonCode.SESSION_TAKEN_OVER,
    ReasonCode.ADMINISTRATIVE_ACTION,
}

_OVERHEAD = 12
"""Bytes of a PUBLISH besides topic, properties and payload, at most."""


def reason_text(code: int) -> str:
    """A reason code in words, such as ``not authorized``."""
    try:
        return ReasonCode(code).words
    except ValueError:
        return f"reason 0x{code:02x}"


def login_error(code: int) -> LinkError | RefusedError:
    """Return the error for a CONNACK with *code* (0x80 or more)."""
    if code in _TRY_LATER:
        return LinkError(f"the broker answered: {reason_text(code)}")
    return RefusedError("the login", reason_text(code), code)


def disconnect_error(code: int) -> LinkError | RefusedError:
    """Return the error for a DISCONNECT with *code* from the broker."""
    if code == ReasonCode.SESSION_TAKEN_OVER:
        return RefusedError("the connection", "session taken over, another client uses this client id", code)
    if code in _THROWN_OUT:
        return RefusedError("the connection", reason_text(code), code)
    return LinkError(f"the broker disconnected: {reason_text(code) if code else 'no reason given'}")


def check_granted(session: SessionGrant, topic: str, size: int, qos: int, *, retain: bool) -> None:
    """Refuse a publish that the broker would answer by closing the link.

    Args:
        session: What the broker granted.
        topic: Where to.
        size: Bytes of payload and properties.
        qos: 0, 1 or 2.
        retain: Whether the broker is to store it.

    Raises:
        RefusedError: The broker does not take such messages.
    """
    limit = session.maximum_packet_size
    if qos > session.maximum_qos:
        code = ReasonCode.QOS_NOT_SUPPORTED
    elif retain and not session.retain_available:
        code = ReasonCode.RETAIN_NOT_SUPPORTED
    elif limit is not None and len(topic.encode()) + size + _OVERHEAD > limit:
        code = ReasonCode.PACKET_TOO_LARGE
    else:
        return
    raise RefusedError(f"the publish to {topic!r}", reason_text(code), code)
