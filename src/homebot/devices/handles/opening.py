"""What opens and closes: coverings of windows, closures such as windows, doors and gates, and valves."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted
from homebot.devices.query import StateIs

__all__ = ["Closure", "WaterValve", "WindowCovering"]


class _Opening(Handle):
    moves_by: ClassVar[str] = "movement"

    @classmethod
    def wanted(cls, *, closed: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            closed: Whether it says that it is closed; one that has not said fits neither.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, None if closed is None else StateIs(cls.moves_by, "=" if closed else "!=", "closed"))

    @property
    def position(self) -> float | None:
        """How far open it is, in percent: 0 is closed."""
        return self._number("position")

    @property
    def movement(self) -> str | None:
        """``open``, ``closed``, ``opening``, ``closing`` or ``stopped``."""
        return self._text(self.moves_by)

    async def open(self) -> None:
        """Open it.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self._move("open", 100.0)

    async def close(self) -> None:
        """Close it.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self._move("closed", 0.0)

    async def stop(self) -> None:
        """Let it rest where it is.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self.command(self.moves_by, "stopped")

    async def set_position(self, position: float) -> None:
        """Make it *position* percent open.

        Raises:
            RefusedError: It has no positions, or this is not in 0 to 100.
            LinkError: No gateway of it is there now.
        """
        await self.command("position", position)

    async def _move(self, movement: str, position: float) -> None:
        if self.can(self.moves_by) or not self.can("position"):
            await self.command(self.moves_by, movement)
        else:
            await self.command("position", position)


class WindowCovering(_Opening):
    """A blind, shutter, curtain or awning."""

    service_types: ClassVar[frozenset[str]] = frozenset({"window_covering"})

    @property
    def tilt(self) -> float | None:
        """How far its slats are open, in percent."""
        return self._number("tilt")

    async def set_tilt(self, tilt: float) -> None:
        """Make its slats *tilt* percent open.

        Raises:
            RefusedError: It has no slats to tilt, or this is not in 0 to 100.
            LinkError: No gateway of it is there now.
        """
        await self.command("tilt", tilt)


class Closure(_Opening):
    """A window, door, gate or garage door with a motor; see :attr:`Handle.device` for which."""

    service_types: ClassVar[frozenset[str]] = frozenset({"closure"})


class WaterValve(_Opening):
    """A valve for water or gas."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_valve"})
    moves_by: ClassVar[str] = "valve"
