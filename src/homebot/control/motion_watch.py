"""Signs that what opens and closes is on its way, in other values than the commanded one. Pure."""

from __future__ import annotations

from typing import Final, final

from homebot.control.command import IssuedCommand
from homebot.control.held_values import END_POSITIONS
from homebot.devices.value import PlainValue

__all__ = ["MotionWatch"]

_MOVES: Final = frozenset({"opening", "closing"})
_STEP: Final = 0.5
"""By how many percent a position changes at least where something moves."""


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
