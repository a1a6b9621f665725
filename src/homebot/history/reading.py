"""The rows of the history's file: sealed for past hours and days, and read in a span of time. Blocking."""

import sqlite3
from array import array
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime, tzinfo
from itertools import groupby, pairwise
from typing import Final, NamedTuple, TypeAlias, final

from homebot.history import KeepSettings
from homebot.history.codec import (
    FIVE_MINUTES,
    HOUR,
    Batch,
    Bucket,
    StateRow,
    buckets_of,
    combined,
    decode_batch,
    decode_buckets,
    decode_values,
    encode_buckets,
    encode_values,
    wider,
)

__all__ = [
    "BITS",
    "HOURS",
    "MASK",
    "HistoryReader",
    "Numbers",
    "Span",
    "StoredStates",
    "key_of",
    "points_of",
    "read_recent",
    "seal_day",
    "seal_hours",
]

BITS: Final = 16
MASK: Final = 0xFFFF
_FIVES: Final = 12
"""Buckets of five minutes in an hour."""

HOURS: Final = 24

_Points: TypeAlias = tuple["array[int]", "array[float]"]
"""Times and values, in the order of their arrival."""

_Columns: TypeAlias = tuple["array[int]", "array[int]", "array[float]"]


def key_of(number: int, series: int) -> int:
    """Return the key of the row of *series* for the hour, day or millisecond *number*."""
    return number << BITS | series


def points_of(columns: Iterable[_Columns], wanted: Collection[int] | None = None) -> dict[int, _Points]:
    """Return the values in *columns* by series, only of those *wanted* if given."""
    found: dict[int, _Points] = {}
    for all_series, times, values in columns:
        for series, at, value in zip(all_series, times, values, strict=True):
            if wanted is not None and series not in wanted:
                continue
            points = found.get(series)
            if points is None:
                points = found[series] = array("q"), array("d")
            points[0].append(at)
            points[1].append(value)
    return found


def read_recent(connection: sqlite3.Connection) -> Iterator[_Columns]:
    """Yield the unsealed batches, oldest first."""
    for (data,) in connection.execute("SELECT d FROM recent ORDER BY t").fetchall():
        yield decode_batch(data)


def seal_hours(connection: sqlite3.Connection, found: Mapping[int, _Points], counters: Collection[int]) -> set[int]:
    """Add the values *found* to the rows of their hours, which may exist if the clock was set back; return these."""
    hours = set()
    for series, (times, values) in found.items():
        begin = 0
        for hour, group in groupby(times, lambda at: at // HOUR):
            end = begin + sum(1 for _ in group)
            _seal_hour(connection, series, hour, (times[begin:end], values[begin:end]), is_counter=series in counters)
            hours.add(hour)
            begin = end
    return hours


def _seal_hour(connection: sqlite3.Connection, series: int, hour: int, points: _Points, *, is_counter: bool) -> None:
    key, start = key_of(hour, series), hour * HOUR
    buckets = buckets_of(*points, FIVE_MINUTES, start + HOUR, is_counter=is_counter)
    times, values = points
    if raw := _read_blob(connection, "raw", key):
        before_times, before_values = decode_values(start, raw)
        times, values = before_times + times, before_values + values
        before = decode_buckets(hour * _FIVES, _read_blob(connection, "five", key) or b"")
        buckets = before | {number: combined(before.get(number), one) for number, one in buckets.items()}
    if any(after < at for at, after in pairwise(times)):
        pairs = sorted(zip(times, values, strict=True), key=lambda pair: pair[0])
        times, values = array("q", (at for at, _ in pairs)), array("d", (value for _, value in pairs))
    connection.execute("INSERT OR REPLACE INTO raw VALUES (?, ?)", (key, encode_values(start, times, values)))
    data = encode_buckets(buckets, hour * _FIVES, _FIVES)
    connection.execute("INSERT OR REPLACE INTO five VALUES (?, ?)", (key, data))


def seal_day(connection: sqlite3.Connection, day: int) -> None:
    """Write the rows of *day* from its hours; hours without five-minute buckets are left unchanged."""
    found: dict[int, dict[int, Bucket]] = {}
    bounds = key_of(day * HOURS, 0), key_of((day + 1) * HOURS, 0)
    for key, data in connection.execute("SELECT k, d FROM five WHERE k >= ? AND k < ?", bounds):
        hour = wider(decode_buckets((key >> BITS) * _FIVES, data), _FIVES)
        found.setdefault(key & MASK, {}).update(hour)
    for series, hours in found.items():
        key = key_of(day, series)
        known = _read_blob(connection, "day", key)
        if known:
            hours = decode_buckets(day * HOURS, known) | hours  # noqa: PLW2901 - the newer ones count
        data = encode_buckets(hours, day * HOURS, HOURS)
        connection.execute("INSERT OR REPLACE INTO day VALUES (?, ?)", (key, data))


def _read_blob(connection: sqlite3.Connection, table: str, key: int) -> bytes | None:
    """Return the data of a row of ``raw``, ``five`` or ``day``; None if there is none."""
    row = connection.execute(f"SELECT d FROM {table} WHERE k = ?", (key,)).fetchone()  # noqa: S608 - our own names
    return None if row is None else row[0]


_DAY: Final = HOUR * HOURS
_HOUR_SECONDS: Final = 3600
_MOST_STATES: Final = 5000


class Span(NamedTuple):
    """A span of time, in milliseconds since the Unix epoch."""

    since: int
    until: int
    points: int


class Numbers(NamedTuple):
    """The numbers of a series.

    Attributes:
        width: Milliseconds of a bucket; 0 for single values.
        times: Milliseconds since the Unix epoch: of each value, or of the start of each bucket.
        buckets: A bucket for each time; for single values, it contains only that value.
    """

    width: int
    times: list[int]
    buckets: list[Bucket]


class StoredStates(NamedTuple):
    """The words or flags of a series.

    Attributes:
        rows: The start and the row of each, oldest first.
    """

    rows: list[tuple[int, StateRow]]
    is_complete: bool


@final
@dataclass(frozen=True, slots=True)
class HistoryReader:
    """Reads the file at one moment.

    Attributes:
        now: Milliseconds since the Unix epoch.
    """

    connection: sqlite3.Connection
    waiting: Batch
    keep: KeepSettings
    counters: Collection[int]
    now: int

    def numbers(self, wanted: Collection[int], span: Span) -> dict[int, Numbers]:
        """Return the numbers of the series *wanted*, in the finest stored resolution that fits the points of *span*."""
        unsealed = self._unsealed(wanted)
        found = {}
        for series in wanted:
            numbers = self._numbers(series, span, unsealed.get(series))
            if numbers.times:
                found[series] = numbers
        return found

    def _numbers(self, series: int, span: Span, unsealed: _Points | None) -> Numbers:
        step = max((span.until - span.since) // span.points, 1)
        if span.since >= self.now - self.keep.values * 1000 and step < FIVE_MINUTES:
            times, values = self._values(series, span, unsealed)
            if len(times) <= span.points:
                return Numbers(0, times, [Bucket(one, one, one, one, 0.0, 0.0) for one in values])
            width = -(-step // 1000) * 1000
            until = min(self.now, span.until)
            return _of(buckets_of(times, values, width, until, is_counter=series in self.counters), width, span)
        if span.since >= self.now - self.keep.five_minutes * 1000 and step < HOUR:
            fives, times_as_long = self._fives(series, span, unsealed), -(-step // FIVE_MINUTES)
            return _of(wider(fives, times_as_long), times_as_long * FIVE_MINUTES, span)
        hours, times_as_long = self._hours(series, span, unsealed), -(-step // HOUR)
        return _of(wider(hours, times_as_long), times_as_long * HOUR, span)

    def _values(self, series: int, span: Span, unsealed: _Points | None) -> tuple[list[int], list[float]]:
        pairs: list[tuple[int, float]] = []
        for hour in range(span.since // HOUR, span.until // HOUR + 1):
            if data := _read_blob(self.connection, "raw", key_of(hour, series)):
                pairs += zip(*decode_values(hour * HOUR, data), strict=True)
        if unsealed is not None:
            pairs += zip(*unsealed, strict=True)
        pairs = sorted((pair for pair in pairs if span.since <= pair[0] <= span.until), key=lambda pair: pair[0])
        return [at for at, _ in pairs], [value for _, value in pairs]

    def _fives(self, series: int, span: Span, unsealed: _Points | None) -> dict[int, Bucket]:
        found: dict[int, Bucket] = {}
        for hour in range(span.since // HOUR, span.until // HOUR + 1):
            if data := _read_blob(self.connection, "five", key_of(hour, series)):
                found.update(decode_buckets(hour * _FIVES, data))
        if unsealed is not None:
            for number, bucket in self._buckets(series, unsealed).items():
                found[number] = combined(found.get(number), bucket)
        return dict(sorted(found.items()))

    def _hours(self, series: int, span: Span, unsealed: _Points | None) -> dict[int, Bucket]:
        """Return the hourly buckets, oldest first; those of unfinished days are combined from smaller ones."""
        found: dict[int, Bucket] = {}
        for day in range(span.since // _DAY, span.until // _DAY + 1):
            if data := _read_blob(self.connection, "day", key_of(day, series)):
                found.update(decode_buckets(day * HOURS, data))
            elif (day + 1) * _DAY > self.now - self.keep.five_minutes * 1000:
                whole = Span(day * _DAY, (day + 1) * _DAY - 1, 1)
                found.update(wider(self._fives(series, whole, None), _FIVES))
        if unsealed is not None:
            for number, bucket in wider(self._buckets(series, unsealed), _FIVES).items():
                found[number] = combined(found.get(number), bucket)
        return dict(sorted(found.items()))

    def rises(self, series: int, span: Span, zone: tzinfo | None) -> Iterator[tuple[int, float]]:
        """Yield the start of each bucket in which a counter rose, and the rise.

        These are hours, or five minutes if a zone is off by half an hour and these buckets are kept.
        """
        unsealed = self._unsealed({series}).get(series)
        is_whole = all(_offset(at, zone) % _HOUR_SECONDS == 0 for at in (span.since, span.until))
        is_fine = not is_whole and span.since >= self.now - self.keep.five_minutes * 1000
        read, width = (self._fives, FIVE_MINUTES) if is_fine else (self._hours, HOUR)
        for number, bucket in read(series, span, unsealed).items():
            at = number * width
            if bucket.rise and span.since <= at <= span.until:
                yield at, bucket.rise

    def states(self, series: int, span: Span) -> StoredStates:
        """Return the states in *span*, including the one at its start; only the newest if there are too many."""
        query = "SELECT k, until, value FROM state WHERE k & ? = ? AND k >= ? AND k < ? ORDER BY k DESC LIMIT ?"
        since, until = key_of(span.since, 0), key_of(span.until + 1, 0)
        limit = min(span.points, _MOST_STATES)
        rows = self.connection.execute(query, (MASK, series, since, until, limit + 1)).fetchall()
        rows += self.connection.execute(query, (MASK, series, 0, since, 1)).fetchall()
        found = {key >> BITS: StateRow(ends, value) for key, ends, value in rows}
        for (at, number), row in self.waiting.states.items():
            if number == series:
                found[at] = row
        fitting = [
            (at, row)
            for at, row in sorted(found.items())
            if at <= span.until
            and (row.until is None or row.until > max(span.since, at) or span.since <= at == row.until)
        ]
        return StoredStates(fitting[-limit:], len(fitting) <= limit)

    def _unsealed(self, wanted: Collection[int]) -> Mapping[int, _Points]:
        waiting = self.waiting
        batches = (*read_recent(self.connection), (waiting.series, waiting.times, waiting.values))
        return points_of(batches, wanted)

    def _buckets(self, series: int, points: _Points) -> dict[int, Bucket]:
        return buckets_of(*points, FIVE_MINUTES, self.now, is_counter=series in self.counters)


def _of(buckets: Mapping[int, Bucket], width: int, span: Span) -> Numbers:
    fitting = {
        number * width: one
        for number, one in buckets.items()
        if (number + 1) * width > span.since and number * width <= span.until
    }
    return Numbers(width, [*fitting], [*fitting.values()])


def _offset(at: int, zone: tzinfo | None) -> float:
    """Return the seconds by which *zone*, or the computer's if None, is ahead of UTC."""
    local = datetime.fromtimestamp(at / 1000, zone)
    offset = (local if zone is not None else local.astimezone()).utcoffset()
    return 0.0 if offset is None else offset.total_seconds()
