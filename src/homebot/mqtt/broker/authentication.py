"""Who may log in."""

from __future__ import annotations

import hmac
import ipaddress
from collections.abc import Mapping
from typing import final

from homebot.mqtt.packets import ReasonCode

__all__ = ["Authentication", "is_loopback"]


@final
class Authentication:
    """Checks user name and password; never shows them.

    Args:
        credentials: Passwords by user name; None or empty lets everybody in.
    """

    __slots__ = ("_passwords",)

    def __init__(self, credentials: Mapping[str, str] | None = None) -> None:
        self._passwords = {user: password.encode() for user, password in (credentials or {}).items()}

    @property
    def required(self) -> bool:
        """Whether a password is asked for."""
        return bool(self._passwords)

    def check(self, username: str | None, password: bytes | None) -> ReasonCode:
        """Success, 0x87 where nothing was presented, or 0x86; takes as long for an unknown user."""
        if not self._passwords:
            return ReasonCode.SUCCESS
        if username is None:
            return ReasonCode.NOT_AUTHORIZED
        known = self._passwords.get(username)
        right = hmac.compare_digest(b"" if known is None else known, password or b"")
        if right and known is not None:
            return ReasonCode.SUCCESS
        return ReasonCode.BAD_USER_NAME_OR_PASSWORD


def is_loopback(host: str) -> bool:
    """Whether *host* surely means this computer only; a name other than ``localhost`` does not."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
