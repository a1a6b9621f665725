"""A door's lock."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import ClassVar

from homebot.house.simulated_device import SimulatedDevice

__all__ = ["SimulatedDoorLock"]


@dataclass(eq=False)
class SimulatedDoorLock(SimulatedDevice):
    """A lock that takes ``lock`` and ``unlock``; says ``locking`` or ``unlocking``, then where it ended.

    A jammed lock says ``jammed`` and is as open as it was; told again it tries again.

    Attributes:
        is_locked: Whether the bolt is out.
        travel_time: Seconds the bolt takes.
        jams: The share of turns, 0 to 1, in which the bolt sticks.
        rng: Decides which.
    """

    kind: ClassVar[str] = "lock"
    is_locked: bool = True
    travel_time: float = 2.0
    jams: float = 0.0
    rng: random.Random = field(default_factory=lambda: random.Random(0), repr=False)  # noqa: S311  # physics, no secrets
    service_type: str = field(default="locks", kw_only=True)

    def __post_init__(self) -> None:
        self._state_text = "locked" if self.is_locked else "unlocked"
        self._arrives_at: float | None = None
        self._wants_locked = self.is_locked

    def state(self) -> str:
        """``locked``, ``unlocked`` or ``jammed``; ``locking`` or ``unlocking`` on the way."""
        return self._state_text

    def restore(self) -> str:
        """``lock`` or ``unlock``."""
        return "lock" if self.is_locked else "unlock"

    def next_event(self) -> float | None:
        """Return when the bolt arrives."""
        return self._arrives_at

    def commands(self) -> tuple[str, ...]:
        """Return the commands that it knows."""
        return ("lock", "unlock")

    def _take(self, command: str) -> tuple[str, ...]:
        if command not in {"lock", "unlock"}:
            return ()
        self._wants_locked = command == "lock"
        self._arrives_at = self.now + self.travel_time
        self._state_text = f"{command}ing"
        return (self._state_text,)

    def _on_timer(self) -> tuple[str, ...]:
        self._arrives_at = None
        if self.rng.random() < self.jams:
            self._state_text = "jammed"
        else:
            self.is_locked = self._wants_locked
            self._state_text = "locked" if self.is_locked else "unlocked"
        return (self._state_text,)
