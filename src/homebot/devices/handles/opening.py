"""Handles for things that open and close: window coverings, closures such as windows, doors and gates, and valves."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery
from homebot.devices.query import StateIs

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome

__all__ = ["Closure", "WaterValve", "WindowCovering"]


class _Opening(Handle):
    moves_by: ClassVar[str] = "movement"

    @classmethod
    def where(cls, *, closed: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            closed: Whether it reports that it is closed; one with an unknown state matches neither.
        """
        is_closed = StateIs(cls.moves_by, "=" if closed else "!=", "closed")
        return cls._where(filters, *(() if closed is None else (is_closed,)))

    @property
    def position(self) -> float | None:
        """The position in percent: 0 is closed, 100 is open. None if unknown."""
        return self._number("position")

    @property
    def movement(self) -> str | None:
        """``open``, ``closed``, ``opening``, ``closing`` or ``stopped``; None if unknown."""
        return self._text(self.moves_by)

    async def open(self) -> Outcome:
        """Open it."""
        return await self._move("open", 100.0)

    async def close(self) -> Outcome:
        """Close it."""
        return await self._move("closed", 0.0)

    async def stop(self) -> Outcome:
        """Stop moving."""
        return await self.command(self.moves_by, "stopped")

    async def set_position(self, position: float) -> Outcome:
        """Move to *position* percent: 0 is closed, 100 is open.

        Raises:
            RefusedError: It can only open and close, or the position is out of range.
        """
        return await self.command("position", position)

    async def _move(self, movement: str, position: float) -> Outcome:
        for capability in () if self.can(self.moves_by) else ("position", "tilt"):  # some have slats alone
            if self.can(capability):
                return await self.command(capability, position)
        return await self.command(self.moves_by, movement)


class WindowCovering(_Opening):
    """A blind, shutter, curtain or awning."""

    service_types: ClassVar[frozenset[str]] = frozenset({"window_covering"})

    @property
    def tilt(self) -> float | None:
        """The tilt of the slats in percent: 0 is closed, 100 is open. None if unknown."""
        return self._number("tilt")

    async def set_tilt(self, tilt: float) -> Outcome:
        """Tilt the slats to *tilt* percent: 0 is closed, 100 is open.

        Raises:
            RefusedError: Its slats cannot be tilted, or the value is out of range.
        """
        return await self.command("tilt", tilt)


class Closure(_Opening):
    """A motor-driven window, door, gate or garage door."""

    service_types: ClassVar[frozenset[str]] = frozenset({"closure"})


class WaterValve(_Opening):
    """A valve for water or gas."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_valve"})
    moves_by: ClassVar[str] = "valve"
