"""What makes a room warm or cool: thermostats and air conditioners."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["AirConditioner", "Thermostat"]


class Thermostat(Handle):
    """What holds a room at a temperature."""

    service_types: ClassVar[frozenset[str]] = frozenset({"thermostat"})

    @classmethod
    def wanted(
        cls, *, above: float | None = None, below: float | None = None, mode: str | None = None, **place: Unpack[Place]
    ) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            above: It measures more than this many °C.
            below: It measures less than this many °C.
            mode: The mode that it says it is in, for example ``heat``.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(
            place,
            cls._is("local_temperature", _celsius(above), ">"),
            cls._is("local_temperature", _celsius(below), "<"),
            cls._is("thermostat_mode", mode),
        )

    @property
    def temperature(self) -> float | None:
        """What it measures, in °C."""
        return self._number("local_temperature")

    @property
    def heating_setpoint(self) -> float | None:
        """What it heats to, in °C."""
        return self._number("heating_setpoint")

    @property
    def cooling_setpoint(self) -> float | None:
        """What it cools to, in °C."""
        return self._number("cooling_setpoint")

    @property
    def mode(self) -> str | None:
        """What it may do: ``off``, ``heat``, ``cool``, ``auto``, …."""
        return self._text("thermostat_mode")

    @property
    def action(self) -> str | None:
        """What it does now: ``heating``, ``idle``, …."""
        return self._text("thermostat_action")

    async def heat_to(self, celsius: float) -> None:
        """Set the temperature to heat to.

        Raises:
            RefusedError: It does not heat, or not to that.
            LinkError: No gateway of it is there now.
        """
        await self.command("heating_setpoint", celsius)

    async def cool_to(self, celsius: float) -> None:
        """Set the temperature to cool to.

        Raises:
            RefusedError: It does not cool, or not to that.
            LinkError: No gateway of it is there now.
        """
        await self.command("cooling_setpoint", celsius)

    async def set_mode(self, mode: str) -> None:
        """Set what it may do.

        Raises:
            RefusedError: It has no such mode; names those it has.
            LinkError: No gateway of it is there now.
        """
        await self.command("thermostat_mode", mode)


class AirConditioner(Thermostat):
    """A thermostat that cools, and may dry and ventilate."""

    service_types: ClassVar[frozenset[str]] = frozenset({"room_air_conditioner"})


def _celsius(value: float | None) -> float | None:
    return None if value is None else float(value)
