"""Signs that a lamp which reported that it is off is still fading there. Pure."""

from __future__ import annotations

import math
from typing import Final, Literal, TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.devices.value import PlainValue

__all__ = ["FadeOut", "FadeSign"]

FadeSign: TypeAlias = Literal["fading", "back", "unknown"]

_STEP: Final = 0.5
"""By how many percent a level changes at least where something fades."""

_SAME: Final = 0.01
"""Seconds within which reports are those of one message."""


@final
class FadeOut:
    """Tells a lamp that fades off, and reports first that it is off, from one that was turned on again.

    Many bridges report what was commanded before the lamp has faded there, by a transition of their own. Each further
    report has a lower level; one that was turned on again mostly has the level of before.

    Args:
        command: The command that turned it off.
    """

    __slots__ = ("_level", "_lowered_at", "_told_at")

    def __init__(self, command: IssuedCommand) -> None:
        self._level = math.inf
        self._told_at = self._lowered_at = -math.inf
        for state in command.device.states:
            value = state.value.plain()
            if state.part == command.part.id and state.capability == "level" and isinstance(value, float):
                self._level = value

    @property
    def is_possible(self) -> bool:
        """True if the lamp told a level before it was turned off."""
        return self._level < math.inf

    def take(self, level: PlainValue, now: float) -> FadeSign:
        """Take in a report of *level* at *now*, and return what it is a sign of."""
        if not isinstance(level, float) or not self.is_possible:
            return "unknown"
        self._told_at = now
        if level < self._level - _STEP:
            self._level, self._lowered_at = level, now
            return "fading"
        return "back" if level > self._level + _STEP or self._lowered_at == -math.inf else "unknown"

    def sign(self, now: float) -> FadeSign:
        """Return what a report at *now* that it is on is a sign of, by the level in the same message."""
        if now - self._lowered_at <= _SAME:
            return "fading"
        return "back" if now - self._told_at <= _SAME and self._lowered_at == -math.inf else "unknown"
