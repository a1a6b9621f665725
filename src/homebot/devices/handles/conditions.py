"""Sensors of a condition that is true or false."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

__all__ = ["ContactSensor", "OccupancySensor", "SmokeAlarm", "WaterLeakDetector"]


class ContactSensor(Handle):
    """A contact sensor at a door or window."""

    service_types: ClassVar[frozenset[str]] = frozenset({"contact_sensor"})

    @classmethod
    def wanted(cls, *, is_open: bool | None = None, **place: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            is_open: Whether it reports that the door or window is open.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("contact", is_open))

    @property
    def is_open(self) -> bool | None:
        """True if the door or window is open; None if unknown."""
        return self._flag("contact")


class OccupancySensor(Handle):
    """A presence or motion sensor."""

    service_types: ClassVar[frozenset[str]] = frozenset({"occupancy_sensor"})

    @classmethod
    def wanted(cls, *, occupied: bool | None = None, **place: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            occupied: Whether it reports presence or motion.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("occupancy", occupied))

    @property
    def occupied(self) -> bool | None:
        """True if it detects presence or motion; None if unknown."""
        return self._flag("occupancy")


class WaterLeakDetector(Handle):
    """A water leak detector."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_leak_detector"})

    @classmethod
    def wanted(cls, *, wet: bool | None = None, **place: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            wet: Whether it reports water.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("water_leak", wet))

    @property
    def wet(self) -> bool | None:
        """True if it detects water; None if unknown."""
        return self._flag("water_leak")


class SmokeAlarm(Handle):
    """A detector of smoke or carbon monoxide."""

    service_types: ClassVar[frozenset[str]] = frozenset({"smoke_co_alarm"})

    @classmethod
    def wanted(cls, *, smoke: bool | None = None, **place: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            smoke: Whether it reports smoke.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("smoke", smoke))

    @property
    def smoke(self) -> bool | None:
        """True if it detects smoke; None if unknown."""
        return self._flag("smoke")

    @property
    def carbon_monoxide(self) -> bool | None:
        """True if it detects carbon monoxide; None if unknown."""
        return self._flag("carbon_monoxide_alarm")
