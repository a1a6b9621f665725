"""Handles for thermostats and air conditioners."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome

__all__ = ["AirConditioner", "Thermostat"]


class Thermostat(Handle):
    """A thermostat, or another device that holds a room at a temperature."""

    service_types: ClassVar[frozenset[str]] = frozenset({"thermostat"})

    @classmethod
    def where(
        cls,
        *,
        above: float | None = None,
        below: float | None = None,
        mode: str | None = None,
        **filters: Unpack[CommonFilters],
    ) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            above: It measures more than this, in °C.
            below: It measures less than this, in °C.
            mode: The mode that it reports, for example ``heat``.
        """
        return cls._where(
            filters,
            states={"thermostat_mode": mode},
            above={"local_temperature": above},
            below={"local_temperature": below},
        )

    @property
    def temperature(self) -> float | None:
        """The measured temperature in °C; None if unknown."""
        return self._number("local_temperature")

    @property
    def heating_setpoint(self) -> float | None:
        """The target temperature for heating in °C; None if unknown."""
        return self._number("heating_setpoint")

    @property
    def cooling_setpoint(self) -> float | None:
        """The target temperature for cooling in °C; None if unknown."""
        return self._number("cooling_setpoint")

    @property
    def mode(self) -> str | None:
        """The selected mode: ``off``, ``heat``, ``cool``, ``auto``, …; None if unknown."""
        return self._text("thermostat_mode")

    @property
    def action(self) -> str | None:
        """The current activity: ``heating``, ``cooling``, ``idle``, …; None if unknown."""
        return self._text("thermostat_action")

    async def heat_to(self, celsius: float) -> Outcome:
        """Set the target temperature for heating.

        Args:
            celsius: In °C, within the bounds of its ``heating_setpoint``.

        Raises:
            RefusedError: It does not heat, or the temperature is out of bounds.
        """
        return await self.command("heating_setpoint", celsius)

    async def cool_to(self, celsius: float) -> Outcome:
        """Set the target temperature for cooling.

        Args:
            celsius: In °C, within the bounds of its ``cooling_setpoint``.

        Raises:
            RefusedError: It does not cool, or the temperature is out of bounds.
        """
        return await self.command("cooling_setpoint", celsius)

    async def set_mode(self, mode: str) -> Outcome:
        """Select the mode.

        Args:
            mode: One of the options of its ``thermostat_mode``.

        Raises:
            RefusedError: It has no such mode; the message lists those it has.
        """
        return await self.command("thermostat_mode", mode)


class AirConditioner(Thermostat):
    """A thermostat that cools, and may dry and ventilate."""

    service_types: ClassVar[frozenset[str]] = frozenset({"room_air_conditioner"})
