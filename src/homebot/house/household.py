"""People of a house: their habits, where they are, and their ways through it."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from homebot.house.rooms import DAY, OUTSIDE, Rooms
from homebot.timer_queue import TimerQueue

__all__ = ["Habit", "Household", "MovementObserver", "Person", "Visit"]


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
        rng = random.Random(f"{seed}/{self.name}/{day}")  # noqa: S311  # numbers of a game, no secrets
        drawn = [
            Visit(min(DAY - 1.0, max(0.0, habit.at + rng.uniform(-1.0, 1.0) * habit.jitter)), habit.room, habit.asleep)
            for habit in self.day
        ]
        return tuple(
            Visit(day * DAY + visit.at, visit.room, visit.asleep) for visit in sorted(drawn, key=lambda v: v.at)
        )


class MovementObserver(Protocol):
    """A port for people's movements."""

    def passed(self, name: str, left: str, entered: str) -> None:
        """Take note that a person went through the door between two rooms, and is in *entered* now."""
        ...

    def lay_down(self, name: str, room: str) -> None:
        """Take note that a person sleeps now."""
        ...

    def stirred(self, room: str) -> None:
        """Take note that a person set out, arrived or passed in *room*; called after the above."""
        ...


@dataclass(eq=False)
class _Body:
    """A person's place; ``walk`` counts the walks, so that an older one ends where a newer begins."""

    person: Person
    room: str
    asleep: bool
    walk: int = 0


class Household:
    """People who walk from room to room as their habits have it.

    Args:
        people: Who lives there.
        rooms: Where.
        queue: Gets their steps.
        clock: Returns the time that the queue is at.
        observer: Gets what they do.

    Raises:
        UsageError: A room is not there, or no doors lead to it.
    """

    def __init__(
        self,
        people: Sequence[Person],
        rooms: Rooms,
        queue: TimerQueue[object, Callable[[], None]],
        clock: Callable[[], float],
        observer: MovementObserver,
    ) -> None:
        self._rooms = rooms
        self._queue = queue
        self._clock = clock
        self._observer = observer
        self._bodies = [_Body(person, person.starts_in, person.asleep) for person in people]
        for person in people:
            for room in (person.starts_in, *(habit.room for habit in person.day)):
                rooms.path(person.starts_in, room)

    def begin_day(self, day: int, seed: str) -> None:
        """Plan the visits of *day*, 0 for the first."""
        for body in self._bodies:
            for visit in body.person.plan(day, seed):
                self._queue.set(object(), visit.at, partial(self._set_out, body, visit))

    def people_in(self, room: str) -> tuple[str, ...]:
        """Return who is in *room*, asleep or not."""
        return tuple(body.person.name for body in self._bodies if body.room == room)

    def awake_in(self, room: str) -> int:
        """Return how many are awake in *room*."""
        return sum(body.room == room and not body.asleep for body in self._bodies)

    def _set_out(self, body: _Body, visit: Visit) -> None:
        body.walk += 1
        body.asleep = False
        self._walk(body, body.walk, visit, self._rooms.path(body.room, visit.room))

    def _walk(self, body: _Body, walk: int, visit: Visit, way: tuple[str, ...]) -> None:
        if walk != body.walk:
            return  # they changed their mind on the way
        if way[0] != body.room:
            left, body.room = body.room, way[0]
            self._observer.passed(body.person.name, left, body.room)
            self._observer.stirred(left)
        if len(way) == 1:
            body.asleep = visit.asleep
            if body.asleep:
                self._observer.lay_down(body.person.name, body.room)
        else:
            seconds = self._rooms.metres(way[0], way[1]) / body.person.speed
            self._queue.set(object(), self._clock() + seconds, partial(self._walk, body, walk, visit, way[1:]))
        self._observer.stirred(body.room)
