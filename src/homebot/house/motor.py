"""Motors that take their time: of windows and of covers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from homebot.house.simulated_device import SimulatedDevice, number, number_text

__all__ = ["CoverMotor", "WindowMotor"]


@dataclass(eq=False)
class WindowMotor(SimulatedDevice):
    """A motor that takes a while to ``open`` or ``close`` its window.

    It also takes ``stop`` and a position from ``0`` (closed) to ``1`` (open), and moves at one speed. It says
    ``opening`` or ``closing``, then where it arrived: ``open``, ``closed`` or a position.

    Attributes:
        is_open: Whether it was not closed when it last rested.
        travel_time: Seconds from one end to the other, above 0.
    """

    kind: ClassVar[str] = "window"
    is_open: bool = False
    travel_time: float = 3.0
    service_type: str = field(default="windows", kw_only=True)

    def __post_init__(self) -> None:
        self._start = self._target = 1.0 if self.is_open else 0.0
        self._started_at = self.now
        self._moves = False

    @property
    def position(self) -> float:
        """Position at :attr:`now`: 0 is closed, 1 is open."""
        return self.position_at(self.now)

    def position_at(self, now: float) -> float:
        """Return where it is at *now*, no earlier than :attr:`now`, if it is told nothing until then."""
        if not self._moves:
            return self._target
        way = min((now - self._started_at) / self.travel_time, abs(self._target - self._start))
        return self._start + (way if self._target > self._start else -way)

    def state(self) -> str:
        """``open``, ``closed`` or a position; ``opening`` or ``closing`` on the way."""
        if self._moves:
            return "opening" if self._target > self._start else "closing"
        return _position_text(self._target)

    def watts(self) -> float:
        """40 W while it moves."""
        return 40.0 if self._moves else 0.0

    def restore(self) -> str:
        """``open``, ``close`` or the position where it is."""
        return {"open": "open", "closed": "close"}.get(_position_text(self.position), number_text(self.position))

    def next_event(self) -> float | None:
        """Return when it arrives."""
        return self._started_at + abs(self._target - self._start) * self.travel_time if self._moves else None

    def commands(self) -> tuple[str, ...]:
        """Return the commands that it knows."""
        return ("open", "close", "stop", "0 to 1")

    def knows(self, command: str) -> bool:
        """Return whether it knows *command*."""
        return command in {"open", "close", "stop"} or number(command, 0.0, 1.0) is not None

    def _take(self, command: str) -> tuple[str, ...]:
        position = self.position
        if command == "stop":
            self._rest(position)
            return (self.state(),)
        wanted = {"open": 1.0, "close": 0.0}.get(command)
        target = number(command, 0.0, 1.0) if wanted is None else wanted
        if target is None:
            return ()
        if target == position:
            self._rest(position)
        else:
            self._start, self._target, self._started_at, self._moves = position, target, self.now, True
        return (self.state(),)

    def _on_timer(self) -> tuple[str, ...]:
        self._rest(self._target)
        return (self.state(),)

    def _rest(self, position: float) -> None:
        self._target, self._moves, self.is_open = position, False, position > 0


@dataclass(eq=False)
class CoverMotor(WindowMotor):
    """A shutter or blind: as a window's motor, but slower, and open at first. Its position is the light it lets in."""

    kind: ClassVar[str] = "cover"
    is_open: bool = True
    travel_time: float = 20.0
    service_type: str = field(default="covers", kw_only=True)


def _position_text(position: float) -> str:
    return {0.0: "closed", 1.0: "open"}.get(position, number_text(position))
