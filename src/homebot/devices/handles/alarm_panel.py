"""An alarm."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["AlarmPanel"]


class AlarmPanel(Handle):
    """The control panel of an alarm."""

    service_types: ClassVar[frozenset[str]] = frozenset({"x_alarm_panel"})

    @classmethod
    def wanted(cls, *, state: str | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            state: How it says it is, for example ``disarmed``.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("alarm", state))

    @property
    def state(self) -> str | None:
        """``disarmed``, ``armed_home``, ``armed_away``, ``pending``, ``triggered``, …; None where that is unknown."""
        return self._text("alarm")

    @property
    def armed(self) -> bool | None:
        """Whether it is armed; None where that is unknown, or it is on its way."""
        state = self.state or ""
        return True if state.startswith("armed_") or state == "triggered" else False if state == "disarmed" else None

    async def disarm(self, *, code: str = "") -> None:
        """Disarm it.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "disarmed", code=code)

    async def arm_home(self, *, code: str = "") -> None:
        """Arm it for while somebody is at home.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "armed_home", code=code)

    async def arm_away(self, *, code: str = "") -> None:
        """Arm it for while nobody is.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "armed_away", code=code)

    async def arm_night(self, *, code: str = "") -> None:
        """Arm it for the night.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "armed_night", code=code)

    async def arm_vacation(self, *, code: str = "") -> None:
        """Arm it for a long absence.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "armed_vacation", code=code)

    async def arm_custom_bypass(self, *, code: str = "") -> None:
        """Arm it but for what was left out.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "armed_custom_bypass", code=code)

    async def trigger(self, *, code: str = "") -> None:
        """Set it off.

        Args:
            code: Where it wants one; a secret, which no log and no error shows.

        Raises:
            RefusedError: It cannot do that, or wants another code.
            LinkError: No gateway of it is there now.
        """
        await self.command("alarm", "triggered", code=code)
