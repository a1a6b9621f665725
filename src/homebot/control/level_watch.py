"""Signs that a lamp is fading to what was commanded. Pure."""

from __future__ import annotations

from typing import Final, final

from homebot.control.command import IssuedCommand
from homebot.devices.value import PlainValue

__all__ = ["LevelWatch"]

_STEP: Final = 0.5
"""By how many percent a level changes at least where something fades."""


@final
class LevelWatch:
    """Recognises that a dimmer is on its way after one command, by levels that come nearer to the commanded one.

    Many dimmers have a ramp of their own, of which nothing is said in the command. One that is told again on its way
    begins it anew.

    Args:
        command: The command.
    """

    __slots__ = ("_goal", "_level")

    def __init__(self, command: IssuedCommand) -> None:
        settings = command.settings
        goal = 0.0 if settings.get("on_off") is False else settings.get("level")
        self._goal = goal if isinstance(goal, float) else None
        self._level: float | None = None
        for state in command.device.states if self._goal is not None else ():
            if state.part != command.part.id:
                continue
            value = state.value.plain()
            if state.capability == "on_off" and value is False:
                self._level = 0.0  # whatever it keeps as its level
                break
            if state.capability == "level" and isinstance(value, float):
                self._level = value

    def shows_motion(self, level: PlainValue) -> bool:
        """Return whether a report of *level* is nearer to what was commanded than the one before."""
        if self._goal is None or not isinstance(level, float):
            return False
        before, self._level = self._level, level
        return before is not None and abs(before - self._goal) - abs(level - self._goal) >= _STEP
