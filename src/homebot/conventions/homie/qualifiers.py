"""Words that turn the meaning of others: a child lock locks no door, a water tank does not leak. Tables, pure.

A guess needs both: words that speak for it and a form that fits. One of these words beside them speaks against it.
"""

from __future__ import annotations

__all__ = ["is_beside", "is_object", "is_setting"]

_BESIDE = frozenset(
    {"alarm", "auto", "automatic", "away", "backlight", "beep", "behavior", "behaviour", "boost", "button", "buzzer"}
    | {"calibration", "child", "comfort", "correction", "day", "default", "delay", "delta", "detection", "difference"}
    | {
        "display",
        "duration",
        "eco",
        "enable",
        "enabled",
        "firmware",
        "frost",
        "holiday",
        "humidity",
        "hysteresis",
        "identify",
    }
    | {
        "indicator",
        "interval",
        "key",
        "keypad",
        "keys",
        "limit",
        "lockout",
        "max",
        "maximum",
        "memory",
        "min",
        "minimum",
    }
    | {
        "mute",
        "night",
        "offset",
        "panel",
        "protection",
        "ramp",
        "rate",
        "reset",
        "restart",
        "runtime",
        "schedule",
        "screen",
    }
    | {
        "sensitivity",
        "sound",
        "speaker",
        "standby",
        "startup",
        "status",
        "threshold",
        "time",
        "timeout",
        "timer",
        "travel",
    }
    | {"tone", "transition", "update", "vibration", "volume", "water"}
)
"""A property of these is a setting, or of something else than its node is there for."""

_SETTINGS = frozenset(
    {
        "backlight",
        "calibration",
        "child",
        "display",
        "firmware",
        "hysteresis",
        "identify",
        "indicator",
        "keypad",
        "keys",
    }
    | {"lockout", "offset", "reset", "schedule", "screen", "sensitivity", "threshold", "update"}
)
"""A node of these is there for setting up."""

_OBJECTS = frozenset(
    {"attached", "bell", "boiler", "box", "button", "connected", "dock", "empty", "enabled", "filter", "full", "grade"}
    | {
        "heater",
        "heating",
        "hot",
        "installed",
        "level",
        "light",
        "lock",
        "locked",
        "low",
        "meter",
        "mode",
        "mop",
        "opener",
    }
    | {"pump", "supply", "tank", "temperature", "usage", "valve", "watertank"}
)
"""Things that can have water, gas or a door without that being a condition of them."""


def is_beside(tokens: frozenset[str]) -> bool:
    """Return whether *tokens* of a property say that it is not what its node is there for."""
    return not tokens.isdisjoint(_BESIDE)


def is_object(tokens: frozenset[str]) -> bool:
    """Return whether *tokens* of a property name a thing, so that a condition among them is only part of its name."""
    return not tokens.isdisjoint(_OBJECTS)


def is_setting(tokens: frozenset[str]) -> bool:
    """Return whether *tokens* of a node say that nothing of it is what its device is there for."""
    return not tokens.isdisjoint(_SETTINGS)
