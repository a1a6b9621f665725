"""A correction of stored numbers: those of one series in a span of time are dropped, or replaced by one. Blocking."""

import sqlite3
from array import array
from collections.abc import Mapping
from typing import Final, NamedTuple

from homebot.features.history.buckets import FIVE_MINUTES, HOUR, Bucket, buckets_of, wider
from homebot.features.history.codec import (
    decode_batch,
    decode_buckets,
    decode_values,
    encode_batch,
    encode_buckets,
    encode_values,
)
from homebot.features.history.sealing import BITS, FIVES, HOURS, MASK, Points, key_of, read_blob

_DAY: Final = HOUR * HOURS


class Correction(NamedTuple):
    """The numbers to correct.

    Attributes:
        series: The number of the series.
        since: The first millisecond since the Unix epoch.
        until: The millisecond after the last one.
        value: In place of the numbers; None to drop them.
    """

    series: int
    since: int
    until: int
    value: float | None

    def points(self, times: "array[int]", values: "array[float]") -> tuple[Points, int]:
        """Return the points that are left, and the number of those that change."""
        kept, count = (array("q"), array("d")), 0
        for at, value in zip(times, values, strict=True):
            is_meant = self.since <= at < self.until
            count += is_meant
            if not is_meant or self.value is not None:
                kept[0].append(at)
                kept[1].append(self.value if is_meant and self.value is not None else value)
        return kept, count

    def buckets(self, known: Mapping[int, Bucket], width: int) -> dict[int, Bucket]:
        """Return *known*, of which only those that lie wholly in the span change."""
        new = None if self.value is None else Bucket(self.value, self.value, self.value, self.value, width / 1000, 0.0)
        corrected: dict[int, Bucket] = {}
        for number, bucket in known.items():
            is_meant = self.since <= number * width and (number + 1) * width <= self.until
            if (kept := new if is_meant else bucket) is not None:
                corrected[number] = kept
        return corrected


def correct(connection: sqlite3.Connection, one: Correction, *, is_counter: bool) -> int:
    """Correct the rows of a series; return the number of values and summaries that changed.

    Single values are corrected to the millisecond, and their summaries anew from them. Where only summaries are left,
    those that lie wholly in the span are corrected.
    """
    count = _correct_recent(connection, one)
    for hour in sorted({*_rows(connection, "raw", one, HOUR), *_rows(connection, "five", one, HOUR)}):
        count += _correct_hour(connection, one, hour, is_counter=is_counter)
    for day in _rows(connection, "day", one, _DAY):
        count += _correct_day(connection, one, day)
    return count


def _rows(connection: sqlite3.Connection, table: str, one: Correction, width: int) -> list[int]:
    bounds = key_of(one.since // width, 0), key_of((one.until - 1) // width + 1, 0)
    keys = connection.execute(f"SELECT k FROM {table} WHERE k >= ? AND k < ?", bounds)  # noqa: S608 - our own names
    return [key >> BITS for (key,) in keys.fetchall() if key & MASK == one.series]


def _correct_recent(connection: sqlite3.Connection, one: Correction) -> int:
    count = 0
    for at, data in connection.execute("SELECT t, d FROM recent").fetchall():
        series, times, values = decode_batch(data)
        meant = [number == one.series and one.since <= at < one.until for number, at in zip(series, times, strict=True)]
        if not any(meant):
            continue
        count += sum(meant)
        new = one.value
        rows = [
            (number, moment, value if not is_meant or new is None else new)
            for number, moment, value, is_meant in zip(series, times, values, meant, strict=True)
            if not is_meant or new is not None
        ]
        numbers, moments, kept = zip(*rows, strict=True) if rows else ((), (), ())
        corrected = encode_batch(array("H", numbers), array("q", moments), array("d", kept))
        connection.execute("UPDATE recent SET d = ? WHERE t = ?", (corrected, at))
    return count


def _correct_hour(connection: sqlite3.Connection, one: Correction, hour: int, *, is_counter: bool) -> int:
    key, start = key_of(hour, one.series), hour * HOUR
    before = decode_buckets(hour * FIVES, read_blob(connection, "five", key) or b"")
    if raw := read_blob(connection, "raw", key):
        (times, values), count = one.points(*decode_values(start, raw))
        if not count:
            return 0
        _write(connection, "raw", key, encode_values(start, times, values) if times else b"")
        buckets = buckets_of(times, values, FIVE_MINUTES, start + HOUR, is_counter=is_counter)
    else:
        buckets = one.buckets(before, FIVE_MINUTES)
        count = sum(buckets.get(number) != bucket for number, bucket in before.items())
    _write(connection, "five", key, encode_buckets(buckets, hour * FIVES, FIVES) if buckets else b"")
    return count


def _correct_day(connection: sqlite3.Connection, one: Correction, day: int) -> int:
    """Correct the hours of a day; those that still have five-minute buckets were counted with these."""
    key = key_of(day, one.series)
    before = decode_buckets(day * HOURS, read_blob(connection, "day", key) or b"")
    after = one.buckets(before, HOUR)
    count = sum(after.get(hour) != bucket for hour, bucket in before.items())
    for hour in before:
        if one.since < (hour + 1) * HOUR and hour * HOUR < one.until:
            fives = read_blob(connection, "five", key_of(hour, one.series))
            after |= wider(decode_buckets(hour * FIVES, fives), FIVES) if fives else {}
    _write(connection, "day", key, encode_buckets(after, day * HOURS, HOURS) if after else b"")
    return count


def _write(connection: sqlite3.Connection, table: str, key: int, data: bytes) -> None:
    if data:
        connection.execute(f"INSERT OR REPLACE INTO {table} VALUES (?, ?)", (key, data))  # noqa: S608 - as above
    else:
        connection.execute(f"DELETE FROM {table} WHERE k = ?", (key,))  # noqa: S608 - as above
