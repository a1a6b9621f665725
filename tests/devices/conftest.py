"""A gateway and a directory, in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import anyio
import pytest

from homebot.discovery import Directory, DirectorySettings
from homebot.graph import Graph, Node
from homebot.testing import FakeGateway, FakeGatewaySettings

RunGateway = Callable[..., AbstractAsyncContextManager[FakeGateway]]
RunDirectory = Callable[[Graph], AbstractAsyncContextManager[Directory]]


@pytest.fixture
def gateway_on() -> RunGateway:
    """Runs the gateway ``fake`` on a graph."""

    @asynccontextmanager
    async def run(graph: Graph, **settings: object) -> AsyncIterator[FakeGateway]:
        async with Node(graph, "fake", namespace="/gateway") as node:
            yield FakeGateway(node, FakeGatewaySettings.model_validate(settings))

    return run


@pytest.fixture
def directory_on() -> RunDirectory:
    """Runs a directory on a graph."""

    @asynccontextmanager
    async def run(graph: Graph) -> AsyncIterator[Directory]:
        async with Node(graph, "discovery") as node, anyio.create_task_group() as tasks:
            directory = Directory(node, DirectorySettings())
            await tasks.start(directory.serve)
            yield directory
            tasks.cancel_scope.cancel()

    return run
