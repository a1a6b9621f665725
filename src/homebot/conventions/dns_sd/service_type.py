"""Service types of DNS-SD, as text. Pure.

Source: RFC 6763, sections 4.1.2, 7 and 9; RFC 6335, section 5.1 for the characters of a service name.
"""

from __future__ import annotations

import re

__all__ = ["ENUMERATION", "base_type", "full_type", "instance_label", "is_service_type"]

ENUMERATION = "_services._dns-sd._udp.local."
"""The name that every service type on the network is listed under (RFC 6763, section 9)."""

_TYPE = re.compile(r"(?:_[^.]{1,63}\._sub\.)?_[a-z0-9](?:[a-z0-9-]{0,13}[a-z0-9])?\._(?:tcp|udp)\.local\.")


def full_type(text: str) -> str:
    """Return a service type in full: of ``_shelly._tcp`` that is ``_shelly._tcp.local.``, with the dot."""
    name = text.strip().rstrip(".").lower()
    return f"{name}." if name.endswith(".local") else f"{name}.local."


def is_service_type(full: str) -> bool:
    """Return whether *full* is a service type in full, perhaps with a subtype."""
    return full == ENUMERATION or _TYPE.fullmatch(full) is not None


def base_type(full: str) -> str:
    """Return a type without its subtype: ``_directory._sub._wot._tcp.local.`` becomes ``_wot._tcp.local.``."""
    return full.rpartition("._sub.")[2]


def instance_label(name: str, full: str) -> str:
    """Return the name for people in the full name of a service of the type *full*: its first label."""
    base = base_type(full)
    return name[: -len(base) - 1] if name.lower().endswith(f".{base}") else name
