"""A fan."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery

__all__ = ["Fan"]


class Fan(Handle):
    """A fan, an air purifier or an extractor hood."""

    service_types: ClassVar[frozenset[str]] = frozenset({"fan"})

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
        """True if it is on; None if unknown. A fan that reports only its speed is off at 0."""
        if (on := self._flag("on_off")) is not None:
            return on
        if self.speed is not None:
            return self.speed > 0
        return None if self.mode is None else self.mode.casefold() != _OFF

    @property
    def speed(self) -> float | None:
        """The speed in percent, 0 to 100; None if unknown."""
        return self._number("fan_speed")

    @property
    def mode(self) -> str | None:
        """The selected preset, one of the options of its ``fan_mode``; None if unknown."""
        return self._text("fan_mode")

    async def turn_on(self, *, speed: float | None = None) -> None:
        """Turn it on.

        Args:
            speed: The speed in percent, 0 to 100; by default it stays as it is.

        Raises:
            RefusedError: It does not support this, and nothing was sent; or its gateway refused.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        if speed is not None:
            self._check("fan_speed", float(speed))
        if speed is None or self.can("on_off"):
            await self.command("on_off", True)  # noqa: FBT003  # the value
        if speed is not None:
            await self.command("fan_speed", speed)

    async def turn_off(self) -> None:
        """Turn it off, by its speed or preset if it has no switch.

        Raises:
            RefusedError: It takes no such command.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        if not self.can("on_off") and (mode := self._mode_off()) is not None:
            await self.command("fan_mode", mode)
        elif not self.can("on_off") and self.can("fan_speed"):
            await self.command("fan_speed", 0.0)
        else:
            await self.command("on_off", False)  # noqa: FBT003  # the value

    async def set_speed(self, speed: float) -> None:
        """Set the speed to *speed* percent, 0 to 100.

        Raises:
            RefusedError: Its speed cannot be set, or the value is out of range.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("fan_speed", speed)

    def _mode_off(self) -> str | None:
        """Return the one of its own speeds that is off; None where there is none."""
        options = [word for one in self.capabilities if one.name == "fan_mode" and one.settable for word in one.options]
        return next((word for word in options if word.casefold() == _OFF), None)


_OFF = "off"
