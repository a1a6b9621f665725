"""Sensors that measure a number."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

__all__ = ["ElectricalMeter", "HumiditySensor", "LightSensor", "PressureSensor", "TemperatureSensor"]


class _Measuring(Handle):
    """A sensor of one quantity.

    Attributes:
        measures: The capability that ``above`` and ``below`` compare.
    """

    measures: ClassVar[str]

    @classmethod
    def wanted(
        cls, *, above: float | None = None, below: float | None = None, **place: Unpack[CommonFilters]
    ) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            above: It measures more than this, in the unit of its property.
            below: It measures less than this, likewise.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(
            place,
            None if above is None else cls._is(cls.measures, float(above), ">"),
            None if below is None else cls._is(cls.measures, float(below), "<"),
        )


class TemperatureSensor(_Measuring):
    """A thermometer."""

    service_types: ClassVar[frozenset[str]] = frozenset({"temperature_sensor"})
    measures: ClassVar[str] = "temperature"

    @property
    def celsius(self) -> float | None:
        """The temperature in °C; None if unknown."""
        return self._number(self.measures)


class HumiditySensor(_Measuring):
    """A hygrometer."""

    service_types: ClassVar[frozenset[str]] = frozenset({"humidity_sensor"})
    measures: ClassVar[str] = "humidity"

    @property
    def percent(self) -> float | None:
        """The relative humidity in percent; None if unknown."""
        return self._number(self.measures)


class LightSensor(_Measuring):
    """A sensor of ambient light."""

    service_types: ClassVar[frozenset[str]] = frozenset({"light_sensor"})
    measures: ClassVar[str] = "illuminance"

    @property
    def lux(self) -> float | None:
        """The illuminance in lux; None if unknown."""
        return self._number(self.measures)


class PressureSensor(_Measuring):
    """A barometer."""

    service_types: ClassVar[frozenset[str]] = frozenset({"pressure_sensor"})
    measures: ClassVar[str] = "pressure"

    @property
    def hectopascal(self) -> float | None:
        """The air pressure in hPa; None if unknown."""
        return self._number(self.measures)


class ElectricalMeter(_Measuring):
    """A meter of electrical power and energy; ``above`` and ``below`` compare its power, in W."""

    service_types: ClassVar[frozenset[str]] = frozenset({"electrical_meter"})
    measures: ClassVar[str] = "power"

    @property
    def watts(self) -> float | None:
        """The power drawn in W; None if unknown."""
        return self._number("power")

    @property
    def kilowatt_hours(self) -> float | None:
        """The energy drawn in kWh, as counted by the meter; None if unknown."""
        return self._number("energy")
