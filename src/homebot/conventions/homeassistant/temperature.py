"""Temperatures of devices that may count in Fahrenheit. Pure.

Source: Home Assistant core 2025.4, ``util/unit_conversion.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.payload import shown
from homebot.conventions.units import celsius_bounds, to_celsius, to_fahrenheit
from homebot.errors import WireError

__all__ = ["Limits", "Thermometer", "read_thermometer"]


@dataclass(frozen=True, slots=True)
class Thermometer:
    """In which unit a device counts; all of homebot counts in °C.

    Attributes:
        is_fahrenheit: Whether that is °F and not °C.
    """

    is_fahrenheit: bool

    def celsius(self, number: float) -> float:
        """Return the device's *number* in °C."""
        return to_celsius(number) if self.is_fahrenheit else number

    def number(self, celsius: float) -> float:
        """Return a temperature in °C as the device's number."""
        return to_fahrenheit(celsius) if self.is_fahrenheit else celsius

    def limits(self, config: DiscoveryConfig, least: float, most: float) -> Limits:
        """Return the config's ``min_temp`` and ``max_temp``; *least* and *most*, in °C, stand for missing ones."""
        low, high = config.optional_number("min_temp"), config.optional_number("max_temp")
        return Limits(self, self.number(least) if low is None else low, self.number(most) if high is None else high)


@dataclass(frozen=True, slots=True)
class Limits:
    """The lowest and the highest temperature that a device takes.

    Attributes:
        thermometer: The unit that it counts in.
        low: Its lowest number.
        high: Its highest number.
    """

    thermometer: Thermometer
    low: float
    high: float

    @property
    def bounds(self) -> tuple[float, float]:
        """The two in °C; see :func:`celsius_bounds`."""
        return celsius_bounds(self.low, self.high) if self.thermometer.is_fahrenheit else (self.low, self.high)

    def number(self, celsius: float) -> float:
        """Return a temperature within :attr:`bounds` as the device's number, which is within its own."""
        return min(max(self.thermometer.number(celsius), self.low), self.high)


def read_thermometer(config: DiscoveryConfig) -> Thermometer:
    """Return in which unit the device counts: °C where the config does not say.

    Raises:
        WireError: It names another unit.
    """
    unit = config.text("temperature_unit", "C").strip().upper().removeprefix("°")
    if unit not in ("C", "F"):
        raise WireError(f"{config.component}: temperature_unit is {shown(unit)}, not C or F")
    return Thermometer(unit == "F")
