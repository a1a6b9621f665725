"""MQTT reason codes as errors and words: which no is final for now, and which only means later."""

from __future__ import annotations

from typing import Final

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.packets.reason import ReasonCode

__all__ = ["disconnect_error", "login_error", "reason_text"]

_TRY_LATER: Final = {
    ReasonCode.SERVER_UNAVAILABLE,
    ReasonCode.SERVER_BUSY,
    ReasonCode.QUOTA_EXCEEDED,
    ReasonCode.CONNECTION_RATE_EXCEEDED,
}
_WRONG_LOGIN: Final = {ReasonCode.BAD_USER_NAME_OR_PASSWORD, ReasonCode.NOT_AUTHORIZED}
_THROWN_OUT: Final = {
    ReasonCode.NOT_AUTHORIZED,
    ReasonCode.BANNED,
    ReasonCode.SESSION_TAKEN_OVER,
    ReasonCode.ADMINISTRATIVE_ACTION,
}


def reason_text(code: int) -> str:
    """Return a reason code in words, such as ``not authorized``."""
    try:
        return ReasonCode(code).text
    except ValueError:
        return f"reason 0x{code:02x}"


def login_error(code: int) -> LinkError | RefusedError:
    """Return the error for a CONNACK with *code* (0x80 or more)."""
    if code in _TRY_LATER:
        return LinkError(f"the broker answered: {reason_text(code)}")
    hint = "; check user and password_file" if code in _WRONG_LOGIN else ""
    return RefusedError("the login", f"{reason_text(code)}{hint}", code)


def disconnect_error(code: int) -> LinkError | RefusedError:
    """Return the error for a DISCONNECT with *code* from the broker."""
    if code == ReasonCode.SESSION_TAKEN_OVER:
        return RefusedError("the connection", "session taken over, another client uses this client id", code)
    if code in _THROWN_OUT:
        return RefusedError("the connection", reason_text(code), code)
    return LinkError(f"the broker disconnected: {reason_text(code) if code else 'no reason given'}")
