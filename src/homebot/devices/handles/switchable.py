"""What is on or off, and nothing else: plugs, switches, sirens."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["Plug", "Siren", "Switch"]


class _Switchable(Handle):
    @classmethod
    def wanted(cls, *, on: bool | None = None, **place: Unpack[Place]) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            on: Whether it says that it is on; one that has not said fits neither.
            place: As for every kind; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("on_off", on))

    @property
    def on(self) -> bool | None:
        """Whether it is on; None where that is unknown."""
        return self._flag("on_off")

    async def turn_on(self) -> None:
        """Turn it on.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self.command("on_off", True)  # noqa: FBT003  # the value

    async def turn_off(self) -> None:
        """Turn it off.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self.command("on_off", False)  # noqa: FBT003  # the value


class Plug(_Switchable):
    """A socket for whatever is plugged in."""

    service_types: ClassVar[frozenset[str]] = frozenset({"plug"})

    @property
    def power(self) -> float | None:
        """Watts drawn, where it measures that."""
        return self._number("power")


class Switch(_Switchable):
    """A relay, whatever it switches."""

    service_types: ClassVar[frozenset[str]] = frozenset({"switch"})


class Siren(_Switchable):
    """What makes itself heard."""

    service_types: ClassVar[frozenset[str]] = frozenset({"siren"})
