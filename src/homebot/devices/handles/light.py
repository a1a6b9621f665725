"""A lamp."""

from __future__ import annotations

import math
from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle, plain_value
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery
from homebot.errors import RefusedError

__all__ = ["Light"]

_HUE = 360.0
_SATURATION = 100.0


class Light(Handle):
    """A lamp that is on or off and, if it supports it, has a brightness, a colour temperature and a colour."""

    service_types: ClassVar[frozenset[str]] = frozenset({"light"})

    @classmethod
    def wanted(
        cls,
        *,
        on: bool | None = None,
        dimmable: bool | None = None,
        tunable: bool | None = None,
        colored: bool | None = None,
        **place: Unpack[CommonFilters],
    ) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` make of these arguments.

        Args:
            on: Whether it reports that it is on; one whose state is unknown matches neither.
            dimmable: Whether its brightness can be set.
            tunable: Whether its colour temperature can be set.
            colored: Whether its colour can be set.
            place: The conditions that every kind has, such as ``area``; see :class:`Handle`.
        """
        return cls._asked(
            place,
            cls._is("on_off", on),
            cls._can("level", wanted=dimmable),
            cls._can("color_temperature", wanted=tunable),
            cls._can("color", wanted=colored),
        )

    @property
    def on(self) -> bool | None:
        """True if it is on; None if unknown."""
        return self._flag("on_off")

    @property
    def level(self) -> float | None:
        """The brightness in percent, 0 to 100; 0 only if it is off. None if unknown."""
        return self._number("level")

    @property
    def kelvin(self) -> float | None:
        """The colour temperature in kelvin; None if unknown."""
        return self._number("color_temperature")

    @property
    def color(self) -> tuple[float, float] | None:
        """The hue in degrees, 0 to 360, and the saturation in percent, 0 to 100; None if unknown."""
        match self.value("color"):
            case (float(hue), float(saturation)):
                return hue, saturation
            case _:
                return None

    @property
    def effect(self) -> str | None:
        """The name of the effect that is running; None if unknown or none."""
        return self._text("effect")

    async def turn_on(
        self,
        *,
        level: float | None = None,
        kelvin: float | None = None,
        color: tuple[float, float] | None = None,
        effect: str | None = None,
        transition: float = 0.0,
    ) -> None:
        """Turn it on. Settings that are not given stay as they are.

        Args:
            level: The brightness in percent, above 0 and up to 100.
            kelvin: The colour temperature in kelvin, within the bounds of the lamp's ``color_temperature``.
            color: The hue in degrees, 0 to 360, and the saturation in percent, 0 to 100.
            effect: One of the options of its ``effect``.
            transition: Seconds that the change takes, where the lamp supports that; 0 or more.

        Raises:
            RefusedError: It does not support one of these or a value is out of range, and nothing was sent; or its
                gateway refused.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        if level is not None and not 0 < level <= 100:
            raise RefusedError(f"{level:g} as level of {self.id}", "turned on, it takes above 0 to 100 %")
        wanted = {"level": level, "color_temperature": kelvin, "color": _checked(self.id, color), "effect": effect}
        given = [(name, value) for name, value in wanted.items() if value is not None]
        for name, value in given:
            self._check(name, plain_value(value))
        for name, value in given or [("on_off", True)]:
            await self.command(name, value, transition=transition)

    async def turn_off(self, *, transition: float = 0.0) -> None:
        """Turn it off.

        Raises:
            RefusedError: It takes no such command.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        await self.command("on_off", False, transition=transition)  # noqa: FBT003  # the value

    async def set_level(self, level: float, *, transition: float = 0.0) -> None:
        """Set the brightness to *level* percent; 0 turns it off.

        Raises:
            RefusedError: It cannot be dimmed, or the level is not in 0 to 100.
            LinkError: None of its gateways is running and connected; it may work later.
        """
        if level == 0:
            await self.turn_off(transition=transition)
        else:
            await self.command("level", level, transition=transition)


def _checked(who: str, color: tuple[float, float] | None) -> tuple[float, float] | None:
    if color is None:
        return None
    hue, saturation = float(color[0]), float(color[1])
    if not (math.isfinite(hue) and 0 <= hue <= _HUE and 0 <= saturation <= _SATURATION):
        raise RefusedError(f"{color} as color of {who}", "it takes hue 0 to 360 and saturation 0 to 100")
    return hue, saturation
