"""People and their days."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from homebot.house.daylight import DAY
from homebot.house.rooms import OUTSIDE

__all__ = ["Habit", "Person", "Visit"]


@dataclass(frozen=True, slots=True)
class Habit:
    """A habit: to set out for a room at some time of the day.

    Attributes:
        at: Seconds since midnight.
        room: Where to.
        jitter: Seconds by which it may be earlier or later; uniform.
        asleep: Whether they lie still there, in the dark.
    """

    at: float
    room: str
    jitter: float = 0.0
    asleep: bool = False


@dataclass(frozen=True, slots=True)
class Visit:
    """One habit on one day, with its jitter.

    Attributes:
        at: Seconds since the first midnight.
        room: Where to.
        asleep: Whether to sleep there.
    """

    at: float
    room: str
    asleep: bool


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody who lives in the house.

    Attributes:
        name: Who.
        day: Their habits, every day the same but for the jitter.
        starts_in: Where they are at the first midnight.
        asleep: Whether they sleep then.
        speed: Metres a second, above 0.
    """

    name: str
    day: Sequence[Habit]
    starts_in: str = OUTSIDE
    asleep: bool = True
    speed: float = 1.0

    def plan(self, day: int, seed: str) -> tuple[Visit, ...]:
        """Return the visits of *day*, 0 for the first, in time order; the same for the same *seed*."""
        rng = random.Random(f"{seed}/{self.name}/{day}")  # noqa: S311  # dice of a game, no secrets
        drawn = [
            Visit(min(DAY - 1.0, max(0.0, habit.at + rng.uniform(-1.0, 1.0) * habit.jitter)), habit.room, habit.asleep)
            for habit in self.day
        ]
        return tuple(
            Visit(day * DAY + visit.at, visit.room, visit.asleep) for visit in sorted(drawn, key=lambda v: v.at)
        )
