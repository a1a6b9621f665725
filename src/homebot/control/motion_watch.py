"""Signs that a device is on its way to what was commanded: a lamp that fades, a motor that moves. Pure."""

from __future__ import annotations

from typing import Final, final

from homebot.control.command import IssuedCommand
from homebot.control.held_values import END_POSITIONS
from homebot.devices.value import PlainValue

__all__ = ["LevelWatch", "MotionWatch"]

_MOVES: Final = frozenset({"opening", "closing"})
_STEP: Final = 0.5
"""By how many percent a level or a position changes at least where something is on its way."""


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


@final
class MotionWatch:
    """Recognises that a blind, a gate or a valve is on its way after one command.

    Many report nothing of the commanded value on their way: they are open until the last step is closed, and tell their
    position meanwhile; or they tell that they move, and the position at the end.

    Args:
        command: The command.
    """

    __slots__ = ("_goal", "_is_positioned", "_position")

    def __init__(self, command: IssuedCommand) -> None:
        settings = command.settings
        self._is_positioned = "position" in settings
        self._goal = END_POSITIONS.get(settings.get("movement"))
        self._position: float | None = None
        if self._goal is not None:
            for state in command.device.states:
                if state.capability == "position" and state.part == command.part.id:
                    position = state.value.plain()
                    self._position = position if isinstance(position, float) else None

    def shows_motion(self, capability: str, value: PlainValue) -> bool:
        """Return whether a report of something else than was commanded shows that it is on its way."""
        if self._is_positioned:
            return capability in {"movement", "valve"} and value in _MOVES
        if self._goal is None or capability != "position" or not isinstance(value, float):
            return False
        before, self._position = self._position, value
        return before is not None and abs(before - self._goal) - abs(value - self._goal) >= _STEP
