"""Handles for appliances that work on their own: thermostats, air conditioners, vacuum cleaners and mowers."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome


class Thermostat(Handle):
    """A thermostat, or another device that keeps a room at a temperature."""

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
        """Return the query that ``find`` and ``follow`` build from these arguments.

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
            RefusedError: It has no such mode; the message lists its modes.
        """
        return await self.command("thermostat_mode", mode)


class AirConditioner(Thermostat):
    """A thermostat that cools, and may dry and ventilate."""

    service_types: ClassVar[frozenset[str]] = frozenset({"room_air_conditioner"})


class RoboticVacuumCleaner(Handle):
    """A robotic vacuum cleaner or mop."""

    service_types: ClassVar[frozenset[str]] = frozenset({"robotic_vacuum_cleaner"})

    @classmethod
    def where(cls, *, state: str | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            state: The activity that it reports; see :attr:`state`.
        """
        return cls._where(filters, states={"vacuum": state})

    @property
    def state(self) -> str | None:
        """``cleaning``, ``docked``, ``returning``, ``paused``, ``idle`` or ``error``; None if unknown."""
        return self._text("vacuum")

    @property
    def battery(self) -> float | None:
        """The charge of the battery in percent, even if another part of the device reports it; None if unknown."""
        return self._number_of_device("battery")

    async def start(self) -> Outcome:
        """Start or resume cleaning."""
        return await self.command("vacuum", "cleaning")

    async def clean_rooms(self, *rooms: str) -> Outcome:
        """Clean the *rooms* of its map, by name or number.

        Raises:
            RefusedError: It cannot, or knows no such room.
        """
        return await self.command("clean_rooms", ", ".join(rooms))

    async def pause(self) -> Outcome:
        """Pause where it is."""
        return await self.command("vacuum", "paused")

    async def stop(self) -> Outcome:
        """Stop the job."""
        return await self.command("vacuum", "idle")

    async def return_to_dock(self) -> Outcome:
        """Return to the dock."""
        return await self.command("vacuum", "returning")


class LawnMower(Handle):
    """A robotic lawn mower."""

    service_types: ClassVar[frozenset[str]] = frozenset({"x_lawn_mower"})

    @classmethod
    def where(cls, *, state: str | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            state: The activity that it reports: ``mowing``, ``paused``, ``docked``, ``returning`` or ``error``.
        """
        return cls._where(filters, states={"mower": state})

    @property
    def state(self) -> str | None:
        """``mowing``, ``paused``, ``docked``, ``returning`` or ``error``; None if unknown."""
        return self._text("mower")

    async def start(self) -> Outcome:
        """Start or resume mowing."""
        return await self.command("mower", "mowing")

    async def pause(self) -> Outcome:
        """Pause where it is."""
        return await self.command("mower", "paused")

    async def return_to_dock(self) -> Outcome:
        """Return to the dock."""
        return await self.command("mower", "docked")
