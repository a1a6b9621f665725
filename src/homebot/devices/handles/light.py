"""A lamp."""

from __future__ import annotations

import math
from typing import ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle, plain_value
from homebot.devices.handles.wanted import Place, Wanted
from homebot.errors import RefusedError

__all__ = ["Light"]

_HUE = 360.0
_SATURATION = 100.0


class Light(Handle):
    """A lamp: on or off, and as far as it can, dimmed, warm or cold, coloured."""

    service_types: ClassVar[frozenset[str]] = frozenset({"light"})

    @classmethod
    def wanted(
        cls,
        *,
        on: bool | None = None,
        dimmable: bool | None = None,
        tunable: bool | None = None,
        colored: bool | None = None,
        **place: Unpack[Place],
    ) -> Wanted[Self]:
        """Return what is asked for.

        Args:
            on: Whether it says that it is on; one that has not said fits neither.
            dimmable: Whether its level can be set.
            tunable: Whether its white can be made warmer and colder.
            colored: Whether its colour can be set.
            place: As for every kind; see :class:`Handle`.
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
        """Whether it is on; None where that is unknown."""
        return self._flag("on_off")

    @property
    def level(self) -> float | None:
        """How bright it is, in percent; 0 only where it is off."""
        return self._number("level")

    @property
    def kelvin(self) -> float | None:
        """How warm or cold its white is."""
        return self._number("color_temperature")

    @property
    def color(self) -> tuple[float, float] | None:
        """Hue in degrees, 0 to 360, and saturation in percent."""
        match self.value("color"):
            case (float(hue), float(saturation)):
                return hue, saturation
            case _:
                return None

    @property
    def effect(self) -> str | None:
        """What it plays."""
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
        """Turn it on; what is not given stays as it is.

        Args:
            level: Brightness in percent, above 0.
            kelvin: White, in the lamp's own range.
            color: Hue from 0 to 360 degrees and saturation from 0 to 100 percent.
            effect: One of its effects.
            transition: Seconds that the change shall take, where the lamp can do that.

        Raises:
            RefusedError: It cannot do all of that, and nothing was sent; or its gateway says no.
            LinkError: No gateway of it is there now.
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
            RefusedError: It cannot be told.
            LinkError: No gateway of it is there now.
        """
        await self.command("on_off", False, transition=transition)  # noqa: FBT003  # the value

    async def set_level(self, level: float, *, transition: float = 0.0) -> None:
        """Make it *level* percent bright; 0 turns it off.

        Raises:
            RefusedError: It cannot be dimmed, or the level is not in 0 to 100.
            LinkError: No gateway of it is there now.
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
