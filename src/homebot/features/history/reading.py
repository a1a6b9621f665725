"""Reading of the history's file: values, summaries and states in a span of time. Blocking."""

import math
import sqlite3
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime, tzinfo
from typing import Final, NamedTuple, final

from homebot.features.history.batch import Batch, StateRow
from homebot.features.history.buckets import FIVE_MINUTES, HOUR, Bucket, buckets_of, combined, wider
from homebot.features.history.codec import decode_buckets, decode_values
from homebot.features.history.sealing import BITS, FIVES, HOURS, MASK, Points, key_of, points_of, read_blob, read_recent
from homebot.features.history.settings import KeepSettings

_DAY: Final = HOUR * HOURS
_HOUR_SECONDS: Final = 3600
_MAX_STATES: Final = 5000


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
        by_series = {}
        for series in wanted:
            numbers = self._numbers(series, span, unsealed.get(series))
            if numbers.times:
                by_series[series] = numbers
        return by_series

    def _numbers(self, series: int, span: Span, unsealed: Points | None) -> Numbers:
        step = max((span.until - span.since) // span.points, 1)
        if span.since >= self.now - self.keep.values * 1000 and step < FIVE_MINUTES:
            times, values = self._values(series, span, unsealed)
            if len(times) <= span.points:
                return Numbers(0, times, [Bucket(value, value, value, value, 0.0, 0.0) for value in values])
            width = -(-step // 1000) * 1000
            until = min(self.now, span.until)
            return _of(buckets_of(times, values, width, until, is_counter=series in self.counters), width, span)
        if span.since >= self.now - self.keep.five_minutes * 1000 and step < HOUR:
            fives, times_as_long = self._fives(series, span, unsealed), -(-step // FIVE_MINUTES)
            return _of(wider(fives, times_as_long), times_as_long * FIVE_MINUTES, span)
        hours, times_as_long = self._hours(series, span, unsealed), -(-step // HOUR)
        return _of(wider(hours, times_as_long), times_as_long * HOUR, span)

    def _values(self, series: int, span: Span, unsealed: Points | None) -> tuple[list[int], list[float]]:
        pairs: list[tuple[int, float]] = []
        for hour in self._kept("raw", HOUR, span):
            if data := read_blob(self.connection, "raw", key_of(hour, series)):
                pairs += zip(*decode_values(hour * HOUR, data), strict=True)
        if unsealed is not None:
            pairs += zip(*unsealed, strict=True)
        fitting = (pair for pair in pairs if span.since <= pair[0] <= span.until and not math.isnan(pair[1]))
        pairs = sorted(fitting, key=lambda pair: pair[0])
        return [at for at, _ in pairs], [value for _, value in pairs]

    def _fives(self, series: int, span: Span, unsealed: Points | None) -> dict[int, Bucket]:
        fives: dict[int, Bucket] = {}
        for hour in self._kept("five", HOUR, span):
            if data := read_blob(self.connection, "five", key_of(hour, series)):
                fives.update(decode_buckets(hour * FIVES, data))
        if unsealed is not None:
            for number, bucket in self._buckets(series, unsealed).items():
                fives[number] = combined(fives.get(number), bucket)
        return dict(sorted(fives.items()))

    def _hours(self, series: int, span: Span, unsealed: Points | None) -> dict[int, Bucket]:
        """Return the hourly buckets, oldest first; those of unfinished days are combined from smaller ones."""
        hours: dict[int, Bucket] = {}
        recent = {hour // HOURS for hour in self._kept("five", HOUR, span)}
        for day in sorted(recent.union(self._kept("day", _DAY, span))):
            if data := read_blob(self.connection, "day", key_of(day, series)):
                hours.update(decode_buckets(day * HOURS, data))
            elif (day + 1) * _DAY > self.now - self.keep.five_minutes * 1000:
                whole = Span(day * _DAY, (day + 1) * _DAY - 1, 1)
                hours.update(wider(self._fives(series, whole, None), FIVES))
        if unsealed is not None:
            for number, bucket in wider(self._buckets(series, unsealed), FIVES).items():
                hours[number] = combined(hours.get(number), bucket)
        return dict(sorted(hours.items()))

    def _kept(self, table: str, width: int, span: Span) -> range:
        """Return the numbers in *span* that rows of *table* may have, each of which is of *width* milliseconds."""
        query = f"SELECT (SELECT min(k) FROM {table}), (SELECT max(k) FROM {table})"  # noqa: S608 - our own names
        first, last = self.connection.execute(query).fetchone()
        if first is None:
            return range(0)
        return range(max(span.since // width, first >> BITS), min(span.until // width, last >> BITS) + 1)

    def rises(self, counters: Collection[int], span: Span, zone: tzinfo | None) -> Iterator[tuple[int, int, float]]:
        """Yield each counter with the start of each bucket in which it rose, and the rise.

        These are hours, or five minutes if a zone is off by half an hour and these buckets are kept.
        """
        unsealed = self._unsealed(counters)
        is_whole = all(_offset(at, zone) % _HOUR_SECONDS == 0 for at in (span.since, span.until))
        is_fine = not is_whole and span.since >= self.now - self.keep.five_minutes * 1000
        read, width = (self._fives, FIVE_MINUTES) if is_fine else (self._hours, HOUR)
        for series in counters:
            for number, bucket in read(series, span, unsealed.get(series)).items():
                at = number * width
                if bucket.rise and span.since <= at <= span.until:
                    yield series, at, bucket.rise

    def states(self, series: int, span: Span) -> StoredStates:
        """Return the states in *span*, including the one at its start; only the newest if there are too many."""
        query = "SELECT k, until, value FROM state WHERE k & ? = ? AND k >= ? AND k < ? ORDER BY k DESC LIMIT ?"
        since, until = key_of(span.since, 0), key_of(span.until + 1, 0)
        limit = min(span.points, _MAX_STATES)
        rows = self.connection.execute(query, (MASK, series, since, until, limit + 1)).fetchall()
        rows += self.connection.execute(query, (MASK, series, 0, since, 1)).fetchall()
        states = {key >> BITS: StateRow(ends, value) for key, ends, value in rows}
        for (at, number), row in self.waiting.states.items():
            if number == series:
                states[at] = row
        fitting = [
            (at, row)
            for at, row in sorted(states.items())
            if at <= span.until
            and (row.until is None or row.until > max(span.since, at) or span.since <= at == row.until)
        ]
        return StoredStates(fitting[-limit:], len(fitting) <= limit)

    def _unsealed(self, wanted: Collection[int]) -> Mapping[int, Points]:
        waiting = self.waiting
        batches = (*read_recent(self.connection), (waiting.series, waiting.times, waiting.values))
        return points_of(batches, wanted)

    def _buckets(self, series: int, points: Points) -> dict[int, Bucket]:
        return buckets_of(*points, FIVE_MINUTES, self.now, is_counter=series in self.counters)


def _of(buckets: Mapping[int, Bucket], width: int, span: Span) -> Numbers:
    fitting = {
        number * width: bucket
        for number, bucket in buckets.items()
        if (number + 1) * width > span.since and number * width <= span.until
    }
    return Numbers(width, [*fitting], [*fitting.values()])


def _offset(at: int, zone: tzinfo | None) -> float:
    """Return the seconds by which *zone*, or the computer's if None, is ahead of UTC."""
    local = datetime.fromtimestamp(at / 1000, zone)
    offset = (local if zone is not None else local.astimezone()).utcoffset()
    return 0.0 if offset is None else offset.total_seconds()
