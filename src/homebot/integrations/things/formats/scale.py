"""Conversion of numbers between things and the vocabulary's units. Pure."""

import math
from dataclasses import replace

from homebot.conventions.light_color import MIRED, nearest_mired_bounds
from homebot.conventions.units import Conversion, celsius_bounds, conversion_of, to_celsius, to_fahrenheit
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.text.states import is_share
from homebot.integrations.things.formats.thing import Affordance, DataSchema
from homebot.integrations.things.formats.vocabulary import UNITS

_SEPARATORS = str.maketrans("", "", " _-")


def unit_of(schema: DataSchema) -> str:
    """Return the unit of a schema in the vocabulary's spelling: ``celsius`` and ``unit:DegreeCelsius`` are ``°C``."""
    bare = schema.unit.rpartition("/")[2].rpartition(":")[2] if ":" in schema.unit else schema.unit
    return UNITS.get(bare.casefold().translate(_SEPARATORS), bare)


_PERCENT = 100.0
_EXACT = 12
_MAX_UNIT_CHARACTERS = 40
_NO_RANGE = 1e15
"""Range from which bounds are those of a number type, not of a device."""


def canonical(capability: str, affordance: Affordance, number: float) -> float | None:
    """Return the thing's *number* in the vocabulary's unit; None if it is meaningless."""
    if "capability" in affordance.extension:  # homebot's own terms are already canonical
        return number
    if (ends := _ends(capability, affordance)) is not None:
        low, high = ends
        return min(max((number - low) / (high - low) * _PERCENT, 0.0), _PERCENT)
    if _is_mired(capability, affordance):
        return float(round(MIRED / number)) if number >= 1 else None
    if _is_fahrenheit(capability, affordance):
        return to_celsius(number)
    return _conversion(capability, affordance).value(number)


def in_told_unit(capability: str, affordance: Affordance, document: object) -> Affordance | None:
    """Return *affordance* with the unit named in *document* beside the value; None if the unit is unsuitable.

    Without one, the affordance is returned unchanged.
    """
    schema = affordance.schema
    unit = document.get(schema.unit_member) if schema.unit_member and isinstance(document, dict) else None
    if unit is None:
        return affordance
    if not isinstance(unit, str) or _known_conversion(capability, unit) is None:
        return None
    return replace(affordance, schema=replace(schema, unit=unit))


def bounds_of(capability: str, affordance: Affordance) -> tuple[float, ...]:
    """Return the smallest and largest allowed number, in the vocabulary's unit; empty unless both are known.

    They apply to values after the thing's own rounding, so that a rounded bound is allowed.
    """
    low, high = affordance.schema.minimum, affordance.schema.maximum
    if low is None or high is None:
        return ()
    is_own = "capability" in affordance.extension
    if not is_own and _is_mired(capability, affordance) and low >= 1:
        return nearest_mired_bounds(low, high)
    ends = [value for end in (low, high) if (value := canonical(capability, affordance, end)) is not None]
    if len(ends) < 2:  # one of them is meaningless
        return ()
    if not is_own and _is_fahrenheit(capability, affordance):
        return celsius_bounds(min(low, high), max(low, high))
    return min(ends), max(ends)


def on_the_wire(capability: str, affordance: Affordance, number: float) -> float:
    """Return *number*, given in the vocabulary's unit, as the thing's; not finite if impossible."""
    if "capability" in affordance.extension:
        return number
    if (ends := _ends(capability, affordance)) is not None:
        low, high = ends
        value = low + number / _PERCENT * (high - low)
    elif _is_mired(capability, affordance):
        value = MIRED / number if number >= 1 else math.nan
    elif _is_fahrenheit(capability, affordance):
        value = to_fahrenheit(number, _EXACT)
    else:
        conversion = _conversion(capability, affordance)
        value = number * conversion.over / conversion.times + conversion.shift
    if not math.isfinite(value):
        return value
    least, most = affordance.schema.minimum, affordance.schema.maximum
    if affordance.schema.type != "integer":
        return _within(round(value, 6), least, most)
    least, most = None if least is None else math.ceil(least), None if most is None else math.floor(most)
    return _within(float(round(value)), least, most)


def _within(number: float, low: float | None, high: float | None) -> float:
    """Clamp *number*, which may exceed the bounds by rounding."""
    number = number if low is None else max(number, float(low))
    return number if high is None else min(number, float(high))


def _ends(capability: str, affordance: Affordance) -> tuple[float, float] | None:
    low, high = affordance.schema.minimum, affordance.schema.maximum
    if low is None or high is None or not 0 < high - low < _NO_RANGE:
        return None
    is_fraction = is_share(capability) or (high == 1 and CAPABILITIES[capability].bounds == (0.0, _PERCENT))
    return (low, high) if is_fraction else None


def _is_mired(capability: str, affordance: Affordance) -> bool:
    return capability == "color_temperature" and unit_of(affordance.schema) == "mired"


def _is_fahrenheit(capability: str, affordance: Affordance) -> bool:
    return CAPABILITIES[capability].unit == "°C" and unit_of(affordance.schema) == "°F"


def _conversion(capability: str, affordance: Affordance) -> Conversion:
    unit = unit_of(affordance.schema)
    return (_known_conversion(capability, unit) if unit else None) or Conversion()


def _known_conversion(capability: str, unit: str) -> Conversion | None:
    measured = "temperature" if CAPABILITIES[capability].unit == "°C" else capability
    return conversion_of(measured, unit[:_MAX_UNIT_CHARACTERS])
