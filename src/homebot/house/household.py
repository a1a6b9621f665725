"""People of a house: where they are, and their ways through it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from homebot.house.people import Person, Visit
from homebot.house.rooms import Rooms
from homebot.timer_queue import TimerQueue

__all__ = ["Household", "MovementObserver"]


class MovementObserver(Protocol):
    """A port to whatever is told about people's movements."""

    def passed(self, name: str, left: str, entered: str) -> None:
        """Somebody went through the door between two rooms; they are in *entered* now."""
        ...

    def lay_down(self, name: str, room: str) -> None:
        """Somebody sleeps now."""
        ...

    def stirred(self, room: str) -> None:
        """Somebody set out, arrived or passed in *room*; comes after the above."""
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
