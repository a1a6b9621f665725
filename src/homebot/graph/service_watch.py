"""Arrival of services on the graph: tells that a node was restarted and has forgotten whom it served."""

from __future__ import annotations

from collections.abc import AsyncIterator

from homebot.graph import EntityKind, Graph

__all__ = ["watch_services"]


async def watch_services(graph: Graph) -> AsyncIterator[str | None]:
    """Yield the full name of each service that comes, from the first step on; to be read to its end, in one task.

    None comes at the beginning, and whenever more happened than could be remembered: any service may be a new one.
    """
    with graph.watch() as changes:
        yield None
        lost = 0
        async for change in changes:
            if changes.lost > lost:
                lost = changes.lost
                while changes.take() is not None:
                    pass
                yield None
            elif change.change == "added" and change.entity.kind is EntityKind.SERVICE:
                yield change.entity.name
