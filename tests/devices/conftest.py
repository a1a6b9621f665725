"""A gateway, a directory and an app on one graph, in virtual time."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import anyio
import pytest
from tests.control.conftest import home, home_settings, open_home
from tests.one_task import in_one_task

from homebot.discovery import Directory, DirectorySettings
from homebot.graph import Graph, Node
from homebot.testing import FakeGateway, FakeGatewaySettings

__all__ = ["home", "home_settings", "open_home"]

RunGateway = Callable[..., AbstractAsyncContextManager[FakeGateway]]
RunDirectory = Callable[[], AbstractAsyncContextManager[Directory]]


@pytest.fixture
async def graph() -> Graph:
    return Graph()


@pytest.fixture
def run_gateway(graph: Graph) -> RunGateway:
    """Runs the gateway ``fake`` on the graph."""

    @asynccontextmanager
    async def run(**settings: object) -> AsyncIterator[FakeGateway]:
        async with Node(graph, "fake", namespace="/gateway") as node:
            yield FakeGateway(node, FakeGatewaySettings.model_validate(settings))

    return run


@pytest.fixture
def run_directory(graph: Graph) -> RunDirectory:
    """Runs a directory on the graph."""

    @asynccontextmanager
    async def run() -> AsyncIterator[Directory]:
        async with Node(graph, "discovery") as node, anyio.create_task_group() as tasks:
            directory = Directory(node, DirectorySettings())
            await tasks.start(directory.serve)
            yield directory
            tasks.cancel_scope.cancel()

    return run


@pytest.fixture
async def gateway(run_gateway: RunGateway) -> AsyncIterator[FakeGateway]:
    """The gateway ``fake``."""
    async with in_one_task(run_gateway()) as gateway:
        yield gateway


@pytest.fixture
async def node(graph: Graph, run_directory: RunDirectory) -> AsyncIterator[Node]:
    """The node of an app, beside a directory."""
    async with in_one_task(run_directory()), in_one_task(Node(graph, "app")) as node:
        yield node
