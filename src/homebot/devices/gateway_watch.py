"""The gateways that run, as they come."""

from collections.abc import AsyncIterator

from homebot.devices.names import gateway_of
from homebot.graph import EntityKind, Graph


async def watch_gateways(graph: Graph) -> AsyncIterator[str]:
    """Yield the name of each gateway, and again when it starts again. Read it to its end, in one task."""
    with graph.watch() as changes:
        nodes, lost = tuple(graph.get_node_names()), 0
        while True:
            for gateway in filter(None, map(gateway_of, nodes)):
                yield gateway
            change = await changes.receive()
            is_node = change.change == "added" and change.entity.kind is EntityKind.NODE
            nodes = (change.entity.name,) if is_node else ()
            if changes.lost > lost:
                nodes, lost = tuple(graph.get_node_names()), changes.lost
