"""Quantities of numbers, by their unit and by the words around them. Tables, pure.

Source: Homie convention 5, Units; Homie 4.0, Property Attributes.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from homebot.conventions.homie.qualifiers import is_object

__all__ = ["CONDITIONS", "condition_of", "quantity_of"]

_BY_UNIT: Mapping[str, str] = MappingProxyType(
    {
        "°C": "temperature",
        "°F": "temperature",
        "C": "temperature",
        "F": "temperature",
        "W": "power",
        "kW": "power",
        "mW": "power",
        "kWh": "energy",
        "Wh": "energy",
        "MWh": "energy",
        "V": "voltage",
        "mV": "voltage",
        "A": "current",
        "mA": "current",
        "kA": "current",
        "Hz": "frequency",
        "lx": "illuminance",
        "hPa": "pressure",
        "mbar": "pressure",
        "Pa": "pressure",
        "kPa": "pressure",
        "bar": "pressure",
        "psi": "pressure",
        "dBm": "signal_strength",
        "m³/h": "flow",
        "L/h": "flow",
        "L/min": "flow",
    }
)

_BY_TOKEN: tuple[tuple[str, str, frozenset[str]], ...] = (
    ("battery", "battery", frozenset({"", "%"})),
    ("humidity", "humidity", frozenset({"", "%"})),
    ("moisture", "soil_moisture", frozenset({"%"})),
    ("temperature", "temperature", frozenset({""})),
    ("illuminance", "illuminance", frozenset({""})),
    ("lux", "illuminance", frozenset({""})),
    ("pressure", "pressure", frozenset({""})),
    ("co2", "carbon_dioxide", frozenset({"", "ppm"})),
    ("dioxide", "carbon_dioxide", frozenset({"", "ppm"})),
    ("monoxide", "carbon_monoxide", frozenset({"", "ppm"})),
    ("co", "carbon_monoxide", frozenset({"ppm"})),
    ("pm25", "pm25", frozenset({"", "µg/m³"})),
    ("pm10", "pm10", frozenset({"", "µg/m³"})),
    ("voc", "volatile_organic_compounds", frozenset({"µg/m³"})),
    ("rssi", "signal_strength", frozenset({""})),
)

_NO_MEASURE = frozenset({"color", "colour", "count", "cycles", "health", "time"})
"""Beside these a number is not what another word names: the temperature of a colour, the cycles of a battery."""

_SHORT = 4
"""A longer word also counts where another begins with it, as ``battery`` in ``batterystate``."""

CONDITIONS: Mapping[str, str] = MappingProxyType(
    {
        "motion": "occupancy",
        "occupancy": "occupancy",
        "presence": "occupancy",
        "contact": "contact",
        "door": "contact",
        "window": "contact",
        "open": "contact",
        "water": "water_leak",
        "leak": "water_leak",
        "flood": "water_leak",
        "smoke": "smoke",
        "co": "carbon_monoxide_alarm",
        "gas": "gas",
        "vibration": "vibration",
        "tamper": "tamper",
        "sabotage": "tamper",
        "rain": "rain",
    }
)
"""Capabilities of boolean properties, by a token of their name."""


def quantity_of(unit: str, tokens: frozenset[str]) -> tuple[str, bool]:
    """Return the capability of a number with *unit* near *tokens*, and whether that is a guess."""
    unit = unit.strip()
    if unit in _BY_UNIT:
        return _BY_UNIT[unit], False
    if not tokens.isdisjoint(_NO_MEASURE):
        return "measurement", False
    for token, capability, units in _BY_TOKEN:
        if unit in units and any(one.startswith(token) if len(token) > _SHORT else one == token for one in tokens):
            return capability, True
    return "measurement", False


def condition_of(tokens: frozenset[str], around: frozenset[str]) -> str:
    """Return the capability of a truth; ``state`` where nothing tells.

    Args:
        tokens: Of the property. One of a thing, such as a water tank, is no condition.
        around: Of its node; they count where the property's own say nothing.
    """
    if is_object(tokens):
        return "state"
    counted = tokens if tokens & CONDITIONS.keys() or not tokens <= _NEUTRAL else around
    if counted is around and is_object(around):
        return "state"
    return next((capability for token, capability in CONDITIONS.items() if token in counted), "state")


_NEUTRAL = frozenset(
    {"active", "alarm", "alert", "detected", "detection", "detector", "sensor", "state", "status", "triggered", "value"}
)
"""Words that say of a truth nothing but that it is one."""
