"""Knowledge that survives a restart, in the journal's store: its newest entries, records, the profile of each part."""

import json
from collections.abc import Callable, Iterable
from functools import cache, partial
from typing import Final, Literal, TypeAlias, final

import anyio
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from homebot.control import durations
from homebot.control.timeline.profile import DeviceProfile
from homebot.devices.journal_messages import JournalEntry, ReadJournalRequest
from homebot.errors import WireError
from homebot.graph import Node
from homebot.journal.store import JournalStore, LearntRow
from homebot.messages import Time
from homebot.support.bounded_map import BoundedMap

SaveRecord: TypeAlias = Callable[[str, str], None]
"""Saves a record across restarts: its name, and the record, empty to remove it."""

RestoreRecord: TypeAlias = Callable[[str, str], None]
"""Restores a record of an earlier run; raises `WireError` if it is unreadable or of another version."""

PROFILE: Final = "profile"
"""The kind of the profiles."""

KINDS: Final = frozenset({"detection", PROFILE})
"""The kinds of this version; other rows are dropped."""

LOADED: Final = "control.learnt_loaded"
DROPPED: Final = "control.learnt_dropped"
LATE: Final = "control.learnt_late"

_MAX_NAME_CHARACTERS: Final = 100
_MAX_PROFILES: Final = 10_000

_MAX_WAIT_S: Final = 1.0
"""Seconds for which a command waits for the records: another program may lock the file for longer."""


@final
class LearntPersistence:
    """Saves records when they change, and restores them before the first command.

    A record that has not changed for as long as the journal stores entries is dropped. An unreadable record is dropped
    and logged.

    Attributes:
        is_awaited: Whether a command has to wait for the records, for at most a second.
        on_entries: Called, before the records are restored, with the newest entries of the journal, at most 1,000 of
            15 minutes.
    """

    def __init__(self, node: Node, store: JournalStore) -> None:
        self._node = node
        self._store = store
        self._restorers: dict[str, RestoreRecord] = {}
        self._loaded: anyio.Event | None = None
        self.is_awaited = store.remembers
        self.on_entries: Callable[[Iterable[JournalEntry]], None] = lambda _: None

    def saver(self, kind: str) -> SaveRecord:
        """Return the function that saves records of *kind*."""
        return partial(self._save, kind)

    def add(self, kind: str, restore: RestoreRecord) -> None:
        """Restore the records of *kind* by *restore* with the next :meth:`load`."""
        self._restorers[kind], self._loaded = restore, None

    async def load(self) -> None:
        """Restore all records, once. If it takes over a second, it returns, logs that, and restores them later."""
        loaded = self._loaded
        if loaded is None:
            loaded = self._loaded = anyio.Event()
            self._node.create_task(partial(self._load, loaded))
        with anyio.move_on_after(_MAX_WAIT_S):
            await loaded.wait()
        if not loaded.is_set() and self.is_awaited:
            kinds = ", ".join(sorted(self._restorers))
            text = f"records of earlier runs ({kinds}) cannot be read yet; commands are sent without them"
            self._node.log.warning(LATE, message=text)
        self.is_awaited = False

    async def _load(self, loaded: anyio.Event) -> None:
        since = Time.from_seconds(max(0.0, self._node.graph.clock.now() - durations.REMEMBERED))
        self.on_entries((await self._store.read(ReadJournalRequest(since=since))).entries)
        learnt = await self._store.learnt()
        restorers, self._restorers = self._restorers, {}
        rows = [row for row in learnt if row.kind in restorers or row.kind not in KINDS]
        problems = [problem for row in rows if (problem := self._restore(row, restorers.get(row.kind)))]
        self.is_awaited = False
        loaded.set()
        if rows:
            kept = len(rows) - len(problems)
            text = f"records learnt from earlier commands that are used: {kept}"
            self._node.log.info(LOADED, message=text, count=kept)
        if problems:
            text = f"records learnt from earlier commands that were dropped: {len(problems)}, such as {problems[0]}"
            self._node.log.warning(DROPPED, message=f"{text}; they are learnt again", count=len(problems))

    def _restore(self, row: LearntRow, restore: RestoreRecord | None) -> str:
        """Restore one row; return its problem, or an empty text."""
        problem = "" if restore is not None else "this version has no such records"
        try:
            if restore is not None:
                restore(row.name, row.record)
        except WireError as exc:
            problem = exc.problem
        if problem:
            self._save(row.kind, row.name, "")
        return problem and f"{row.kind} {row.name[:_MAX_NAME_CHARACTERS]!r}: {problem}"

    def _save(self, kind: str, name: str, record: str) -> None:
        self._store.learn(LearntRow(kind, name, record, self._node.graph.clock.now()))


class _Header(BaseModel):
    """The fields of a saved profile besides the profile itself; fields of later versions are ignored."""

    model_config = ConfigDict(extra="ignore", defer_build=True)

    version: Literal[1] = 1
    target: str


@final
class Profiles:
    """The profiles of the last 10,000 commanded parts; the least recently used is forgotten."""

    def __init__(self, save: SaveRecord) -> None:
        self._save = save
        self._known: BoundedMap[str, DeviceProfile] = BoundedMap(_MAX_PROFILES, lambda target, _: save(target, ""))

    def of(self, target: str) -> DeviceProfile:
        """Return the profile of a part; a new one if it is not known."""
        profile = self._known.get(target)
        if profile is None:
            profile = self._known[target] = DeviceProfile()
        else:
            self._known.move_to_end(target)
        return profile

    def save(self, target: str, profile: DeviceProfile) -> None:
        """Save a profile if it has changed."""
        if not profile.is_changed:
            return
        profile.is_changed = False
        fields = _form().dump_python(profile, mode="json", exclude={"is_changed"}, exclude_defaults=True)
        self._save(target, json.dumps({"target": target, **fields}, separators=(",", ":")))

    def restore(self, name: str, record: str) -> None:
        """Restore a profile of an earlier run.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        try:
            header, saved = _Header.model_validate_json(record), _form().validate_json(record)
        except ValidationError as exc:
            raise WireError(f"it is not the profile of a device: {exc.errors()[0]['msg']}", record.encode()) from exc
        if name != header.target:
            raise WireError("its name is that of another device", record.encode())
        self.of(name).add(saved)


@cache
def _form() -> TypeAdapter[DeviceProfile]:
    return TypeAdapter(DeviceProfile)
