"""The owner's token: a file in the folder of homebot's data, made at the first run, that only its user can read.

The command line of that user sends no token but a proof of it, as another program could listen in homebot's place.
"""

import hmac
import secrets
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from homebot.errors import UsageError
from homebot.support.file_access import read_secret, replace_file, why_not_trusted

OWNER_FILE: Final = "owner.token"

OWNER_HEADER: Final = "Homebot-Owner"
"""Header of a WebSocket handshake with the proof."""

_VALID: Final = 60.0
"""Seconds for which a proof is valid at least."""


@dataclass(frozen=True, slots=True)
class OwnerToken:
    """The owner's token, with its file."""

    file: Path
    secret: str = field(repr=False)


def make_owner_token(file: Path) -> OwnerToken:
    """Return the token in *file*, which is made if there is none. Blocking.

    Raises:
        UsageError: It cannot be written or read, or others could change it; the message has the remedy.
    """
    try:
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            replace_file(file, f"{secrets.token_urlsafe(32)}\n".encode())
    except OSError as exc:
        raise UsageError(f"{file} cannot be written: {exc.strerror}; name another folder in HOMEBOT_DATA") from exc
    if problem := why_not_trusted(file):
        raise UsageError(problem)
    return OwnerToken(file, read_secret(file))


def owner_proof(token: str, key: str, port: int, now: float) -> str:
    """Return the proof of *token* for one handshake: of its ``Sec-WebSocket-Key``, with the door at *port*, and now."""
    return next(_proofs(token, key, port, now))


def is_owner_proof(proof: str, token: str, key: str, port: int, now: float) -> bool:
    """Return whether *proof* is that of *token*, given within the last minute."""
    return any(hmac.compare_digest(proof.encode(), valid.encode()) for valid in _proofs(token, key, port, now))


def _proofs(token: str, key: str, port: int, now: float) -> Iterator[str]:
    for minute in (now // _VALID, now // _VALID - 1):
        yield hmac.digest(token.encode(), f"{key} {port} {minute:.0f}".encode(), "sha256").hex()
