"""The history's file: an SQLite database, written in order of time by one worker thread at a time.

Each changed page is written twice, so a row per value would wear out an SD card: the values of a series become one row
an hour.
"""

import sqlite3
from array import array
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple, TypeVar, final

from anyio import to_thread

from homebot.errors import HomebotError, LinkError
from homebot.features.history.batch import Batch, Place, Series
from homebot.features.history.buckets import COUNTERS, HOUR
from homebot.features.history.codec import decode_values, encode_batch
from homebot.features.history.collector import Collector
from homebot.features.history.correction import Correction, correct
from homebot.features.history.reading import HistoryReader
from homebot.features.history.sealing import BITS, HOURS, MASK, key_of, points_of, read_recent, seal_day, seal_hours
from homebot.features.history.settings import HistorySettings, KeepSettings
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.support.managed_file import ManagedFile
from homebot.support.sqlite_file import IN_MEMORY, SqliteFile, SqliteSchema

HISTORY_SCHEMA: Final = SqliteSchema(
    "history",
    1,
    (
        "CREATE TABLE series (s INTEGER PRIMARY KEY, device TEXT NOT NULL, part TEXT NOT NULL, "
        "capability TEXT NOT NULL, unit TEXT NOT NULL, UNIQUE (device, part, capability))",
        # One row per batch of all series, until the hour is sealed: a kill loses at most one batch.
        "CREATE TABLE recent (t INTEGER PRIMARY KEY, d BLOB NOT NULL)",
        # Keys are time << 16 | series: rows are added at the right edge, and old ones are removed at the left.
        "CREATE TABLE raw (k INTEGER PRIMARY KEY, d BLOB NOT NULL)",
        "CREATE TABLE five (k INTEGER PRIMARY KEY, d BLOB NOT NULL)",
        "CREATE TABLE day (k INTEGER PRIMARY KEY, d BLOB NOT NULL)",
        "CREATE TABLE state (k INTEGER PRIMARY KEY, until INTEGER, value NOT NULL)",
    ),
    (
        "SELECT s, device, part, capability, unit FROM series LIMIT 1",
        "SELECT t, d FROM recent LIMIT 1",
        *(f"SELECT k, d FROM {table} LIMIT 1" for table in ("raw", "five", "day")),  # noqa: S608 - our own names
        "SELECT k, until, value FROM state LIMIT 1",
    ),
    page_size=1024,  # each change writes whole pages: a third less than with 4 KiB
    shrinks=True,
)
_UPSERT_STATE: Final = "INSERT INTO state VALUES (?, ?, ?) ON CONFLICT (k) DO UPDATE SET until = ?2, value = ?3"
_FREE_SHARE: Final = 4
"""A file is shrunk if a quarter of it is unused."""


T = TypeVar("T")


class StoredSeries(NamedTuple):
    """The series of a file.

    Attributes:
        last: The last value of each counter in recent days, by the number of its series.
    """

    series: Mapping[Place, Series]
    last: Mapping[int, float]


@final
class HistoryFile(SqliteFile):
    """Reads and writes the file."""

    def __init__(self, path: Path | None, keep: KeepSettings) -> None:
        super().__init__(path or IN_MEMORY, HISTORY_SCHEMA)
        self._keep = keep
        self._counters: set[int] = set()
        self._recent_hour: int | None = None
        self._open_days: set[int] = set()

    def open(self, now: float) -> Path | None:
        """Open the file; see :meth:`.SqliteFile.open`."""
        self._counters, self._recent_hour, self._open_days = set(), None, set()
        return super().open(now)

    @property
    def connection(self) -> sqlite3.Connection:
        """The open connection.

        Raises:
            LinkError: It is not open.
        """
        return self._opened()

    def read(self, work: Callable[[sqlite3.Connection], T]) -> T:
        """Return the result of *work*, which reads.

        Raises:
            LinkError: It cannot be read now.
            WireError: The file is damaged.
        """
        with self._used("read") as connection:
            return work(connection)

    def load(self) -> StoredSeries:
        """Return the series; states that lasted when homebot was killed end with its last batch.

        Raises:
            LinkError: It cannot be read now.
            WireError: The file is damaged.
        """
        with self._used("read") as connection:
            rows = connection.execute("SELECT s, device, part, capability, unit FROM series").fetchall()
            series = {(row[1], row[2], row[3]): Series(row[0], (row[1], row[2], row[3]), row[4]) for row in rows}
            self._counters = {stored.number for place, stored in series.items() if place[2] in COUNTERS}
            newest = connection.execute("SELECT max(t) FROM recent").fetchone()[0]
            self._recent_hour = None if newest is None else newest // HOUR
            (five,) = connection.execute("SELECT max(k) FROM five").fetchone()
            self._open_days = set() if five is None else {(five >> BITS) // HOURS}
            self._close_states(newest, five)
            return StoredSeries(series, self._last_of_counters())

    def write(self, batch: Batch, now: int) -> None:
        """Write *batch* in one transaction; seal the hours and days that are over, and drop old rows.

        Args:
            now: Milliseconds since the Unix epoch.

        Raises:
            LinkError: It cannot be written now; nothing was written.
            WireError: The file is damaged; nothing was written.
        """
        state = self._recent_hour, set(self._open_days)
        try:
            with self._used("written") as connection:
                with connection:
                    new = [(series.number, *series.place, series.unit) for series in batch.new]
                    connection.executemany("INSERT OR IGNORE INTO series VALUES (?, ?, ?, ?, ?)", new)
                    self._counters.update(series.number for series in batch.new if series.place[2] in COUNTERS)
                    rows = [(key_of(at, series), row.until, row.value) for (at, series), row in batch.states.items()]
                    connection.executemany(_UPSERT_STATE, rows)
                    is_over = self._write_values(batch, now)
                if is_over:
                    self._shrink()
        except HomebotError:
            self._recent_hour, self._open_days = state
            raise

    def correct(self, correction: Correction) -> tuple[int, float | None]:
        """Correct numbers in one transaction; return how many, and the last value of the series if it is a counter.

        Raises:
            LinkError: It cannot be written now; nothing was changed.
            WireError: The file is damaged; nothing was changed.
        """
        with self._used("written") as connection, connection:
            count = correct(connection, correction, is_counter=correction.series in self._counters)
            return count, self._last_of_counters().get(correction.series)

    def _write_values(self, batch: Batch, now: int) -> bool:
        """Write the values of this hour, and seal earlier ones; return whether a day is over."""
        connection, hour = self._opened(), now // HOUR
        is_past = self._recent_hour is not None and self._recent_hour != hour
        columns = list(read_recent(connection)) if is_past else []
        past, present = _split(batch, hour)
        if sum(len(column[0]) for column in (*columns, past)):
            sealed = seal_hours(connection, points_of((*columns, past)), self._counters)
            self._open_days |= {hour // HOURS for hour in sealed}
        if is_past:
            connection.execute("DELETE FROM recent")
            self._drop_old(now)
        over = {day for day in self._open_days if day < hour // HOURS}
        for day in sorted(over):
            seal_day(connection, day)
        self._open_days -= over
        (newest,) = connection.execute("SELECT max(t) FROM recent").fetchone()
        connection.execute("INSERT INTO recent VALUES (?, ?)", (max(now, (newest or 0) + 1), encode_batch(*present)))
        self._recent_hour = hour
        return bool(over)

    def _drop_old(self, now: int) -> None:
        connection, keep = self._opened(), self._keep
        for table, seconds in (("raw", keep.values), ("five", keep.five_minutes)):
            oldest = key_of(max(now - round(seconds * 1000), 0) // HOUR, 0)
            connection.execute(f"DELETE FROM {table} WHERE k < ?", (oldest,))  # noqa: S608 - as above
        since = max(now - round(keep.states * 1000), 0)
        connection.execute("DELETE FROM state WHERE k < ? AND until < ?", (key_of(since, 0), since))

    def _shrink(self) -> None:
        connection = self._opened()
        free, pages = (
            connection.execute(f"PRAGMA {pragma}").fetchone()[0] for pragma in ("freelist_count", "page_count")
        )
        if free * _FREE_SHARE > pages:
            connection.execute("PRAGMA incremental_vacuum").fetchall()

    def _close_states(self, recent: int | None, five: int | None) -> None:
        connection = self._opened()
        (state,) = connection.execute("SELECT max(k) FROM state").fetchone()
        seen = max(recent or 0, 0 if five is None else ((five >> BITS) + 1) * HOUR, (state or 0) >> BITS)
        with connection:
            connection.execute("UPDATE state SET until = max(?, k >> ?) WHERE until IS NULL", (seen, BITS))

    def _last_of_counters(self) -> dict[int, float]:
        """Return the last value of each counter among the single values that are kept."""
        last = {
            series: values[-1] for series, (_, values) in points_of(read_recent(self._opened()), self._counters).items()
        }
        for key, data in self._opened().execute("SELECT k, d FROM raw ORDER BY k DESC"):
            if len(last) == len(self._counters):
                break
            if (series := key & MASK) in self._counters and series not in last:
                last[series] = decode_values((key >> BITS) * HOUR, data)[1][-1]
        return last


_Columns = tuple["array[int]", "array[int]", "array[float]"]


def _split(batch: Batch, hour: int) -> tuple[_Columns, _Columns]:
    if all(at // HOUR == hour for at in (min(batch.times, default=hour * HOUR), max(batch.times, default=hour * HOUR))):
        return (array("H"), array("q"), array("d")), (batch.series, batch.times, batch.values)
    past, present = Batch(), Batch()
    for series, at, value in zip(batch.series, batch.times, batch.values, strict=True):
        (present if at // HOUR == hour else past).add(series, at, value)
    return (past.series, past.times, past.values), (present.series, present.times, present.values)


@final
class HistoryStore:
    """The file and its use."""

    def __init__(self, node: Node, path: Path | None, settings: HistorySettings) -> None:
        self._clock = clock = node.graph.clock
        self._settings = settings
        self.file = HistoryFile(path, settings.keep)
        self.kept = ManagedFile(
            self.file, "the history", "no history is kept", node.log, clock.now, LogLimit(clock).allows, self._renew
        )
        self._is_new = False

    async def open(self) -> StoredSeries | None:
        """Return the series of the file; None if it cannot be used now."""
        with suppress(LinkError):
            async with self.kept.opened(writes=True) as file:
                return await to_thread.run_sync(file.load)
        return None

    async def write(self, collector: Collector) -> None:
        """Write the batch of *collector*; data that cannot be written now stays there."""
        with suppress(LinkError):
            async with self.kept.opened(writes=True) as file:
                if self._is_new:
                    collector.renew()
                    self._is_new = False
                batch = collector.batch.copy()
                await to_thread.run_sync(file.write, batch, round(self._clock.now() * 1000))
                collector.batch.remove(batch)

    async def correct(self, collector: Collector, correction: Correction) -> int:
        """Correct numbers in the file, after writing those that wait; return how many.

        Raises:
            LinkError: The file cannot be written now.
        """
        await self.write(collector)
        async with self.kept.opened(writes=True) as file:
            count, last = await to_thread.run_sync(file.correct, correction)
        collector.restart_total(correction.series, last)
        return count

    async def read(self, collector: Collector, work: Callable[[HistoryReader], T]) -> T:
        """Return the result of *work*, in a thread.

        Raises:
            LinkError: The file cannot be read now.
        """
        async with self.kept.opened() as file:
            batch, now = collector.batch.copy(), round(self._clock.now() * 1000)
            keep, counters = self._settings.keep, collector.counters
            return await to_thread.run_sync(
                file.read, lambda connection: work(HistoryReader(connection, batch, keep, counters, now))
            )

    def _renew(self) -> None:
        self._is_new = True
