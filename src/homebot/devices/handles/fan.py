"""A fan."""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.wanted import Place, Wanted

__all__ = ["Fan"]


class Fan(Handle):
    """A fan, an air purifier or an extractor hood."""

    service_types: ClassVar[frozenset[str]] = frozenset({"fan"})

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
        """Whether it is on; None where that is unknown. One that only tells its speed is off at none."""
        if (on := self._flag("on_off")) is not None:
            return on
        if self.speed is not None:
            return self.speed > 0
        return None if self.mode is None else self.mode.casefold() != _OFF

    @property
    def speed(self) -> float | None:
        """How fast it turns, in percent."""
        return self._number("fan_speed")

    @property
    def mode(self) -> str | None:
        """Which of its own speeds it has."""
        return self._text("fan_mode")

    async def turn_on(self, *, speed: float | None = None) -> None:
        """Turn it on, at *speed* percent where that is given.

        Raises:
            RefusedError: It cannot do that, and nothing was sent; or its gateway says no.
            LinkError: No gateway of it is there now.
        """
        if speed is not None:
            self._check("fan_speed", float(speed))
        if speed is None or self.can("on_off"):
            await self.command("on_off", True)  # noqa: FBT003  # the value
        if speed is not None:
            await self.command("fan_speed", speed)

    async def turn_off(self) -> None:
        """Turn it off; where that is one of its speeds, set it to that.

        Raises:
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        if not self.can("on_off") and (mode := self._mode_off()) is not None:
            await self.command("fan_mode", mode)
        elif not self.can("on_off") and self.can("fan_speed"):
            await self.command("fan_speed", 0.0)
        else:
            await self.command("on_off", False)  # noqa: FBT003  # the value

    async def set_speed(self, speed: float) -> None:
        """Make it turn at *speed* percent.

        Raises:
            RefusedError: It has no speeds, or this is not in 0 to 100.
            LinkError: No gateway of it is there now.
        """
        await self.command("fan_speed", speed)

    def _mode_off(self) -> str | None:
        """Which of its own speeds is off; None where none is."""
        options = [word for one in self.capabilities if one.name == "fan_mode" and one.settable for word in one.options]
        return next((word for word in options if word.casefold() == _OFF), None)


_OFF = "off"
