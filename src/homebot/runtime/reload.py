"""Comparison of a changed configuration with that of a running homebot: the tables that wait for a restart."""

from __future__ import annotations

from collections.abc import Iterator

from homebot.config import Config

__all__ = ["tables_for_restart"]

_TOKENS = frozenset({"token", "token_file", "tokens", "scope"})
"""The keys of ``[door]`` that take effect without a restart."""


def tables_for_restart(before: Config, after: Config) -> tuple[str, ...]:
    """Return the tables that differ and take effect at the next start."""
    return tuple(_changed(before, after))


def _changed(before: Config, after: Config) -> Iterator[str]:
    for name in ("home", "discovery", "control", "places", "ros", "thing_directory"):
        if getattr(before, name) != getattr(after, name):
            yield name
    if any(before.door.get(key) != after.door.get(key) for key in (before.door.keys() | after.door.keys()) - _TOKENS):
        yield "door"
    for section in ("gateways", "apps", "robots"):
        old, new = getattr(before, section), getattr(after, section)
        yield from (f"{section}.{name}" for name in sorted(old.keys() | new.keys()) if old.get(name) != new.get(name))
