"""A graph with an open rosbridge server, and clients that come through it by a real WebSocket."""

import json
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Protocol

import anyio
import pytest
from tests.one_task import in_one_task
from tests.patience import PATIENCE
from websockets.asyncio.client import ClientConnection, connect

from homebot.bridges.rosapi import RosApi
from homebot.bridges.rosbridge import RosbridgeServer, RosbridgeSettings
from homebot.clock import Clock
from homebot.graph import Graph, Node


class Peer:
    """A client of the rosbridge server that speaks frames."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection

    async def send(self, op: str, **fields: object) -> None:
        await self.connection.send(json.dumps({"op": op, **fields}))

    async def receive(self) -> dict[str, Any]:
        with anyio.fail_after(PATIENCE):
            frame: dict[str, Any] = json.loads(await self.connection.recv())
        return frame

    async def call(self, service: str, **args: object) -> dict[str, Any]:
        await self.send("call_service", id="call", service=service, args=args)
        while (frame := await self.receive()).get("id") != "call" or frame["op"] != "service_response":
            pass
        return frame

    async def tell(self, op: str, **fields: object) -> None:
        """Send, and return when the rosbridge server has dealt with it."""
        await self.send(op, **fields)
        await self.settle()

    async def settle(self) -> None:
        """Return when the rosbridge server has dealt with everything sent before."""
        await self.call("/rosapi/get_time")


class House:
    """A graph and its rosbridge server."""

    def __init__(self, graph: Graph, server: RosbridgeServer, node: Node) -> None:
        self.graph = graph
        self.server = server
        self.server_node = node

    def node(self, name: str) -> Node:
        return Node(self.graph, name)

    @asynccontextmanager
    async def peer(self, path: str = "/", **headers: str) -> AsyncIterator[Peer]:
        url = f"ws://127.0.0.1:{self.server.port}{path}"
        async with connect(url, additional_headers=headers, proxy=None, compression=None, max_size=None) as connection:
            yield Peer(connection)

    def entities(self) -> set[tuple[str, str]]:
        """What the rosbridge server holds on the graph."""
        held = self.graph.get_endpoints(node=self.server_node.full_name)
        return {(info.kind.value, info.name) for info in held if info.kind.value != "node"} - {
            ("publisher", "/parameter_events")
        }


class OpenHouse(Protocol):
    def __call__(self, settings: RosbridgeSettings | None = None) -> AbstractAsyncContextManager[House]: ...


@pytest.fixture
def open_house() -> Callable[..., AbstractAsyncContextManager[House]]:
    """Give what opens a house with a rosbridge server on a free port."""

    @asynccontextmanager
    async def opened(
        settings: RosbridgeSettings | None = None, open_timeout: float = 10.0, clock: Clock | None = None, **parts: Any
    ) -> AsyncIterator[House]:
        graph = Graph(clock)
        async with Node(graph, "rosbridge_websocket") as node, anyio.create_task_group() as tasks:
            server = RosbridgeServer(node, settings or RosbridgeSettings(port=0), open_timeout=open_timeout, **parts)
            RosApi(Node(graph, "rosapi"))
            await tasks.start(server.run)
            yield House(graph, server, node)
            tasks.cancel_scope.cancel()

    return opened


@pytest.fixture
async def house(open_house: OpenHouse) -> AsyncIterator[House]:
    """A house with a rosbridge server on a free port."""
    async with in_one_task(open_house()) as house:
        yield house


@pytest.fixture
async def peer(house: House) -> AsyncIterator[Peer]:
    """A client of the rosbridge server."""
    async with house.peer() as peer:
        yield peer
