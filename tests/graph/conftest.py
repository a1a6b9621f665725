"""A graph, and nodes on it that run while the test does."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable

import pytest

from homebot.clock import LoopClock
from homebot.graph import Graph, Node


@pytest.fixture
async def graph() -> Graph:
    return Graph(LoopClock(epoch=1_700_000_000.0))


@pytest.fixture
async def run(graph: Graph) -> AsyncIterator[Callable[[str], Awaitable[Node]]]:
    """Start a node of the given name; it stops after the test.

    Each node lives in a task of its own: pytest-asyncio sets up and tears down in two different tasks, and a task group
    must be left by the task that entered it.
    """
    stop = asyncio.Event()
    hosts: list[asyncio.Task[None]] = []

    async def host(node: Node, started: asyncio.Event) -> None:
        async with node:
            started.set()
            await stop.wait()

    async def start(name: str) -> Node:
        node, started = Node(graph, name), asyncio.Event()
        hosts.append(asyncio.create_task(host(node, started)))
        await started.wait()
        return node

    yield start
    stop.set()
    await asyncio.gather(*hosts)


@pytest.fixture
async def node(run: Callable[[str], Awaitable[Node]]) -> Node:
    return await run("node")
