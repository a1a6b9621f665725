"""Fade speed of a Tasmota lamp for which one change takes a given time. Pure.

Tasmota's speed is the time of the whole way from dark to full, in half seconds. A shorter way takes a part of it, so
that the speed depends on what the lamp shows now.

Source: tasmota.github.io/docs, Commands > Speed2 and SetOption117; hatasmota 0.10.2, ``light.py``.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass

from homebot.numbers import finite_number

__all__ = ["FadeTarget", "LampState", "speed_for"]


@dataclass(frozen=True, slots=True)
class FadeTarget:
    """The state that a command leads to.

    Attributes:
        on: Whether the lamp is on afterwards.
        level: Its brightness then, 0 to 100; None where it stays.
        mired: Its white then.
        color: Its hue and saturation then.
    """

    on: bool = True
    level: int | None = None
    mired: int | None = None
    color: tuple[float, float] | None = None


class LampState:
    """The last reported state of a lamp. It forgets nothing, and holds four values."""

    __slots__ = ("_is_on", "_level", "_mired", "_rgb")

    def __init__(self) -> None:
        self._is_on = False
        self._level = _FULL
        self._rgb: tuple[float, ...] = ()
        self._mired = 0.0

    def update(self, is_on: object, level: object, color: object, mired: object) -> None:
        """Take what one message says; what it leaves out, or says in another way, stays."""
        if isinstance(is_on, bool):
            self._is_on = is_on
        number = finite_number(level)
        if number is not None and 0 <= number <= _FULL:
            self._level = number
        self._rgb = _rgb(color) or self._rgb
        white = finite_number(mired)
        if white is not None and white > 0:
            self._mired = white

    def distance(self, target: FadeTarget, kind: int, mireds: tuple[int, int]) -> float:
        """Return which part of the whole way *target* is away, 0 to 1: that of the channel that changes most.

        Args:
            target: What the command changes.
            kind: The light type.
            mireds: Coldest and warmest white.
        """
        now = self._level if self._is_on else 0.0
        then = float(target.level) if target.level is not None else self._level if target.on else 0.0
        before: list[float] = []
        after: list[float] = []
        if kind >= _COLOR and self._rgb:
            before += self._rgb
            after += self._rgb if target.color is None else _rgb_of(*target.color)
        if kind >= _WHITES and self._mired:
            coldest, warmest = mireds
            target_mired = self._mired if target.mired is None else target.mired
            before.append((self._mired - coldest) / (warmest - coldest))
            after.append((target_mired - coldest) / (warmest - coldest))
        if not before:
            before, after = [1.0], [1.0]
        return max(abs(one * now - other * then) / _FULL for one, other in zip(before, after, strict=True))


def speed_for(seconds: float, distance: float) -> int:
    """Return the speed at which a *distance* of the whole way takes *seconds*, as near as Tasmota can: 1 to 40."""
    half_seconds = seconds * 2 / distance if distance else 0.0
    return round(min(max(half_seconds, _LEAST), _MOST))


_FULL = 100.0
_WHITES, _COLOR = 2, 3
_LEAST, _MOST = 1, 40
_CHANNELS = 3
_HEXADECIMAL = frozenset("0123456789abcdefABCDEF")
_MAX_TEXT = 40


def _rgb(color: object) -> tuple[float, ...]:
    """Return the shares of red, green and blue in ``FF8000...`` or ``255,128,0,...``; empty for anything else."""
    if not isinstance(color, str) or len(color) > _MAX_TEXT:
        return ()
    if "," in color:
        parts = color.split(",")
        numbers = [int(one) for one in parts if one.isascii() and one.isdecimal()]
    elif len(color) % 2 == 0 and _HEXADECIMAL.issuperset(color):
        parts = [color[place : place + 2] for place in range(0, len(color), 2)]
        numbers = [int(one, 16) for one in parts]
    else:
        return ()
    if len(numbers) < _CHANNELS or len(numbers) != len(parts):
        return ()
    return tuple(min(one, 255) / 255 for one in numbers[:_CHANNELS])


def _rgb_of(hue: float, saturation: float) -> tuple[float, ...]:
    return tuple(int(one * 255) / 255 for one in colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1))
