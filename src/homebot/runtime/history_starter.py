"""The history of a run: a node of its own, begun when the start is over."""

from __future__ import annotations

from datetime import tzinfo
from pathlib import Path

from homebot.graph import Graph, Node
from homebot.history.history import HistoryKeeper
from homebot.history.settings import HistorySettings
from homebot.support.isolation import run_as

__all__ = ["keep_history"]

HISTORY_FILE = "history.sqlite"
"""The name of the file, beside that of the index."""


async def keep_history(graph: Graph, settings: HistorySettings | None, index: Path | None, zone: tzinfo | None) -> None:
    """Keep the history until cancelled, in a file beside *index*; in memory without one."""
    path = None if index is None else index.with_name(HISTORY_FILE)
    async with Node(graph, "history") as node:
        await run_as(node.full_name, HistoryKeeper(node, settings or HistorySettings(), path, zone).serve)
