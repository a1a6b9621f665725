"""Authentication of clients."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Mapping
from typing import final

from homebot.mqtt.packets import ReasonCode

__all__ = ["Authentication"]


_NOBODYS = bytes(32)


@final
class Authentication:
    """Checks user name and password; never shows them.

    Args:
        credentials: Passwords by user name; None or empty lets everybody in.
    """

    __slots__ = ("_digests", "_key")

    def __init__(self, credentials: Mapping[str, str] | None = None) -> None:
        self._key = secrets.token_bytes(32)
        self._digests = {user: self._digest(password.encode()) for user, password in (credentials or {}).items()}

    @property
    def required(self) -> bool:
        """True if a password is required."""
        return bool(self._digests)

    def check(self, username: str | None, password: bytes | None) -> ReasonCode:
        """Return success, 0x87 where nothing was presented, or 0x86.

        It takes as long for an unknown user, and for a password of whatever length and beginning.
        """
        if not self._digests:
            return ReasonCode.SUCCESS
        if username is None:
            return ReasonCode.NOT_AUTHORIZED
        known = self._digests.get(username)
        right = hmac.compare_digest(known or _NOBODYS, self._digest(password or b""))
        if right and known is not None:
            return ReasonCode.SUCCESS
        return ReasonCode.BAD_USER_NAME_OR_PASSWORD

    def _digest(self, password: bytes) -> bytes:
        return hmac.digest(self._key, password, "sha256")
