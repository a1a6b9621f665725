"""Measured quantities, and conversions to the vocabulary's units. Pure.

Source of the conversions: Home Assistant core 2026.11, ``util/unit_conversion.py``.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from homebot.devices.capabilities import CAPABILITIES
from homebot.support.numbers import to_number


class Conversion(NamedTuple):
    """A conversion of a number to another unit: minus *shift*, then by *times* and *over*."""

    shift: float = 0.0
    times: float = 1.0
    over: float = 1.0

    def value(self, number: float) -> float:
        """Return *number* in the other unit."""
        return (number - self.shift) * self.times / self.over


_SAME = Conversion()


@dataclass(frozen=True, slots=True)
class Quantity:
    """The quantity of a number.

    Attributes:
        service_type: The type of a part that measures only this.
        unit: The unit of reported values: the vocabulary's, empty, or the device's own if it cannot be converted.
        conversion: Converts a device's numbers.
    """

    service_type: str
    capability: str
    unit: str = ""
    conversion: Conversion = _SAME

    def value(self, number: float) -> float:
        """Return a device's *number* in :attr:`unit`."""
        return self.conversion.value(number)


def quantity(capability: str, unit: str = "") -> Quantity:
    """Return the quantity of a *capability* with numbers in *unit*, by default the vocabulary's."""
    conversion = conversion_of(capability, unit) if unit else _SAME
    return Quantity(sensor_type(capability), capability, "", conversion or _SAME)


@lru_cache(maxsize=512)  # a house has the same few
def conversion_of(capability: str, unit: str) -> Conversion | None:
    """Return the conversion of numbers in *unit* to those of *capability*; None if it is unknown.

    The unit is in the spelling of a device; its case does not matter if that is unambiguous, as in ``KWh``.
    """
    spelled = (
        unit.strip().replace("° ", "°").replace("\u03bc", "\u00b5").replace("\u2103", "°C").replace("\u2109", "°F")
    )
    spelled = spelled.replace("\u00ba", "°")  # the ordinal indicator, which looks like it
    known = {**_UNITS.get(capability.removesuffix("_returned"), {}), CAPABILITIES[capability].unit: _SAME}
    if spelled in known:
        return known[spelled]
    alike = {conversion for name, conversion in known.items() if name.casefold() == spelled.casefold()}
    return alike.pop() if len(alike) == 1 else None


def measured_in(unit: str) -> str:
    """Return the only capability of numbers in *unit*; empty for none, or for several, such as ``%`` and ``K``.

    ``mmHg`` may be of the air or of blood, as Withings reports it.
    """
    if unit in {"", "K", "mmHg"}:
        return ""
    return next((capability for capability in _BY_UNIT if conversion_of(capability, unit) is not None), "")


_BY_UNIT = ("temperature", "illuminance", "pressure", "power", "energy", "voltage", "current", "frequency", "flow")
"""Capabilities of which each has units of its own."""


def to_celsius(fahrenheit: float, digits: int = 6) -> float:
    """Return °F in °C, rounded to *digits*."""
    return round((fahrenheit - 32.0) / 1.8, digits)


def to_fahrenheit(celsius: float, digits: int = 6) -> float:
    """Return °C in °F, rounded to *digits*."""
    return round(celsius * 1.8 + 32.0, digits)


def celsius_bounds(low: float, high: float) -> tuple[float, float]:
    """Return the bounds *low* and *high*, in °F, in °C, rounded outwards to tenths, so that rounded bounds are valid.

    Commands must be limited to *low* and *high*.
    """
    lowest, highest = (round((fahrenheit - 32.0) / 0.18, 6) for fahrenheit in (low, high))
    return math.floor(lowest) / 10, math.ceil(highest) / 10


def number_grid(least: object, step: object, *, is_fahrenheit: bool = False) -> tuple[float, ...]:
    """Return the grid of numbers with a declared *step* from *least*; empty without. Of °F it is in °C."""
    origin, distance = to_number(least) or 0.0, to_number(step) or 0.0
    if distance <= 0:
        return ()
    return (to_celsius(origin, 12), distance / 1.8) if is_fahrenheit else (origin, distance)


def percent_grid(steps: float) -> tuple[float, ...]:
    """Return the grid of the percents of so many *steps*; empty if a step is finer than a percent."""
    return (0.0, 100 / abs(steps)) if 1 <= abs(steps) <= 100 else ()


def sensor_type(capability: str) -> str:
    """Return the service type of a sensor of *capability*."""
    known = CAPABILITIES[capability]
    return known.sensor or ("x_binary_sensor" if known.kind == "bool" else "x_sensor")


_MILLI = Conversion(0.0, 1.0, 1e3)
_MICRO = Conversion(0.0, 1.0, 1e6)
_KILO = Conversion(0.0, 1e3, 1.0)
_MEGA = Conversion(0.0, 1e6, 1.0)
_MASS_IN_AIR: Mapping[str, Conversion] = {"mg/m³": _KILO, "ug/m³": _SAME, "ug/m3": _SAME, "\u00b5g/m3": _SAME}
_UNITS: Mapping[str, Mapping[str, Conversion]] = {
    "current": {"mA": _MILLI, "\u00b5A": _MICRO, "kA": _KILO},
    "energy": {
        "mWh": Conversion(0.0, 1.0, 1e6),
        "Wh": _MILLI,
        "MWh": _KILO,
        "GWh": _MEGA,
        "TWh": Conversion(0.0, 1e9, 1.0),
        "J": Conversion(0.0, 1.0, 3.6e6),
        "kJ": Conversion(0.0, 1.0, 3.6e3),
        "MJ": Conversion(0.0, 1.0, 3.6),
        "GJ": Conversion(0.0, 1e3, 3.6),
        "cal": Conversion(0.0, 4.184, 3.6e6),
        "kcal": Conversion(0.0, 4.184, 3.6e3),
        "Mcal": Conversion(0.0, 4.184, 3.6),
        "Gcal": Conversion(0.0, 4184.0, 3.6),
        "thm": Conversion(0.0, 105.4804, 3.6),
    },
    "flow": {
        "L/h": _MILLI,
        "L/min": Conversion(0.0, 60.0, 1e3),
        "L/s": Conversion(0.0, 3.6, 1.0),
        "mL/s": Conversion(0.0, 3.6, 1e3),
        "m³/s": Conversion(0.0, 3600.0, 1.0),
        "m³/min": Conversion(0.0, 60.0, 1.0),
        "m3/h": _SAME,
        "ft³/min": Conversion(0.0, 60 * 0.028316846592, 1.0),
        "gal/min": Conversion(0.0, 60 * 0.003785411784, 1.0),
        "gal/h": Conversion(0.0, 0.003785411784, 1.0),
        "gal/d": Conversion(0.0, 0.003785411784, 24.0),
    },
    "frequency": {"mHz": _MILLI, "kHz": _KILO, "MHz": _MEGA, "GHz": Conversion(0.0, 1e9, 1.0)},
    "humidity": dict.fromkeys(("%RH", "% RH", "RH%"), _SAME),
    "illuminance": {"lux": _SAME, "Lux": _SAME, "klx": _KILO},
    "power": {
        "mW": _MILLI,
        "kW": _KILO,
        "MW": _MEGA,
        "GW": Conversion(0.0, 1e9, 1.0),
        "TW": Conversion(0.0, 1e12, 1.0),
        "BTU/h": Conversion(0.0, 1.0, 3.412141633),
    },
    "pressure": {
        "Pa": Conversion(0.0, 1.0, 100.0),
        "kPa": Conversion(0.0, 10.0, 1.0),
        "MPa": Conversion(0.0, 1e4, 1.0),
        **dict.fromkeys(("mb", "mbar"), _SAME),
        "cbar": Conversion(0.0, 10.0, 1.0),
        "bar": _KILO,
        "mmHg": Conversion(0.0, 1.333223874150, 1.0),
        "inHg": Conversion(0.0, 33.8638864034, 1.0),
        "inH₂O": Conversion(0.0, 2.49088908333, 1.0),
        "atm": Conversion(0.0, 1013.25, 1.0),
        "psi": Conversion(0.0, 68.9475729317, 1.0),
    },
    "temperature": {
        "°F": Conversion(32.0, 1.0, 1.8),
        "F": Conversion(32.0, 1.0, 1.8),
        "K": Conversion(273.15, 1.0, 1.0),
        "C": _SAME,
        **dict.fromkeys(("degC", "celsius"), _SAME),
    },
    "voltage": {"mV": _MILLI, "\u00b5V": _MICRO, "kV": _KILO, "MV": _MEGA},
    "pm1": _MASS_IN_AIR,
    "pm10": _MASS_IN_AIR,
    "pm25": _MASS_IN_AIR,
    "volatile_organic_compounds": _MASS_IN_AIR,
    "carbon_dioxide": {"ppb": _MILLI},
    "carbon_monoxide": {"ppb": _MILLI},
}
"""Capability to unit to conversion into the vocabulary's unit."""
