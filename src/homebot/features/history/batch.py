"""Values and states to be written. Pure."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

Place: TypeAlias = tuple[str, str, str]
"""The ids of a device and of its part, and a capability."""

StoredState: TypeAlias = int | str
"""A flag as 0 or 1, or a word."""


class Series(NamedTuple):
    """A value of a device that has a history."""

    number: int
    place: Place
    unit: str


class StateRow(NamedTuple):
    """A word or flag with its duration.

    Attributes:
        until: Milliseconds since the Unix epoch; None if it lasts.
    """

    until: int | None
    value: StoredState


@dataclass(slots=True, eq=False)
class Batch:
    """Values, in the order of their arrival, and states.

    Attributes:
        series: The number of the series of each value.
        times: Milliseconds since the Unix epoch.
        states: The states by start, in milliseconds since the Unix epoch, and series.
        new: Series that have no row yet.
    """

    series: array[int] = field(default_factory=lambda: array("H"))
    times: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))
    states: dict[tuple[int, int], StateRow] = field(default_factory=dict)
    new: list[Series] = field(default_factory=list)
    dropped: int = 0

    def copy(self) -> Batch:
        """Return a copy for another thread."""
        return Batch(self.series[:], self.times[:], self.values[:], dict(self.states), list(self.new), self.dropped)

    def add(self, series: int, at: int, value: float) -> None:
        """Append a value."""
        self.series.append(series)
        self.times.append(at)
        self.values.append(value)

    def drop_oldest(self, count: int) -> None:
        """Remove the first *count* values."""
        self.dropped += count
        for column in (self.series, self.times, self.values):
            del column[:count]

    def remove(self, written: Batch) -> None:
        """Remove the parts of *written*, a copy of this batch, that have not changed since."""
        left = max(len(written.times) - (self.dropped - written.dropped), 0)
        for column in (self.series, self.times, self.values):
            del column[:left]
        for key, row in written.states.items():
            if self.states.get(key) == row:
                del self.states[key]
        del self.new[: len(written.new)]
