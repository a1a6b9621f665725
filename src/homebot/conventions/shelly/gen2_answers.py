"""Answers and notifications of Shelly's second generation, beside the state of components. Pure.

Source: Shelly Gen2+ API, Shelly.GetDeviceInfo, Shelly.GetConfig, Shelly.GetStatus, Notifications.
"""

from __future__ import annotations

import re

from homebot.conventions.payload import clean_text
from homebot.conventions.shelly.gen2_component import Fields
from homebot.numbers import to_number

__all__ = ["fields_in", "is_config_change", "is_prefix", "kind_of", "mac_in", "sleeps", "text_of"]

_OWN_ID = re.compile(r"shelly[a-z0-9]{0,40}-([0-9a-f]{12})", re.IGNORECASE)
_LONGEST_PREFIX = 200
_MOST_EVENTS = 32
_CHANGES = frozenset({"component_added", "component_removed", "config_changed"})


def is_prefix(prefix: str) -> bool:
    """Return whether topics may begin with *prefix*."""
    return 0 < len(prefix) <= _LONGEST_PREFIX and prefix.isprintable() and not set(prefix) & set("+#$")


def kind_of(result: Fields) -> str:
    """Return the question that *result* answers; empty for another, such as a command."""
    if "mac" in result and "id" in result:
        return "info"
    system = fields_in(result, "sys")
    if "device" in system:
        return "config"
    is_status = "mac" in system or "uptime" in system or any(":" in key for key in result)
    return "status" if is_status else ""


def mac_in(prefix: str) -> str:
    """Return the hardware address in a *prefix* that is the device's own id, as it is by default; empty for another."""
    match = _OWN_ID.fullmatch(prefix)
    return match[1].upper() if match else ""


def is_config_change(params: Fields) -> bool:
    """Return whether the *params* of an event say that the device is set up anew."""
    events = params.get("events")
    listed = events[:_MOST_EVENTS] if isinstance(events, list) else ()
    return any(isinstance(one, dict) and one.get("event") in _CHANGES for one in listed if _is_named(one))


def sleeps(status: Fields) -> bool:
    """Return whether a device is off the network most of the time, so that silence says nothing."""
    period = to_number(fields_in(status, "sys").get("wakeup_period"))
    external = fields_in(fields_in(status, "devicepower:0"), "external")
    runs_on_battery = "devicepower:0" in status and external.get("present") is not True
    return runs_on_battery or (period is not None and period > 0)


def fields_in(fields: Fields, name: str) -> Fields:
    """Return the object *name*; empty where there is none."""
    inner = fields.get(name)
    return inner if isinstance(inner, dict) else {}


def text_of(value: object) -> str:
    """Return *value* fit to be shown; empty where it is no text."""
    return clean_text(value) if isinstance(value, str) else ""


def _is_named(event: object) -> bool:
    return isinstance(event, dict) and isinstance(event.get("event"), str)
