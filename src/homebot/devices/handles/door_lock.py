"""A door's lock."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted
from homebot.devices.query import StateIs

__all__ = ["DoorLock"]


class DoorLock(Handle):
    """A door's lock."""

    service_types: ClassVar[frozenset[str]] = frozenset({"door_lock"})

    @classmethod
    def wanted(cls, *, locked: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            locked: Whether it says that it is locked; one that is jammed or on its way is not.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, None if locked is None else StateIs("lock", "=" if locked else "!=", "locked"))

    @property
    def state(self) -> str | None:
        """``locked``, ``unlocked``, ``locking``, ``unlocking``, ``open``, ``opening`` or ``jammed``."""
        return self._text("lock")

    @property
    def locked(self) -> bool | None:
        """Whether the bolt is out; None where that is unknown, or it is jammed or on its way."""
        return {"locked": True, "unlocked": False, "open": False, "opening": False}.get(self.state or "")

    async def lock(self, *, code: str = "") -> None:
        """Lock it.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot be told, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("lock", "locked", code=code)

    async def unlock(self, *, code: str = "") -> None:
        """Unlock it; the latch still holds the door.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot be told, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("lock", "unlocked", code=code)

    async def open(self, *, code: str = "") -> None:
        """Unlock it and draw the latch, so that the door can be pushed open.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("lock", "open", code=code)
