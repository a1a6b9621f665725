"""Signs that a device is on its way to the wanted values: a lamp that fades, a motor that runs. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, Literal, TypeAlias, final

from homebot.control import durations
from homebot.control.held_values import END_POSITIONS
from homebot.control.timeline.facts import Order
from homebot.devices.value import PlainValue

__all__ = ["FadeOut", "FadeSign", "Motion"]

FadeSign: TypeAlias = Literal["fading", "back", "unknown"]

_RUNS: Final = frozenset({"opening", "closing"})
_OPENINGS: Final = frozenset({"movement", "valve"})
_STEP: Final = 0.5
"""Percent by which a level or a position changes at least while a device is on its way."""


@final
class Motion:
    """Approach of a level or a position to its goal, over the reports after one command.

    Many dimmers have a ramp of their own, and many blinds report their position alone until the last step.

    Args:
        order: The command.
        last: The values that the part reported last.
    """

    __slots__ = ("_goals", "_is_positioned", "_now")

    def __init__(self, order: Order, last: Mapping[str, PlainValue]) -> None:
        settings = order.settings
        self._is_positioned = order.moves and "position" in settings
        self._goals: dict[str, float] = {}
        self._now: dict[str, float] = {}
        level = 0.0 if settings.get("on_off") is False else settings.get("level")
        if isinstance(level, float):
            self._goals["level"] = level
            self._begin("level", 0.0 if last.get("on_off") is False else last.get("level"))
        position = END_POSITIONS.get(settings.get("movement"))
        if order.moves and not self._is_positioned and position is not None:
            self._goals["position"] = position
            self._begin("position", last.get("position"))

    def shows(self, capability: str, value: PlainValue) -> bool:
        """Return whether a report shows that the device is on its way."""
        if self._is_positioned and capability in _OPENINGS:
            return value in _RUNS
        goal = self._goals.get(capability)
        if goal is None or not isinstance(value, float):
            return False
        before = self._now.get(capability)
        self._now[capability] = value
        return before is not None and abs(before - goal) - abs(value - goal) >= _STEP

    def _begin(self, capability: str, value: PlainValue) -> None:
        if isinstance(value, float):
            self._now[capability] = value


@final
class FadeOut:
    """Difference between a lamp that fades off after it reported "off", and one that was turned on again.

    Many bridges report what was commanded before the lamp has faded there. Each further report has a lower level, but
    that of a lamp that was turned on again mostly the level of before.

    Args:
        level: The level that the lamp reported before it was turned off; None if it reported none.
    """

    __slots__ = ("_level", "_lowered_at", "_told_at")

    def __init__(self, level: PlainValue) -> None:
        self._level = level if isinstance(level, float) else math.inf
        self._told_at = self._lowered_at = -math.inf

    @property
    def is_possible(self) -> bool:
        """True if the level before is known."""
        return self._level < math.inf

    def report(self, level: PlainValue, now: float) -> FadeSign:
        """Record a report of *level* at *now*, and return its meaning."""
        if not isinstance(level, float) or not self.is_possible:
            return "unknown"
        self._told_at = now
        if level < self._level - _STEP:
            self._level, self._lowered_at = level, now
            return "fading"
        return "back" if level > self._level + _STEP or self._lowered_at == -math.inf else "unknown"

    def sign(self, now: float) -> FadeSign:
        """Return the meaning of a report of "on" at *now*, by the level in the same message."""
        if now - self._lowered_at <= durations.SAME_MESSAGE:
            return "fading"
        is_back = now - self._told_at <= durations.SAME_MESSAGE and self._lowered_at == -math.inf
        return "back" if is_back else "unknown"
