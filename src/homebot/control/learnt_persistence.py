"""Knowledge that the control layer learnt from commands, kept over a restart in the store of the journal."""

from __future__ import annotations

from functools import partial
from typing import Final, Protocol, final

import anyio

from homebot.control.journal.learnt_row import LearntRow
from homebot.control.journal.store import JournalStore
from homebot.control.learnt_record import KeepLearnt
from homebot.errors import WireError
from homebot.graph import Node

__all__ = ["Learner", "LearntPersistence"]

KINDS: Final = frozenset({"detection", "profile"})
"""What this version learns; other rows are dropped."""

LOADED: Final = "control.learnt_loaded"
DROPPED: Final = "control.learnt_dropped"
LATE: Final = "control.learnt_late"

_LONGEST: Final = 100

_PATIENCE: Final = 1.0
"""Seconds for which a command waits for what was learnt: another program may keep the file for longer."""


class Learner(Protocol):
    """A part of the control layer that learns from commands."""

    def restore(self, name: str, record: str) -> None:
        """Take over what an earlier run kept as *record* under *name*.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        ...


@final
class LearntPersistence:
    """Writes what was learnt as it is learnt, and reads it back before the first command.

    Each row says when it was learnt last, and from which command, which the journal may still know. What was not learnt
    again for as long as the journal keeps its entries is dropped with them. A row that cannot be read is dropped, and
    said so; the rest is used. Rows whose learner is another one's are left to that.

    Args:
        node: For its log and clock.
        store: Where it is kept.

    Attributes:
        is_awaited: Whether a command has to wait until it was read, which takes a second at most.
    """

    def __init__(self, node: Node, store: JournalStore) -> None:
        self._node = node
        self._store = store
        self._learners: dict[str, Learner] = {}
        self._loaded: anyio.Event | None = None
        self.is_awaited = store.remembers

    def keeper(self, kind: str) -> KeepLearnt:
        """Return what keeps the records of *kind*."""
        return partial(self._keep, kind)

    def add(self, kind: str, learner: Learner) -> None:
        """Have *learner* take over the records of *kind*."""
        self._learners[kind] = learner

    async def load(self) -> None:
        """Let all take over what an earlier run learnt; once.

        Where that cannot be read within a second, they do so later, which the log says.
        """
        if self._loaded is None:
            self._loaded = anyio.Event()
            self._node.create_task(partial(self._load, self._loaded))
        with anyio.move_on_after(_PATIENCE):
            await self._loaded.wait()
        if not self._loaded.is_set() and self.is_awaited:
            kinds = ", ".join(sorted(self._learners))
            text = f"what was learnt in earlier runs ({kinds}) cannot be read yet; commands are sent without it"
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
        """Take one row over; return what is wrong with it, empty for nothing."""
        learner = self._learners.get(row.kind)
        problem = "" if learner is not None else "this version learns no such thing"
        try:
            if learner is not None:
                learner.restore(row.name, row.record)
        except WireError as exc:
            problem = exc.problem
        if problem:
            self._keep(row.kind, row.name, "", "")
        return problem and f"{row.kind} {row.name[:_LONGEST]!r}: {problem}"

    def _keep(self, kind: str, name: str, record: str, command: str) -> None:
        self._store.learn(LearntRow(kind, name, record, self._node.graph.clock.now(), command))
