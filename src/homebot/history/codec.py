"""Values to be written, summaries of numbers over equal spans of time, and numbers as bytes. Pure.

The bytes are columns of machine numbers, with bytes of equal significance grouped, at level 1 of zlib: neighbours are
similar in most bytes, so each takes only a few bits. The first byte is the version of the format.
"""

from __future__ import annotations

import math
import sys
import zlib
from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Any, Final, NamedTuple, TypeAlias

from homebot.errors import WireError

__all__ = [
    "COUNTERS",
    "FIVE_MINUTES",
    "HOUR",
    "Batch",
    "Bucket",
    "Place",
    "Series",
    "StateRow",
    "StoredState",
    "buckets_of",
    "combined",
    "decode_batch",
    "decode_buckets",
    "decode_values",
    "encode_batch",
    "encode_buckets",
    "encode_values",
    "wider",
]

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


FIVE_MINUTES: Final = 300_000
HOUR: Final = 3_600_000
"""Milliseconds."""

COUNTERS: Final = frozenset({"energy", "energy_returned"})
"""Capabilities that only grow, except for resets."""


class Bucket(NamedTuple):
    """The summary of the values in one span of time.

    Attributes:
        mean: The mean, weighted by the duration of each value.
        seconds: The time for which a value was known.
        rise: The sum of the positive steps of a counter; 0 for other numbers.
    """

    low: float
    high: float
    mean: float
    last: float
    seconds: float
    rise: float


def buckets_of(
    times: Sequence[int], values: Sequence[float], width: int, until: int, *, is_counter: bool
) -> dict[int, Bucket]:
    """Return the buckets of *values* by number, ``time // width``; there are none without values.

    Args:
        times: Milliseconds since the Unix epoch, in the order of arrival; they may go back if the clock was set.
        values: The value at each time; it lasts until the next one, and no longer than its bucket.
        width: Width of a bucket, in milliseconds.
    """
    sums: dict[int, list[float]] = {}
    before = values[0] if values else 0.0
    for at, value, after in zip(times, values, (*times[1:], until), strict=True):
        number = at // width
        end = min((number + 1) * width, max(until, at))
        lasted = max((after if at <= after < end else end) - at, 1)
        step = value - before
        before = value
        rise = step if is_counter and step > 0 else 0.0
        known = sums.get(number)
        if known is None:
            sums[number] = [value, value, value * lasted, value, lasted, rise]
            continue
        if value < known[0]:
            known[0] = value
        if value > known[1]:
            known[1] = value
        known[2] += value * lasted
        known[3] = value
        known[4] += lasted
        known[5] += rise
    return {
        number: Bucket(low, high, min(max(area / lasted, low), high), last, lasted / 1000, rise)
        for number, (low, high, area, last, lasted, rise) in sums.items()
    }


def combined(first: Bucket | None, second: Bucket) -> Bucket:
    """Return the summary of both; *second* is the later one."""
    if first is None:
        return second
    seconds = first.seconds + second.seconds
    mean = (first.mean * first.seconds + second.mean * second.seconds) / seconds
    low, high = min(first.low, second.low), max(first.high, second.high)
    return Bucket(low, high, min(max(mean, low), high), second.last, seconds, first.rise + second.rise)


def wider(buckets: Mapping[int, Bucket] | Iterable[tuple[int, Bucket]], times: int) -> dict[int, Bucket]:
    """Return *buckets*, oldest first, each combined from *times* buckets."""
    found: dict[int, Bucket] = {}
    for number, bucket in buckets.items() if isinstance(buckets, Mapping) else buckets:
        found[number // times] = combined(found.get(number // times), bucket)
    return found


_VERSION: Final = b"\x01"
_LEVEL: Final = 1
_COLUMNS: Final = "ddfdff"
"""The type codes of the columns of buckets: a mean needs no more digits."""

_NONE: Final = Bucket(math.nan, math.nan, math.nan, math.nan, 0.0, 0.0)


def encode_values(start: int, times: Sequence[int], values: Sequence[float]) -> bytes:
    """Return *values* and their non-decreasing *times*, in milliseconds since *start*, as bytes."""
    steps = (after - before for before, after in zip((start, *times[:-1]), times, strict=True))
    return _pack(array("I", steps), array("d", values))


def decode_values(start: int, data: bytes) -> tuple[array[int], array[float]]:
    """Return the times and values in *data*.

    Raises:
        WireError: *data* is not from :func:`encode_values`.
    """
    steps, values = _unpack(data, "Id")
    return array("q", list(accumulate(steps, initial=start))[1:]), values


def encode_buckets(buckets: Mapping[int, Bucket], first: int, count: int) -> bytes:
    """Return the *buckets* from number *first* on, up to *count*, as bytes; some may be missing."""
    rows = [buckets.get(number, _NONE) for number in range(first, first + count)]
    return _pack(*(array(letter, column) for letter, column in zip(_COLUMNS, zip(*rows, strict=True), strict=True)))


def decode_buckets(first: int, data: bytes) -> dict[int, Bucket]:
    """Return the buckets in *data*; the first one has the number *first*.

    Raises:
        WireError: *data* is not from :func:`encode_buckets`.
    """
    columns = _unpack(data, _COLUMNS)
    rows = map(Bucket._make, zip(*columns, strict=True))
    return {number: row for number, row in enumerate(rows, first) if row.seconds > 0}


def encode_batch(series: array[int], times: array[int], values: array[float]) -> bytes:
    """Return values of several *series*, with their times in milliseconds since the Unix epoch, as bytes."""
    return _pack(series, times, values)


def decode_batch(data: bytes) -> tuple[array[int], array[int], array[float]]:
    """Return series, times and values in *data*.

    Raises:
        WireError: *data* is not from :func:`encode_batch`.
    """
    series, times, values = _unpack(data, "Hqd")
    return series, times, values


def _pack(*columns: array[Any]) -> bytes:
    found = []
    for column in columns:
        size, data = column.itemsize, _little(column).tobytes()
        found += [data[place::size] for place in range(size)]
    return _VERSION + zlib.compress(b"".join(found), _LEVEL)


def _unpack(data: bytes, letters: str) -> list[Any]:
    sizes = [array(letter).itemsize for letter in letters]
    try:
        plain = zlib.decompress(data[1:]) if data[:1] == _VERSION else b"?"
    except zlib.error:
        plain = b"?"
    count, rest = divmod(len(plain), sum(sizes))
    if rest:
        raise WireError("the numbers of the history cannot be read", data[:20])
    found: list[Any] = []
    begin = 0
    for letter, size in zip(letters, sizes, strict=True):
        mixed = bytearray(count * size)
        for place in range(size):
            mixed[place::size] = plain[begin : begin + count]
            begin += count
        column: array[Any] = array(letter)
        column.frombytes(bytes(mixed))
        found.append(_little(column))
    return found


def _little(column: array[Any]) -> array[Any]:
    """Return *column* with swapped bytes if this computer is big-endian."""
    if sys.byteorder == "big":
        column = column[:]
        column.byteswap()
    return column
