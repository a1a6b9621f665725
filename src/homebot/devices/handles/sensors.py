"""Handles for binary sensors and for sensors that measure a number."""

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery


class ContactSensor(Handle):
    """A contact sensor at a door or window."""

    service_types: ClassVar[frozenset[str]] = frozenset({"contact_sensor"})

    @classmethod
    def where(cls, *, is_open: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            is_open: Whether it reports that the door or window is open.
        """
        return cls._where(filters, states={"contact": is_open})

    @property
    def is_open(self) -> bool | None:
        """True if the door or window is open; None if unknown."""
        return self._flag("contact")


class OccupancySensor(Handle):
    """A presence or motion sensor."""

    service_types: ClassVar[frozenset[str]] = frozenset({"occupancy_sensor"})

    @classmethod
    def where(cls, *, occupied: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            occupied: Whether it reports presence or motion.
        """
        return cls._where(filters, states={"occupancy": occupied})

    @property
    def occupied(self) -> bool | None:
        """True if it detects presence or motion; None if unknown."""
        return self._flag("occupancy")


class WaterLeakDetector(Handle):
    """A water leak detector."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_leak_detector"})

    @classmethod
    def where(cls, *, wet: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments."""
        return cls._where(filters, states={"water_leak": wet})

    @property
    def wet(self) -> bool | None:
        """True if it detects water; None if unknown."""
        return self._flag("water_leak")


class SmokeAlarm(Handle):
    """A detector of smoke or carbon monoxide."""

    service_types: ClassVar[frozenset[str]] = frozenset({"smoke_co_alarm"})

    @classmethod
    def where(cls, *, smoke: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments."""
        return cls._where(filters, states={"smoke": smoke})

    @property
    def smoke(self) -> bool | None:
        """True if it detects smoke; None if unknown."""
        return self._flag("smoke")

    @property
    def carbon_monoxide(self) -> bool | None:
        """True if it detects carbon monoxide; None if unknown."""
        return self._flag("carbon_monoxide_alarm")


class _Measuring(Handle):
    """A sensor of one quantity.

    Attributes:
        measures: The capability that ``above`` and ``below`` compare.
    """

    measures: ClassVar[str] = ""

    @classmethod
    def where(
        cls, *, above: float | None = None, below: float | None = None, **filters: Unpack[CommonFilters]
    ) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            above: It measures more than this, in the unit of its property.
            below: It measures less than this, in the same unit.
        """
        return cls._where(filters, above={cls.measures: above}, below={cls.measures: below})


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
