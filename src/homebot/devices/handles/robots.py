"""Robots that clean floors and mow lawns."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["LawnMower", "RoboticVacuumCleaner"]


class RoboticVacuumCleaner(Handle):
    """A robot that cleans floors."""

    service_types: ClassVar[frozenset[str]] = frozenset({"robotic_vacuum_cleaner"})

    @classmethod
    def wanted(cls, *, state: str | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            state: What it says it does: ``cleaning``, ``docked``, ``returning``, ``paused``, ``idle`` or ``error``.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("vacuum", state))

    @property
    def state(self) -> str | None:
        """``cleaning``, ``docked``, ``returning``, ``paused``, ``idle`` or ``error``."""
        return self._text("vacuum")

    @property
    def battery(self) -> float | None:
        """Charge of its battery, in percent, also where the device tells that apart from the robot."""
        return self._number_of_device("battery")

    async def start(self) -> None:
        """Let it clean.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self.command("vacuum", "cleaning")

    async def pause(self) -> None:
        """Let it wait where it is.

        Raises:
            RefusedError: It cannot do that.
            LinkError: No gateway of it is there now.
        """
        await self.command("vacuum", "paused")

    async def stop(self) -> None:
        """Let it end what it does.

        Raises:
            RefusedError: It cannot do that.
            LinkError: No gateway of it is there now.
        """
        await self.command("vacuum", "idle")

    async def return_to_dock(self) -> None:
        """Send it home.

        Raises:
            RefusedError: It cannot do that.
            LinkError: No gateway of it is there now.
        """
        await self.command("vacuum", "returning")


class LawnMower(Handle):
    """A robot that mows."""

    service_types: ClassVar[frozenset[str]] = frozenset({"x_lawn_mower"})

    @classmethod
    def wanted(cls, *, state: str | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            state: What it says it does: ``mowing``, ``paused``, ``docked``, ``returning`` or ``error``.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("mower", state))

    @property
    def state(self) -> str | None:
        """``mowing``, ``paused``, ``docked``, ``returning`` or ``error``."""
        return self._text("mower")

    async def start(self) -> None:
        """Let it mow.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self.command("mower", "mowing")

    async def pause(self) -> None:
        """Let it wait where it is.

        Raises:
            RefusedError: It cannot do that.
            LinkError: No gateway of it is there now.
        """
        await self.command("mower", "paused")

    async def return_to_dock(self) -> None:
        """Send it home.

        Raises:
            RefusedError: It cannot do that.
            LinkError: No gateway of it is there now.
        """
        await self.command("mower", "docked")
