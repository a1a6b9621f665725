"""Signatures of calls over a WebSocket: a Digest in each frame, for one made-up method and address. Pure.

Source: Shelly Gen2+ API, General, Authentication; RFC 7616, section 3.4.1. From firmware 2.0.0 on each call counts
``nc`` up; older ones take every count.
"""

from __future__ import annotations

import hashlib
import secrets

from pydantic import SecretStr

from homebot.conventions.payload import parse_object
from homebot.errors import WireError
from homebot.support.numbers import to_number

__all__ = ["RpcLogin"]

USER = "admin"
ALGORITHM = "SHA-256"

_MOST_COUNT = 10**9
_LONGEST_TEXT = 200


class RpcLogin:
    """Digest login with the device's password."""

    def __init__(self, password: SecretStr) -> None:
        self._password = password
        self._realm = ""
        self._nonce: str | int = ""
        self._count = 0

    @property
    def is_challenged(self) -> bool:
        """True after a challenge, so that calls can be signed."""
        return bool(self._realm)

    def accept_challenge(self, message: str) -> None:
        """Read the challenge in the *message* of an error 401.

        Raises:
            WireError: It is no challenge, or not for SHA-256.
        """
        challenge = parse_object(message)
        realm, nonce, algorithm = (challenge.get(name) for name in ("realm", "nonce", "algorithm"))
        if not (isinstance(realm, str) and 0 < len(realm) <= _LONGEST_TEXT):
            raise WireError("a challenge has no valid realm")
        if isinstance(nonce, bool) or not isinstance(nonce, int | str) or not 0 < len(str(nonce)) <= _LONGEST_TEXT:
            raise WireError("a challenge has no valid nonce")
        if algorithm != ALGORITHM:
            raise WireError(f"the algorithm of a challenge is not {ALGORITHM}")
        count = to_number(challenge.get("nc"))  # a text on a Wall Display
        self._realm, self._nonce = realm, nonce
        self._count = int(count) if count is not None and 0 < count < _MOST_COUNT else 1

    def sign(self) -> dict[str, object]:
        """Return the member ``auth`` of the next call; needs a challenge first."""
        count, client_nonce = self._count, secrets.token_hex(8)
        self._count += 1
        secret = _hash(USER, self._realm, self._password.get_secret_value())
        response = _hash(secret, str(self._nonce), str(count), client_nonce, "auth", _REQUEST)
        return {
            "realm": self._realm,
            "username": USER,
            "nonce": self._nonce,
            "nc": count,
            "cnonce": client_nonce,
            "response": response,
            "algorithm": ALGORITHM,
        }


def _hash(*texts: str) -> str:
    return hashlib.sha256(":".join(texts).encode()).hexdigest()


_REQUEST = _hash("dummy_method", "dummy_uri")
