"""A door lock."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery
from homebot.devices.query import StateIs

__all__ = ["DoorLock"]


class DoorLock(Handle):
    """A door lock."""

    service_types: ClassVar[frozenset[str]] = frozenset({"door_lock"})

    @classmethod
    def wanted(cls, *, locked: bool | None = None, **place: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            locked: Whether it reports that it is locked; one that is jammed or moving is not.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(place, None if locked is None else StateIs("lock", "=" if locked else "!=", "locked"))

    @property
    def state(self) -> str | None:
        """``locked``, ``unlocked``, ``locking``, ``unlocking``, ``open``, ``opening``, ``jammed``; None if unknown."""
        return self._text("lock")

    @property
    def locked(self) -> bool | None:
        """True if the bolt is out; None if unknown, jammed or moving."""
        return {"locked": True, "unlocked": False, "open": False, "opening": False}.get(self.state or "")

    async def lock(self, *, code: str = "") -> None:
        """Lock it.

        Args:
            code: The code, if it requires one; never logged or shown in an error.

        Raises:
            RefusedError: It takes no such command, or the code is wrong or missing.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("lock", "locked", code=code)

    async def unlock(self, *, code: str = "") -> None:
        """Unlock it; the latch still holds the door.

        Args:
            code: The code, if it requires one; never logged or shown in an error.

        Raises:
            RefusedError: It takes no such command, or the code is wrong or missing.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("lock", "unlocked", code=code)

    async def open(self, *, code: str = "") -> None:
        """Unlock it and draw the latch, so that the door can be pushed open.

        Args:
            code: The code, if it requires one; never logged or shown in an error.

        Raises:
            RefusedError: It does not support this, or the code is wrong or missing.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("lock", "open", code=code)
