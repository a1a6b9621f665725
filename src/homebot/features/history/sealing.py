"""Sealing of past hours and days in the history's file: the values of a series become one row. Blocking."""

import sqlite3
from array import array
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import groupby, pairwise
from typing import Final, TypeAlias

from homebot.features.history.buckets import FIVE_MINUTES, HOUR, Bucket, buckets_of, combined, wider
from homebot.features.history.codec import decode_batch, decode_buckets, decode_values, encode_buckets, encode_values

BITS: Final = 16
MASK: Final = 0xFFFF
FIVES: Final = 12
"""Buckets of five minutes in an hour."""

HOURS: Final = 24

Points: TypeAlias = tuple["array[int]", "array[float]"]
"""Times and values, in the order of their arrival."""

_Columns: TypeAlias = tuple["array[int]", "array[int]", "array[float]"]


def key_of(number: int, series: int) -> int:
    """Return the key of the row of *series* for the hour, day or millisecond *number*."""
    return number << BITS | series


def points_of(columns: Iterable[_Columns], wanted: Collection[int] | None = None) -> dict[int, Points]:
    """Return the values in *columns* by series, only of those *wanted* if given."""
    by_series: dict[int, Points] = {}
    for all_series, times, values in columns:
        for series, at, value in zip(all_series, times, values, strict=True):
            if wanted is not None and series not in wanted:
                continue
            points = by_series.get(series)
            if points is None:
                points = by_series[series] = array("q"), array("d")
            points[0].append(at)
            points[1].append(value)
    return by_series


def read_recent(connection: sqlite3.Connection) -> Iterator[_Columns]:
    """Yield the unsealed batches, oldest first."""
    for (data,) in connection.execute("SELECT d FROM recent ORDER BY t").fetchall():
        yield decode_batch(data)


def seal_hours(connection: sqlite3.Connection, found: Mapping[int, Points], counters: Collection[int]) -> set[int]:
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


def _seal_hour(connection: sqlite3.Connection, series: int, hour: int, points: Points, *, is_counter: bool) -> None:
    key, start = key_of(hour, series), hour * HOUR
    buckets = buckets_of(*points, FIVE_MINUTES, start + HOUR, is_counter=is_counter)
    times, values = points
    if raw := read_blob(connection, "raw", key):
        before_times, before_values = decode_values(start, raw)
        times, values = before_times + times, before_values + values
        before = decode_buckets(hour * FIVES, read_blob(connection, "five", key) or b"")
        buckets = before | {number: combined(before.get(number), bucket) for number, bucket in buckets.items()}
    if any(after < at for at, after in pairwise(times)):
        pairs = sorted(zip(times, values, strict=True), key=lambda pair: pair[0])
        times, values = array("q", (at for at, _ in pairs)), array("d", (value for _, value in pairs))
    connection.execute("INSERT OR REPLACE INTO raw VALUES (?, ?)", (key, encode_values(start, times, values)))
    data = encode_buckets(buckets, hour * FIVES, FIVES)
    connection.execute("INSERT OR REPLACE INTO five VALUES (?, ?)", (key, data))


def seal_day(connection: sqlite3.Connection, day: int) -> None:
    """Write the rows of *day* from its hours; hours without five-minute buckets are left unchanged."""
    by_series: dict[int, dict[int, Bucket]] = {}
    bounds = key_of(day * HOURS, 0), key_of((day + 1) * HOURS, 0)
    for key, data in connection.execute("SELECT k, d FROM five WHERE k >= ? AND k < ?", bounds):
        hour = wider(decode_buckets((key >> BITS) * FIVES, data), FIVES)
        by_series.setdefault(key & MASK, {}).update(hour)
    for series, hours in by_series.items():
        key = key_of(day, series)
        known = read_blob(connection, "day", key)
        if known:
            hours = decode_buckets(day * HOURS, known) | hours  # noqa: PLW2901 - the newer ones count
        data = encode_buckets(hours, day * HOURS, HOURS)
        connection.execute("INSERT OR REPLACE INTO day VALUES (?, ?)", (key, data))


def read_blob(connection: sqlite3.Connection, table: str, key: int) -> bytes | None:
    """Return the data of a row of ``raw``, ``five`` or ``day``; None if there is none."""
    row = connection.execute(f"SELECT d FROM {table} WHERE k = ?", (key,)).fetchone()  # noqa: S608 - our own names
    return None if row is None else row[0]
