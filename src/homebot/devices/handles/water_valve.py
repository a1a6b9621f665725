"""A valve."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted
from homebot.devices.query import StateIs

__all__ = ["WaterValve"]


class WaterValve(Handle):
    """A valve for water or gas."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_valve"})

    @classmethod
    def wanted(cls, *, closed: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            closed: Whether it says that it is closed; one that has not said fits neither.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, None if closed is None else StateIs("valve", "=" if closed else "!=", "closed"))

    @property
    def state(self) -> str | None:
        """``open``, ``closed``, ``opening``, ``closing`` or ``stopped``."""
        return self._text("valve")

    @property
    def position(self) -> float | None:
        """How far open it is, in percent."""
        return self._number("position")

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

    async def set_position(self, position: float) -> None:
        """Make it *position* percent open.

        Raises:
            RefusedError: It has no positions, or this is not in 0 to 100.
            LinkError: No gateway of it is there now.
        """
        await self.command("position", position)

    async def _move(self, state: str, position: float) -> None:
        if self.can("valve") or not self.can("position"):
            await self.command("valve", state)
        else:
            await self.command("position", position)
