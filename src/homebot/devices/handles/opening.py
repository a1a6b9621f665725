"""Handles for things that open, close and lock, and for the alarm that guards them."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery
from homebot.devices.query.terms import StateIs

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome


class _Opening(Handle):
    moves_by: ClassVar[str] = "movement"

    @classmethod
    def where(cls, *, closed: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            closed: Whether it reports that it is closed; an unknown state matches neither.
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
        return await self._set({"position": position})

    async def _move(self, movement: str, position: float) -> Outcome:
        for capability in () if self.can(self.moves_by) else ("position", "tilt"):  # some only have slats
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
        return await self._set({"tilt": tilt})


class Closure(_Opening):
    """A motor-driven window, door, gate or garage door."""

    service_types: ClassVar[frozenset[str]] = frozenset({"closure"})


class WaterValve(_Opening):
    """A valve for water or gas."""

    service_types: ClassVar[frozenset[str]] = frozenset({"water_valve"})
    moves_by: ClassVar[str] = "valve"


class DoorLock(Handle):
    """A door lock."""

    service_types: ClassVar[frozenset[str]] = frozenset({"door_lock"})

    @classmethod
    def where(cls, *, locked: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            locked: Whether it reports that it is locked; a jammed or moving lock does not count as locked.
        """
        is_locked = StateIs("lock", "=" if locked else "!=", "locked")
        return cls._where(filters, *(() if locked is None else (is_locked,)))

    @property
    def state(self) -> str | None:
        """``locked``, ``unlocked``, ``locking``, ``unlocking``, ``open``, ``opening``, ``jammed``; None if unknown."""
        return self._text("lock")

    @property
    def locked(self) -> bool | None:
        """True if the bolt is out; None if unknown, jammed or moving."""
        return {"locked": True, "unlocked": False, "open": False, "opening": False}.get(self.state or "")

    async def lock(self, *, code: str = "") -> Outcome:
        """Lock it."""
        return await self.command("lock", "locked", code=code)

    async def unlock(self, *, code: str = "") -> Outcome:
        """Unlock it; the latch still holds the door."""
        return await self.command("lock", "unlocked", code=code)

    async def open(self, *, code: str = "") -> Outcome:
        """Unlock it and draw the latch, so that the door can be pushed open."""
        return await self.command("lock", "open", code=code)


class AlarmPanel(Handle):
    """The control panel of an alarm."""

    service_types: ClassVar[frozenset[str]] = frozenset({"x_alarm_panel"})

    @classmethod
    def where(cls, *, state: str | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            state: The state that it reports, for example ``disarmed``.
        """
        return cls._where(filters, states={"alarm": state})

    @property
    def state(self) -> str | None:
        """``disarmed``, ``armed_home``, ``armed_away``, ``pending``, ``triggered``, …; None if unknown."""
        return self._text("alarm")

    @property
    def armed(self) -> bool | None:
        """True if it is armed or triggered, False if disarmed; None if unknown or changing."""
        state = self.state or ""
        return True if state.startswith("armed_") or state == "triggered" else False if state == "disarmed" else None

    async def disarm(self, *, code: str = "") -> Outcome:
        """Disarm it."""
        return await self.command("alarm", "disarmed", code=code)

    async def arm_home(self, *, code: str = "") -> Outcome:
        """Arm it for a house with people at home."""
        return await self.command("alarm", "armed_home", code=code)

    async def arm_away(self, *, code: str = "") -> Outcome:
        """Arm it for an empty house."""
        return await self.command("alarm", "armed_away", code=code)

    async def arm_night(self, *, code: str = "") -> Outcome:
        """Arm it for the night."""
        return await self.command("alarm", "armed_night", code=code)

    async def arm_vacation(self, *, code: str = "") -> Outcome:
        """Arm it for a vacation."""
        return await self.command("alarm", "armed_vacation", code=code)

    async def arm_custom_bypass(self, *, code: str = "") -> Outcome:
        """Arm it without the sensors that were bypassed at the panel."""
        return await self.command("alarm", "armed_custom_bypass", code=code)

    async def trigger(self, *, code: str = "") -> Outcome:
        """Trigger the alarm."""
        return await self.command("alarm", "triggered", code=code)
