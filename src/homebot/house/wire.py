"""Payloads and device names, as several dialects need them."""

import hashlib
import json
import re
from collections.abc import Mapping

from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.simulated_device import number_text
from homebot.support.numbers import to_number

MAX_PAYLOAD_BYTES = 10_000
"""Bytes of a command; none of a device is as long."""

STEPS = 4
"""Decimals of a share of 1: finer than any device's own steps."""

_MIRED = 1e6
_MOVES = frozenset({"open", "close", "stop"})
_ACTIONS = {"window": _MOVES, "cover": _MOVES, "lock": frozenset({"lock", "unlock"})}


def as_json(value: object) -> bytes:
    """Return *value* as compact JSON."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False).encode(errors="replace")


def json_value(payload: bytes) -> object:
    """Return the JSON value of *payload*; None if it is invalid or too long."""
    if len(payload) > MAX_PAYLOAD_BYTES:
        return None
    try:
        value: object = json.loads(payload)
    except (ValueError, RecursionError):
        return None
    return value


def as_object(payload: bytes) -> Mapping[str, object]:
    """Return the JSON object in *payload*; empty for none."""
    value = json_value(payload)
    return value if isinstance(value, dict) else {}


def as_text(payload: bytes) -> str:
    """Return the text in *payload* without surrounding blanks; invalid UTF-8 becomes U+FFFD."""
    return payload[:MAX_PAYLOAD_BYTES].decode(errors="replace").strip()


def scaled(value: object, full: float) -> float | None:
    """Return the share of *full* that the number *value* is; None for another value."""
    number = to_number(value)
    return None if number is None else number / full


def mired_kelvin(value: object) -> float | None:
    """Return the kelvin of a colour temperature in mired; None for another value."""
    number = to_number(value)
    return _MIRED / number if number else None


def lamp_order(
    *, is_on: bool | None = None, brightness: float | None = None, kelvin: float | None = None
) -> tuple[str, ...]:
    """Return the commands to a lamp for one message; None for absent values.

    Args:
        brightness: 0 to 1; above 0 lights it, as lamps of all families do.
    """
    warmth = () if kelvin is None else (f"{number_text(kelvin)} K",)
    if is_on is False:
        return (*warmth, "off")
    if brightness is not None:
        return (*warmth, number_text(brightness, STEPS))
    return (*warmth, *(() if is_on is None else ("on",)))


def device_orders(
    kind: str,
    *,
    is_on: bool | None = None,
    brightness: float | None = None,
    kelvin: float | None = None,
    position: float | None = None,
    action: str = "",
    target: float | None = None,
) -> tuple[str, ...]:
    """Return the commands to a device of *kind* for the values in one message; values of other kinds are ignored.

    Args:
        is_on: See :func:`lamp_order`, also for the next two.
        position: Of a motor, from 0 to 1.
        action: ``open``, ``close`` or ``stop`` of a motor, ``lock`` or ``unlock`` of a lock, in any case.
        target: Of a thermostat, in °C.
    """
    if kind == "lamp":
        return lamp_order(is_on=is_on, brightness=brightness, kelvin=kelvin)
    number = {"window": position, "cover": position, "thermostat": target}.get(kind)
    if number is not None:
        return (number_text(number),)
    return (action.lower(),) if action.lower() in _ACTIONS.get(kind, ()) else ()


def hardware_address(device: SimulatedDeviceInfo, digits: int = 12) -> str:
    """Return hexadecimal digits that are *device*'s alone, the same in every run, marked as locally given out."""
    digest = hashlib.sha256(f"{device.home}/{device.device_id}".encode(errors="replace")).hexdigest()
    return f"02{digest[: digits - 2]}"


def node_name(device: SimulatedDeviceInfo) -> str:
    """Return a name of letters, digits, ``_`` and ``-`` that no other device of any home has."""
    name = f"{device.home}-{device.device_id}"
    plain = re.sub(r"[^A-Za-z0-9_-]", "-", name)
    return plain if plain == name else f"{plain}-{hardware_address(device)[-6:]}"
