"""Sensors that measure a number."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["ElectricalMeter", "HumiditySensor", "LightSensor", "PressureSensor", "TemperatureSensor"]


class _Measuring(Handle):
    """What measures one thing.

    Attributes:
        measures: The capability whose value it is.
    """

    measures: ClassVar[str]

    @classmethod
    def wanted(cls, *, above: float | None = None, below: float | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            above: It measures more than this.
            below: It measures less than this.
            place: As for every kind; see :class:`Handle`.
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
        """The temperature in °C; None where that is unknown."""
        return self._number(self.measures)


class HumiditySensor(_Measuring):
    """A hygrometer."""

    service_types: ClassVar[frozenset[str]] = frozenset({"humidity_sensor"})
    measures: ClassVar[str] = "humidity"

    @property
    def percent(self) -> float | None:
        """Relative humidity in percent; None where that is unknown."""
        return self._number(self.measures)


class LightSensor(_Measuring):
    """What measures how bright it is."""

    service_types: ClassVar[frozenset[str]] = frozenset({"light_sensor"})
    measures: ClassVar[str] = "illuminance"

    @property
    def lux(self) -> float | None:
        """How bright it is, in lux; None where that is unknown."""
        return self._number(self.measures)


class PressureSensor(_Measuring):
    """A barometer."""

    service_types: ClassVar[frozenset[str]] = frozenset({"pressure_sensor"})
    measures: ClassVar[str] = "pressure"

    @property
    def hectopascal(self) -> float | None:
        """Air pressure in hPa; None where that is unknown."""
        return self._number(self.measures)


class ElectricalMeter(_Measuring):
    """What measures electricity; ``above`` and ``below`` are watts."""

    service_types: ClassVar[frozenset[str]] = frozenset({"electrical_meter"})
    measures: ClassVar[str] = "power"

    @property
    def watts(self) -> float | None:
        """Power drawn, in W; None where that is unknown."""
        return self._number("power")

    @property
    def kilowatt_hours(self) -> float | None:
        """Energy drawn, in kWh; None where that is unknown."""
        return self._number("energy")
