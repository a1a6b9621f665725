"""Text for the log about clients and what they send. No I/O."""

from __future__ import annotations

__all__ = ["client_text", "host_of", "short"]

_IPV6_PREFIX = 4  # groups of 16 bits; a household has all addresses behind them
_LONGEST = 100  # a client may choose a name or topic of 65,535 bytes


def client_text(client_id: str | None, address: str) -> str:
    """Return ``client 'lamp' (10.0.0.5:50000)``, or the address alone before the login."""
    return address if client_id is None else f"client {short(client_id)!r} ({address})"


def host_of(address: str) -> str:
    """The host of ``HOST:PORT``, as far as one owner has it: of IPv6 the first 64 bits."""
    host = address.rpartition(":")[0].removeprefix("::ffff:")
    return ":".join(_expanded(host)[:_IPV6_PREFIX]) if ":" in host else host


def _expanded(host: str) -> list[str]:
    """The eight groups of an IPv6 address."""
    before, gap, after = host.partition("::")
    head, tail = before.split(":") if before else [], after.split(":") if after else []
    return head + ["0"] * (8 - len(head) - len(tail)) + tail if gap else head


def short(text: str) -> str:
    """Return *text*, cut to 100 characters."""
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
