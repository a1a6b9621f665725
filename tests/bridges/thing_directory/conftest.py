"""A house with a lamp and a sensor, and its directory of things."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Protocol

import aiohttp
import anyio
import pytest
from tests.one_task import in_one_task
from tests.patience import PATIENCE

from homebot.bridges.thing_directory import DirectoryBridgeSettings
from homebot.bridges.thing_directory.bridge import ThingDirectoryBridge
from homebot.devices.exposure import NetworkService
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from homebot.testing.gateway_contract import running

LAMP = GatewayDevice(
    "hall",
    "Hall lamp",
    (simple_part("light", settable=("on_off", "level")),),
    {"manufacturer": "Acme"},
    identifiers=("mac:aabbccddeeff",),
    area="Hall",
)
SENSOR = GatewayDevice("attic", "Attic", (simple_part("temperature_sensor", readable=("temperature",)),))


OWNER = "fedcba9876543210"


class ServedHouse:
    """A house, its directory of things, and a client of that."""

    def __init__(
        self,
        gateway: MemoryGateway,
        bridge: ThingDirectoryBridge,
        announced: list[NetworkService],
        client: aiohttp.ClientSession,
    ) -> None:
        self.gateway = gateway
        self.bridge = bridge
        self.announced = announced
        self.client = client
        self.url = f"http://127.0.0.1:{bridge.port}"

    async def get(self, path: str, **headers: str) -> tuple[int, Any]:
        """Return the status, and what the answer says in JSON; None for no body."""
        async with self.client.get(f"{self.url}{path}", headers=headers) as answer:
            return answer.status, await answer.json(content_type=None) if await answer.read() else None

    async def put(self, path: str, body: bytes) -> tuple[int, Any]:
        async with self.client.put(f"{self.url}{path}", data=body) as answer:
            return answer.status, await answer.json(content_type=None) if await answer.read() else None

    async def things(self, count: int) -> list[Any]:
        """Return the list, as soon as it has that many descriptions."""
        with anyio.fail_after(PATIENCE):
            while True:
                status, found = await self.get("/things?limit=100")
                if status == 200 and len(found) == count:
                    assert isinstance(found, list)
                    return found
                await anyio.sleep(0.02)


class OpenHouse(Protocol):
    def __call__(self, **settings: object) -> AbstractAsyncContextManager[ServedHouse]: ...


@asynccontextmanager
async def open_house(**settings: object) -> AsyncIterator[ServedHouse]:
    """Open a house with a directory of things on a free port."""
    graph = Graph()
    announced: list[NetworkService] = []
    async with (
        Node(graph, "memory", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "thing_directory") as node,
        aiohttp.ClientSession() as client,
        anyio.create_task_group() as tasks,
    ):
        gateway = MemoryGateway(gateway_node)
        bridge = ThingDirectoryBridge(
            node, DirectoryBridgeSettings.model_validate({"port": 0, **settings}), "villa", OWNER, announced.append
        )
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        async with running(gateway):
            gateway.devices.put(LAMP, "new")
            gateway.devices.put(SENSOR, "new")
            await gateway.devices.report("hall", {"on_off": True, "level": 40.0})
            await tasks.start(bridge.run)
            yield ServedHouse(gateway, bridge, announced, client)
            tasks.cancel_scope.cancel()


@pytest.fixture
def served_house() -> Callable[..., AbstractAsyncContextManager[ServedHouse]]:
    """Give what opens a house with a directory of things on a free port."""
    return open_house


@pytest.fixture
async def house() -> AsyncIterator[ServedHouse]:
    """A house with a directory of things on a free port."""
    async with in_one_task(open_house()) as house:
        yield house
