"""Topics that clients of the door asked for before anybody used them: one look at the graph's changes for all."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

import anyio
from anyio.abc import TaskStatus

from homebot.graph import EntityKind, Graph

__all__ = ["ExpectedTopics"]


@final
class ExpectedTopics:
    """Calls back when a topic appears; :meth:`run` has to run for that.

    Args:
        graph: Where to look.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._expected: dict[str, dict[Callable[[str], None], None]] = {}

    def expect(self, topic: str, callback: Callable[[str], None]) -> None:
        """Call *callback* once with the full name *topic* when somebody begins to use it."""
        self._expected.setdefault(topic, {})[callback] = None

    def forget(self, topic: str, callback: Callable[[str], None]) -> None:
        """Do not call *callback* for *topic* any more; one that was not expected is fine."""
        expecting = self._expected.get(topic, {})
        expecting.pop(callback, None)
        if not expecting:
            self._expected.pop(topic, None)

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Watch until cancelled."""
        with self._graph.watch() as changes:
            task_status.started()
            async for change in changes:
                if change.change == "added" and change.entity.kind in {EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION}:
                    for callback in self._expected.pop(change.entity.name, {}):
                        callback(change.entity.name)
