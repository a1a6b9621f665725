"""Temperatures of devices that may count in Fahrenheit. Pure.

Source: Home Assistant core 2025.4, ``util/unit_conversion.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.errors import WireError
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.payload import shown

__all__ = ["Thermometer", "read_thermometer"]


@dataclass(frozen=True, slots=True)
class Thermometer:
    """In which unit a device counts; all of homebot counts in °C.

    Attributes:
        is_fahrenheit: Whether that is °F and not °C.
    """

    is_fahrenheit: bool

    def celsius(self, number: float) -> float:
        """Return the device's *number* in °C."""
        return (number - 32.0) / 1.8 if self.is_fahrenheit else number

    def number(self, celsius: float) -> float:
        """Return a temperature in °C as the device's number."""
        return celsius * 1.8 + 32.0 if self.is_fahrenheit else celsius

    def bounds(self, config: Config, least: float, most: float) -> tuple[float, float]:
        """Return the config's ``min_temp`` and ``max_temp`` in °C; *least* and *most* stand for missing ones."""
        low, high = config.optional_number("min_temp"), config.optional_number("max_temp")
        return (
            least if low is None else self.celsius(low),
            most if high is None else self.celsius(high),
        )


def read_thermometer(config: Config) -> Thermometer:
    """Return in which unit the device counts: °C where the config does not say.

    Raises:
        WireError: It names another unit.
    """
    unit = config.text("temperature_unit", "C").strip().upper().removeprefix("°")
    if unit not in ("C", "F"):
        raise WireError(f"{config.component}: temperature_unit is {shown(unit)}, not C or F")
    return Thermometer(unit == "F")
