"""Text for the log about clients and what they send. No I/O."""

from __future__ import annotations

from homebot.addresses import network_of

__all__ = ["client_text", "host_of", "short"]

_LONGEST = 100  # a client may choose a name or topic of 65,535 bytes


def client_text(client_id: str | None, address: str) -> str:
    """Return ``client 'lamp' (10.0.0.5:50000)``, or the address alone before the login."""
    return address if client_id is None else f"client {short(client_id)!r} ({address})"


def host_of(address: str) -> str:
    """Return the host of ``HOST:PORT``, as far as one owner has it."""
    return network_of(address.rpartition(":")[0])


def short(text: str) -> str:
    """Return *text*, cut to 100 characters."""
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
