"""Handles for robots that clean floors and mow lawns."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome

__all__ = ["LawnMower", "RoboticVacuumCleaner"]


class RoboticVacuumCleaner(Handle):
    """A robotic vacuum cleaner or mop."""

    service_types: ClassVar[frozenset[str]] = frozenset({"robotic_vacuum_cleaner"})

    @classmethod
    def where(cls, *, state: str | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

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
        """Return the query that ``find`` and ``follow`` make of these arguments.

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
