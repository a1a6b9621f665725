"""Payloads and device names, as several dialects need them."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping

from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.simulated_device import number_text

__all__ = ["as_json", "as_object", "as_text", "cover_order", "hardware_address", "lamp_order", "node_name"]

LONGEST = 10_000
"""Bytes of a command; none of a device is as long."""

STEPS = 4
"""Decimals of a share of 1: finer than any device's own steps."""


def as_json(value: object) -> bytes:
    """Return *value* as compact JSON."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False).encode(errors="replace")


def as_object(payload: bytes) -> Mapping[str, object]:
    """Return the JSON object in *payload*; empty where there is none."""
    if len(payload) > LONGEST:
        return {}
    try:
        value = json.loads(payload)
    except (ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}


def as_text(payload: bytes) -> str:
    """Return the text in *payload* without surrounding blanks; invalid UTF-8 becomes U+FFFD."""
    return payload[:LONGEST].decode(errors="replace").strip()


def lamp_order(
    *, is_on: bool | None = None, brightness: float | None = None, kelvin: float | None = None
) -> tuple[str, ...]:
    """Return the commands to a lamp for one message: the wanted values, None for absent ones.

    Args:
        is_on: Whether it should shine.
        brightness: 0 to 1; above 0 lights it, as lamps of all families do.
        kelvin: Its colour temperature.
    """
    warmth = () if kelvin is None else (f"{number_text(kelvin)} K",)
    if is_on is False:
        return (*warmth, "off")
    if brightness is not None:
        return (*warmth, number_text(brightness, STEPS))
    return (*warmth, *(() if is_on is None else ("on",)))


def cover_order(text: str) -> tuple[str, ...]:
    """Return the command for ``open``, ``close`` or ``stop`` in any case; empty for another text."""
    return (text.lower(),) if text.lower() in {"open", "close", "stop"} else ()


def hardware_address(device: SimulatedDeviceInfo, digits: int = 12) -> str:
    """Return hexadecimal digits that are *device*'s alone, the same in every run, marked as locally given out."""
    digest = hashlib.sha256(f"{device.home}/{device.device_id}".encode(errors="replace")).hexdigest()
    return f"02{digest[: digits - 2]}"


def node_name(device: SimulatedDeviceInfo) -> str:
    """Return a name of letters, digits, ``_`` and ``-`` that no other device of any home has."""
    name = f"{device.home}-{device.device_id}"
    plain = re.sub(r"[^A-Za-z0-9_-]", "-", name)
    return plain if plain == name else f"{plain}-{hardware_address(device)[-6:]}"
