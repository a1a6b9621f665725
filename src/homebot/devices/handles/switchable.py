"""Devices that are on or off: plugs, switches, sirens."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

__all__ = ["Plug", "Siren", "Switch"]


class _Switchable(Handle):
    @classmethod
    def wanted(cls, *, on: bool | None = None, **place: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            on: Whether it reports that it is on; one whose state is unknown matches neither.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(place, cls._is("on_off", on))

    @property
    def on(self) -> bool | None:
        """True if it is on; None if unknown."""
        return self._flag("on_off")

    async def turn_on(self) -> None:
        """Turn it on.

        Raises:
            RefusedError: It takes no such command.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("on_off", True)  # noqa: FBT003  # the value

    async def turn_off(self) -> None:
        """Turn it off.

        Raises:
            RefusedError: It takes no such command.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("on_off", False)  # noqa: FBT003  # the value


class Plug(_Switchable):
    """A smart plug or socket."""

    service_types: ClassVar[frozenset[str]] = frozenset({"plug"})

    @property
    def power(self) -> float | None:
        """The power drawn in watts; None if unknown or not measured."""
        return self._number("power")


class Switch(_Switchable):
    """A relay or switch; the kind for an output when nothing says what it feeds."""

    service_types: ClassVar[frozenset[str]] = frozenset({"switch"})


class Siren(_Switchable):
    """A siren."""

    service_types: ClassVar[frozenset[str]] = frozenset({"siren"})
