"""Persistence of the knowledge about devices, in the store of the journal."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final, Protocol, TypeAlias, final

import anyio

from homebot.control.journal.store import JournalStore, LearntRow
from homebot.errors import WireError
from homebot.graph import Node

__all__ = ["Learner", "LearntPersistence", "SaveRecord"]

SaveRecord: TypeAlias = Callable[[str, str], None]
"""Saves a record over a restart: its name, and the record, empty to remove it."""

KINDS: Final = frozenset({"detection", "profile"})
"""The kinds of this version; other rows are dropped."""

LOADED: Final = "control.learnt_loaded"
DROPPED: Final = "control.learnt_dropped"
LATE: Final = "control.learnt_late"

_LONGEST: Final = 100

_PATIENCE: Final = 1.0
"""Seconds for which a command waits for the records: another program may lock the file for longer."""


class Learner(Protocol):
    """A part of the control layer with saved records."""

    def restore(self, name: str, record: str) -> None:
        """Restore a record of an earlier run.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        ...


@final
class LearntPersistence:
    """Saves records when they change, and restores them before the first command.

    A record that does not change for as long as the journal stores its entries is dropped with them. An unreadable one
    is dropped and logged.

    Attributes:
        is_awaited: Whether a command has to wait for the records, which takes a second at most.
    """

    def __init__(self, node: Node, store: JournalStore) -> None:
        self._node = node
        self._store = store
        self._learners: dict[str, Learner] = {}
        self._loaded: anyio.Event | None = None
        self.is_awaited = store.remembers

    def saver(self, kind: str) -> SaveRecord:
        """Return the function that saves records of *kind*."""
        return partial(self._save, kind)

    def add(self, kind: str, learner: Learner) -> None:
        """Restore the records of *kind* with *learner*."""
        self._learners[kind] = learner

    async def load(self) -> None:
        """Restore all records; once. After a second they are restored later, and that is logged."""
        if self._loaded is None:
            self._loaded = anyio.Event()
            self._node.create_task(partial(self._load, self._loaded))
        with anyio.move_on_after(_PATIENCE):
            await self._loaded.wait()
        if not self._loaded.is_set() and self.is_awaited:
            kinds = ", ".join(sorted(self._learners))
            text = f"records of earlier runs ({kinds}) cannot be read yet; commands are sent without them"
            self._node.log.warning(LATE, message=text)
        self.is_awaited = False

    async def _load(self, loaded: anyio.Event) -> None:
        rows = [one for one in await self._store.learnt() if one.kind in self._learners or one.kind not in KINDS]
        problems = [problem for row in rows if (problem := self._restore(row))]
        self.is_awaited = False
        loaded.set()
        if rows:
            kept = len(rows) - len(problems)
            text = f"records of what earlier commands taught that are used: {kept}"
            self._node.log.info(LOADED, message=text, count=kept)
        if problems:
            text = f"records of what earlier commands taught that were dropped: {len(problems)}, such as {problems[0]}"
            self._node.log.warning(DROPPED, message=f"{text}; it is learnt anew", count=len(problems))

    def _restore(self, row: LearntRow) -> str:
        """Restore one row; return its problem, or an empty text."""
        learner = self._learners.get(row.kind)
        problem = "" if learner is not None else "this version has no such records"
        try:
            if learner is not None:
                learner.restore(row.name, row.record)
        except WireError as exc:
            problem = exc.problem
        if problem:
            self._save(row.kind, row.name, "")
        return problem and f"{row.kind} {row.name[:_LONGEST]!r}: {problem}"

    def _save(self, kind: str, name: str, record: str) -> None:
        self._store.learn(LearntRow(kind, name, record, self._node.graph.clock.now()))
