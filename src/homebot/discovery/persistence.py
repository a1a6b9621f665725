"""The task that reads the index file at the start, and writes changes every few seconds.

SQLite runs in a worker thread. Without a file nothing happens.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import anyio
from anyio import to_thread

from homebot.clock import TimeSlice
from homebot.devices.health import Count
from homebot.devices.services import IndexRow, IndexTable
from homebot.discovery.entry import Entry
from homebot.discovery.ids import Tombstone
from homebot.discovery.index import DeviceIndex
from homebot.discovery.merging.decisions import MergeDecisions
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.record import Records, entry_record, read_entry, read_tombstone, tombstone_record
from homebot.errors import LinkError, UsageError, WireError
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.support.counters import Severity
from homebot.support.managed_file import ManagedFile

if TYPE_CHECKING:
    from homebot.discovery.store import IndexFile

T = TypeVar("T")

LOADED = "discovery.index_file_loaded"
BAD_RECORD = "discovery.index_record_rejected"

SAVE_EVERY = 2.0
"""Seconds for which changes are collected before they are written."""

RETRY_AFTER = 5.0
"""Seconds until another attempt after a failed write."""

DECISIONS = "merging"
PLACES = "places"
"""The owner's records: which announcements are one device, and statements about devices. Features have others."""

_BATCH = 200
"""Most devices written in one transaction."""

_LAST_CHANCE = 5.0


@dataclass(slots=True)
class OwnerText:
    """A record of the owner whose content is for another part of homebot."""

    text: str = ""
    is_unsaved: bool = False

    def record(self) -> str:
        """Return the text."""
        return self.text

    def restore(self, record: str) -> None:
        """Set the text."""
        self.text = record


class IndexPersistence:
    """Keeps the index file.

    Args:
        known: The known devices if there is no file, as from a recording.

    Attributes:
        file: The path of the file; empty for none.
    """

    def __init__(self, node: Node, index: DeviceIndex, path: Path | None, known: Sequence[IndexRow] = ()) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._index = index
        self._known = known
        self._limit = LogLimit(self._clock)
        self._rejected = 0
        self.file = str(path or "")
        self._kept = None if path is None else self._saved_file(path)
        self._owner: dict[str, MergeDecisions | OwnerFacts | OwnerText] = {
            DECISIONS: index.decisions,
            PLACES: index.owner,
        }
        index.table.is_saved = path is not None

    def record_for(self, feature: str) -> OwnerText:
        """Return the owner's record for a feature.

        Raises:
            UsageError: The directory has a record of its own of that name.
        """
        record = self._owner.setdefault(feature, OwnerText())
        if not isinstance(record, OwnerText):
            raise UsageError(f"{feature} is a record of the directory's own")
        return record

    @property
    def problem(self) -> str:
        """The problem with the file, in words; empty for none."""
        return "" if self._kept is None else self._kept.trouble

    def counts(self) -> tuple[Count, ...]:
        """Return how often writing the file or a record failed."""
        failures = 0 if self._kept is None else self._kept.failures
        return (Count(name="index_file_failures", count=failures + self._rejected, severity=Severity.LOSS),)

    async def load(self) -> None:
        """Load the content of the file as unconfirmed; an unusable file is set aside."""
        if self._kept is None:
            tables: dict[str, list[tuple[str, str]]] = {}
            for row in self._known:
                tables.setdefault(row.table, []).append((row.id, row.record))
            await self._restore_entries(
                _understood(Records(*(tuple(tables.get(name, ())) for name in ("devices", "tombstones", "owner"))))
            )
            return
        try:
            async with self._kept.opened() as file:
                # in a worker thread, as 10,000 devices take a second
                known = await to_thread.run_sync(lambda: _understood(file.read()))
        except LinkError:
            return
        await self._restore_entries(known)

    async def export(self) -> tuple[IndexRow, ...]:
        """Return the content that the file would have now, whether or not there is one."""
        records = await self._records(self._index.ids)
        owner = tuple((name, record) for name, statements in self._owner.items() if (record := statements.record()))
        tables: tuple[tuple[IndexTable, tuple[tuple[str, str], ...]], ...] = (
            ("devices", records.devices),
            ("tombstones", records.tombstones),
            ("owner", owner),
        )
        return tuple(IndexRow(table=table, id=name, record=text) for table, rows in tables for name, text in rows)

    async def _restore_entries(self, known: _SavedState) -> None:
        for tombstone in known.tombstones:
            self._index.tombstones.put(tombstone)
        rejected = known.rejected + self._restore_owner(known.owner)
        now, wall = self._clock.monotonic(), self._clock.now()
        work = TimeSlice(self._clock)
        for entry in known.entries:
            self._index.restore(entry, now, wall)
            if work.is_over:
                await work.pause()
        self._index.table.unsaved.clear()
        if rejected:
            self._node.log.warning(BAD_RECORD, message=f"{rejected} records of {self.file} could not be read")
        if known.entries:
            self._node.log.info(
                LOADED, message=f"devices known from the last run: {len(known.entries)}", file=self.file
            )

    def _restore_owner(self, records: Mapping[str, str]) -> int:
        """Restore the owner's decisions; return how many records could not be read."""
        rejected = 0
        for name in records.keys() - self._owner.keys():
            self._owner[name] = OwnerText()  # kept, even if the feature was taken out
        for name, owner in self._owner.items():
            try:
                if (record := records.get(name)) is not None:
                    owner.restore(record)
            except WireError as exc:
                rejected += 1
                self._node.log.warning(BAD_RECORD, message=f"the record {name!r} in {self.file}: {exc}")
        return rejected

    def _save_all(self) -> None:
        """Mark everything as unsaved."""
        self._index.table.mark_all_unsaved()
        for owner in self._owner.values():
            owner.is_unsaved = True

    async def run(self) -> None:
        """Write the changes until cancelled, then once more."""
        if self._kept is None:
            await anyio.sleep_forever()
            return
        try:
            while True:
                await anyio.sleep(RETRY_AFTER if self._kept.problem else SAVE_EVERY)
                await self._save(self._kept)
        finally:
            with anyio.move_on_after(_LAST_CHANCE, shield=True):
                await self._save(self._kept)
                await self._kept.close()

    async def save_now(self) -> str:
        """Write the owner's decisions now; return why they could not be saved, empty if they were."""
        kept = self._kept
        if kept is None:
            return ""
        with suppress(LinkError):
            async with kept.opened(writes=True) as file:
                await self._save_batch(file)
        return kept.problem

    async def _save(self, kept: ManagedFile[IndexFile]) -> None:
        with suppress(LinkError):
            while self._is_unsaved and not kept.is_unusable:
                async with kept.opened(writes=True) as file:
                    await self._save_batch(file)

    async def _save_batch(self, file: IndexFile) -> None:
        """Write some unsaved devices, and the unsaved records of the owner."""
        batch = tuple(islice(self._index.table.unsaved, _BATCH))
        for device_id in batch:
            del self._index.table.unsaved[device_id]
        unsaved = [name for name, owner in self._owner.items() if owner.is_unsaved]
        for name in unsaved:
            self._owner[name].is_unsaved = False
        try:
            records = await self._records(batch)
            records = records._replace(owner=tuple((name, self._owner[name].record()) for name in unsaved))
            await to_thread.run_sync(file.write, records, batch)
        except BaseException:
            self._index.table.unsaved.update(dict.fromkeys(batch))
            for name in unsaved:
                self._owner[name].is_unsaved = True
            raise

    @property
    def _is_unsaved(self) -> bool:
        return bool(self._index.table.unsaved) or any(owner.is_unsaved for owner in self._owner.values())

    async def _records(self, batch: tuple[str, ...]) -> Records:
        """Return the records; a device that changes during a pause is written again in the next batch."""
        devices: list[tuple[str, str]] = []
        stones: list[tuple[str, str]] = []
        work = TimeSlice(self._clock)
        for device_id in batch:
            if (row := self._row(device_id)) is not None:
                devices.append(row)
            if (tombstone := self._index.tombstones.by_id.get(device_id)) is not None:
                stones.append((tombstone.id, tombstone_record(tombstone)))
            if work.is_over:
                await work.pause()
        return Records(tuple(devices), tuple(stones))

    def _row(self, device_id: str) -> tuple[str, str] | None:
        entry = self._index.entry(device_id)
        try:
            return None if entry is None else (device_id, entry_record(entry))
        except WireError as exc:
            self._rejected += 1
            if self._limit.allows(BAD_RECORD) is not None:
                self._node.log.warning(BAD_RECORD, message=f"a device is not remembered: {exc}")
            return None

    def _saved_file(self, path: Path) -> ManagedFile[IndexFile]:
        from homebot.discovery.store import IndexFile  # noqa: PLC0415 - SQLite is loaded where something is kept

        return ManagedFile(
            IndexFile(path),
            "the index file",
            "devices are not remembered",
            self._node.log,
            self._clock.now,
            self._limit.allows,
            on_new=self._save_all,
            on_end=self._end,
        )

    def _end(self) -> None:
        self._index.table.is_saved = False


class _SavedState(NamedTuple):
    """The content of the file; the devices oldest first."""

    entries: tuple[Entry, ...]
    tombstones: tuple[Tombstone, ...]
    owner: Mapping[str, str]
    rejected: int


def _understood(records: Records) -> _SavedState:
    entries, tombstones = _read_each(records.devices, read_entry), _read_each(records.tombstones, read_tombstone)
    rejected = len(records.devices) + len(records.tombstones) - len(entries) - len(tombstones)
    entries.sort(key=lambda entry: (entry.first_seen.sec, entry.first_seen.nanosec, entry.id))
    tombstones.sort(key=lambda tombstone: (tombstone.at, tombstone.id))
    return _SavedState(tuple(entries), tuple(tombstones), dict(records.owner), rejected)


def _read_each(rows: Iterable[tuple[str, str]], read: Callable[[str, str], T]) -> list[T]:
    entries = []
    for device_id, text in rows:
        with suppress(WireError):
            entries.append(read(device_id, text))
    return entries
