"""Recorded days, as the search for habits reads them: changes, presses, and the conditions at each time. Pure."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Final, final

DAY: Final = 86_400.0
MIN_DAYS: Final = 5
"""Days on which people did something, for it to be a habit."""


@dataclass(frozen=True, slots=True)
class Happening:
    """One change or press.

    Attributes:
        at: In seconds since the Unix epoch.
        device: The id of its device; no habit has its cause and its action at the same device.
        what: The part and the capability; with the device, the place whose value it is.
        text: The new value as a trigger of a routine, such as ``hall motion occupied``.
        step: The deed of a person, as a step of a routine, such as ``hall lamp on``; empty if no person did it.
        is_press: Whether it is over at once, so that no place has this value later.
    """

    at: float
    device: str
    what: str
    text: str
    step: str = ""
    is_press: bool = False


@final
class Days:
    """Some days of a house.

    Args:
        events: In the order of time.
        midnight: Returns the local midnight before a time, both in seconds since the Unix epoch.
        conditions: By text of a routine's condition, whether it held at a time.
        moments: By text of a routine's trigger, such as ``sunset``, the time of that moment on the day that begins at a
            midnight; None if it has none.
        rooms: By text of a condition about a room, the devices there: it narrows only what is done with these.
    """

    def __init__(
        self,
        events: Iterable[Happening],
        midnight: Callable[[float], float],
        conditions: Mapping[str, Callable[[float], bool]],
        moments: Mapping[str, Callable[[float], float | None]],
        rooms: Mapping[str, frozenset[str]] = MappingProxyType({}),
    ) -> None:
        self.events = list(events)
        self.midnight = midnight
        self.conditions = conditions
        self.moments = moments
        self.rooms = rooms

    def recent(self, count: int) -> Days:
        """Return the last *count* days."""
        since = self.midnights[-count] if count else float("inf")
        return Days(self.between(since, float("inf")), self.midnight, self.conditions, self.moments, self.rooms)

    def until(self, at: float) -> Days:
        """Return the days before *at*."""
        return Days(self.between(float("-inf"), at), self.midnight, self.conditions, self.moments, self.rooms)

    @cached_property
    def midnights(self) -> tuple[float, ...]:
        """The beginnings of the days."""
        return tuple(sorted({self.midnight(event.at) for event in self.events}))

    @cached_property
    def by_text(self) -> Mapping[str, EventSeries]:
        """The events of each trigger."""
        kinds: defaultdict[str, EventSeries] = defaultdict(EventSeries)
        for event in self.events:
            kind = kinds[event.text]
            kind.text, kind.device, kind.what, kind.is_press = event.text, event.device, event.what, event.is_press
            kind.times.append(event.at)
            if event.step:
                kind.step = event.step
                kind.done.append(event.at)
        return dict(kinds)

    def moments_of(self, when: str) -> list[float]:
        """Return a time of day, such as ``22:40``, or a moment such as ``sunset - 5m``, on each day that has it."""
        if ":" in when:
            hours, minutes = when.split(":")
            return [midnight + int(hours) * 3600 + int(minutes) * 60 for midnight in self.midnights]
        name, sign, minutes = when.partition(" + ") if " + " in when else when.partition(" - ")
        shift = float(minutes.rstrip("m") or 0) * (-60 if "-" in sign else 60)
        return [at + shift for midnight in self.midnights if (at := self.moments[name](midnight)) is not None]

    def number(self, at: float) -> int:
        """Return the number of the day of *at*."""
        return bisect_right(self.midnights, at) - 1

    def between(self, since: float, until: float) -> list[Happening]:
        """Return the events from *since* on and before *until*."""
        return self.events[bisect_left(self._times, since) : bisect_left(self._times, until)]

    def conditions_on(self, device: str) -> Mapping[str, Callable[[float], bool]]:
        """Return the conditions that may narrow what is done with *device*."""
        return {text: holds for text, holds in self.conditions.items() if device in self.rooms.get(text, {device})}

    def is_so(self, kind: EventSeries, at: float) -> bool:
        """Return whether the place of *kind* had its value already before *at*."""
        times, texts = self._values[kind.device, kind.what]
        place = bisect_left(times, at)
        return place > 0 and texts[place - 1] == kind.text

    @cached_property
    def _times(self) -> tuple[float, ...]:
        return tuple(event.at for event in self.events)

    @cached_property
    def _values(self) -> Mapping[tuple[str, str], tuple[list[float], list[str]]]:
        values: defaultdict[tuple[str, str], tuple[list[float], list[str]]] = defaultdict(lambda: ([], []))
        for event in self.events:
            times, texts = values[event.device, event.what]
            times.append(event.at)
            texts.append("" if event.is_press else event.text)
        return dict(values)


@dataclass(slots=True)
class EventSeries:
    """All events with the same text.

    Attributes:
        done: The times at which a person did it.
        is_press: Whether it is over at once.
    """

    text: str = ""
    device: str = ""
    what: str = ""
    step: str = ""
    times: list[float] = field(default_factory=list)
    done: list[float] = field(default_factory=list)
    is_press: bool = False

    def first(self, since: float, until: float) -> float | None:
        """Return when a person first did it in a span; None for never."""
        place = bisect_right(self.done, since)
        return self.done[place] if place < len(self.done) and self.done[place] <= until else None
