"""The people of a house: their habits, their places, and their walks."""

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, Protocol

from homebot.house.rooms import DAY, OUTSIDE, Rooms
from homebot.support.timer_queue import TimerQueue

MOVES = 20.0
"""Seconds of movement of a sitting person, after coming in and each time in between."""


class Habit(NamedTuple):
    """A habit: setting out for a room at some time of the day.

    Attributes:
        at: Seconds since midnight.
        jitter: Seconds by which it may be earlier or later, uniformly distributed.
        asleep: Whether they sleep there, in the dark.
        still: Seconds without movement, awake, between two short movements, as of a reader;
            0 for constant movement.
    """

    at: float
    room: str
    jitter: float = 0.0
    asleep: bool = False
    still: float = 0.0


class Visit(NamedTuple):
    """One habit on one day, with its jitter.

    Attributes:
        at: Seconds since the first midnight.
        still: As for :class:`Habit`.
    """

    at: float
    room: str
    asleep: bool
    still: float = 0.0


class Person(NamedTuple):
    """A person in the house.

    Attributes:
        day: Their habits, the same every day apart from jitter.
        starts_in: Their room at the first midnight.
        speed: Metres a second, above 0.
    """

    name: str
    day: Sequence[Habit]
    starts_in: str = OUTSIDE
    asleep: bool = True
    speed: float = 1.0

    def plan(self, day: int, seed: str) -> tuple[Visit, ...]:
        """Return the visits of *day*, 0 for the first, in order of time; determined by *seed*."""
        rng = random.Random(f"{seed}/{self.name}/{day}")  # noqa: S311  # numbers of a game, no secrets
        drawn = [
            (min(DAY - 1.0, max(0.0, habit.at + rng.uniform(-1.0, 1.0) * habit.jitter)), habit) for habit in self.day
        ]
        return tuple(
            Visit(day * DAY + at, habit.room, habit.asleep, habit.still)
            for at, habit in sorted(drawn, key=lambda pair: pair[0])
        )


class MovementObserver(Protocol):
    """A port for people's movements."""

    def on_door_passed(self, name: str, left: str, entered: str) -> None:
        """Handle a person's passage through the door between two rooms, into *entered*."""

    def on_sleep(self, name: str, room: str) -> None:
        """Handle a person falling asleep."""

    def on_motion(self, room: str) -> None:
        """Handle a person who sets out, arrives, passes or moves in *room*; called after the above."""

    def on_still(self, room: str) -> None:
        """Handle an awake person in *room* that stops moving."""


@dataclass(eq=False)
class _Body:
    """A person's place; ``walk`` counts walks, so that a new one ends an older one.

    ``still`` is that of their habit, ``moves`` whether they are moving.
    """

    person: Person
    room: str
    asleep: bool
    walk: int = 0
    still: float = 0.0
    moves: bool = True


class Household:
    """People that walk from room to room by their habits.

    Args:
        clock: Returns the current time of the queue.

    Raises:
        UsageError: A room does not exist, or no doors lead to it.
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
        """Return the people in *room*, asleep or not."""
        return tuple(body.person.name for body in self._bodies if body.room == room)

    def awake_in(self, room: str) -> int:
        """Return the number of people awake in *room*."""
        return sum(body.room == room and not body.asleep for body in self._bodies)

    def moving_in(self, room: str) -> int:
        """Return the number of people in *room* that are awake and do not sit still."""
        return sum(body.room == room and not body.asleep and body.moves for body in self._bodies)

    def stir(self, room: str) -> None:
        """Let the people sitting in *room* move for a moment."""
        for body in self._bodies:
            if body.room == room and not body.moves:
                self._move(body, body.walk)

    def _set_out(self, body: _Body, visit: Visit) -> None:
        body.walk += 1
        body.asleep, body.still, body.moves = False, 0.0, True
        self._walk(body, body.walk, visit, self._rooms.path(body.room, visit.room))

    def _walk(self, body: _Body, walk: int, visit: Visit, way: tuple[str, ...]) -> None:
        if walk != body.walk:
            return  # they changed their mind on the way
        if way[0] != body.room:
            left, body.room = body.room, way[0]
            self._observer.on_door_passed(body.person.name, left, body.room)
            self._observer.on_motion(left)
        if len(way) == 1:
            body.asleep, body.still = visit.asleep, visit.still
            if body.asleep:
                self._observer.on_sleep(body.person.name, body.room)
            elif body.still:
                self._queue.set(object(), self._clock() + MOVES, partial(self._sit, body, walk))
        else:
            seconds = self._rooms.metres(way[0], way[1]) / body.person.speed
            self._queue.set(object(), self._clock() + seconds, partial(self._walk, body, walk, visit, way[1:]))
        self._observer.on_motion(body.room)

    def _sit(self, body: _Body, walk: int) -> None:
        if walk == body.walk and body.moves:
            body.moves = False
            self._queue.set(object(), self._clock() + body.still, partial(self._move, body, walk))
            self._observer.on_still(body.room)

    def _move(self, body: _Body, walk: int) -> None:
        if walk == body.walk and not body.moves:
            body.moves = True
            self._queue.set(object(), self._clock() + MOVES, partial(self._sit, body, walk))
            self._observer.on_motion(body.room)
