"""Sensors that say whether something is so."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["ContactSensor", "OccupancySensor", "SmokeAlarm", "WaterLeakDetector"]


class ContactSensor(Handle):
    """What senses whether a door or window is open."""

    service_types: ClassVar[frozenset[str]] = frozenset({"contact_sensor"})

    @classmethod
    def wanted(cls, *, is_open: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            is_open: Whether it says that what it watches is open.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("contact", is_open))

    @property
    def is_open(self) -> bool | None:
        """Whether what it watches is open; None where that is unknown."""
        return self._flag("contact")


class OccupancySensor(Handle):
    """What senses whether somebody is there."""

    service_types: ClassVar[frozenset[str]] = frozenset({"occupancy_sensor"})

    @classmethod
    def wanted(cls, *, occupied: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            occupied: Whether it says that somebody is there.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("occupancy", occupied))

    @property
    def occupied(self) -> bool | None:
        """Whether somebody is there or moves; None where that is unknown."""
        return self._flag("occupancy")


class WaterLeakDetector(Handle):
    """What senses water where none should be."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_leak_detector"})

    @classmethod
    def wanted(cls, *, wet: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            wet: Whether it says that it is wet.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("water_leak", wet))

    @property
    def wet(self) -> bool | None:
        """Whether it is wet; None where that is unknown."""
        return self._flag("water_leak")


class SmokeAlarm(Handle):
    """What senses smoke or carbon monoxide."""

    service_types: ClassVar[frozenset[str]] = frozenset({"smoke_co_alarm"})

    @classmethod
    def wanted(cls, *, smoke: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            smoke: Whether it says that there is smoke.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("smoke", smoke))

    @property
    def smoke(self) -> bool | None:
        """Whether there is smoke; None where that is unknown."""
        return self._flag("smoke")

    @property
    def carbon_monoxide(self) -> bool | None:
        """Whether there is carbon monoxide; None where that is unknown."""
        return self._flag("carbon_monoxide_alarm")
