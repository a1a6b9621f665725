"""The live query: a snapshot and then what happens, without a gap and nothing twice; in virtual time."""

import anyio
import pytest
from structlog.testing import capture_logs
from tests.devices.conftest import RunDirectory

from homebot.devices import FIND_DEVICES, FindDevices, Follow
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.graph import Graph, Node
from homebot.messages import String
from homebot.testing import FakeGateway

pytestmark = pytest.mark.virtual_time


async def next_of(query: Follow) -> tuple[str, str]:
    change = await anext(query)
    return change.kind, change.device.id


async def nothing_of(query: Follow) -> bool:
    """Whether nothing comes for a while."""
    with anyio.move_on_after(1):
        await anext(query)
        return False
    return True


async def test_present_devices_come_first_and_then_their_changes(gateway: FakeGateway, node: Node) -> None:
    """Each device once, of the wanted type alone."""
    for key in ("lights/a", "lights/b", "windows/w"):
        gateway.sees(key)
    await anyio.sleep(0.001)
    query = Follow(node, "lights")
    assert [await next_of(query), await next_of(query)] == [("appeared", "lights/a"), ("appeared", "lights/b")]
    gateway.sees("windows/x")
    gateway.sees("lights/c")
    gateway.removes("lights/a")
    assert [await next_of(query), await next_of(query)] == [("appeared", "lights/c"), ("removed", "lights/a")]
    assert await nothing_of(query)


async def test_a_change_while_the_snapshot_is_read_is_neither_lost_nor_doubled(
    gateway: FakeGateway, node: Node
) -> None:
    """A device that appears and is removed before it was read is not reported."""
    gateway.sees("lights/a")
    gateway.sees("lights/b")
    await anyio.sleep(0.001)
    query = Follow(node, "lights")
    assert await next_of(query) == ("appeared", "lights/a")
    gateway.removes("lights/b")
    gateway.sees("lights/c")
    await anyio.sleep(0.001)
    assert await next_of(query) == ("appeared", "lights/c")
    assert await nothing_of(query)


async def test_a_directory_that_is_not_there_yet_is_waited_for(
    gateway: FakeGateway, graph: Graph, run_directory: RunDirectory
) -> None:
    """However long."""
    async with Node(graph, "app") as node:
        gateway.sees("lights/a")
        query = Follow(node)
        assert await nothing_of(query)
        async with run_directory():
            assert await next_of(query) == ("appeared", "lights/a")


async def test_a_restarted_directory_is_followed_on_and_only_differences_are_told(
    gateway: FakeGateway, graph: Graph, run_directory: RunDirectory
) -> None:
    """Who went, who came and who is called otherwise while it was away; and then it is live again."""
    async with Node(graph, "app") as node:
        query = Follow(node, "lights")
        async with run_directory():
            for key in ("lights/a", "lights/b", "lights/c"):
                gateway.sees(key)
            await anyio.sleep(0.001)
            for _ in range(3):
                await anext(query)
        await anyio.sleep(1)
        gateway.removes("lights/a")
        gateway.sees("lights/b", name="reading lamp")
        gateway.sees("lights/d")
        async with run_directory():
            differences = {await next_of(query) for _ in range(3)}
            assert differences == {("removed", "lights/a"), ("changed", "lights/b"), ("appeared", "lights/d")}
            assert await nothing_of(query)
            gateway.removes("lights/c")
            assert await next_of(query) == ("removed", "lights/c")


async def test_a_restart_is_noticed_in_any_crowd(
    gateway: FakeGateway, graph: Graph, run_directory: RunDirectory
) -> None:
    """More changes of the graph at once than a watcher can remember."""
    async with Node(graph, "app") as node:
        query = Follow(node)
        async with run_directory():
            gateway.sees("lights/a")
            assert await next_of(query) == ("appeared", "lights/a")
        gateway.removes("lights/a")
        await anyio.sleep(1)
        async with run_directory():
            for number in range(10_001):
                node.create_publisher(String, f"noise_{number}").close()
            assert await next_of(query) == ("removed", "lights/a")


async def test_a_slow_reader_gets_the_last_change_of_each_device(gateway: FakeGateway, node: Node) -> None:
    """A hundred changes of one device do not push out the one of another."""
    query = Follow(node, "lights")
    assert await nothing_of(query)
    gateway.sees("lights/quiet")
    await anyio.sleep(0.001)
    for number in range(100):
        gateway.sees("lights/noisy", name=f"name {number}")
        await anyio.sleep(0.001)
    gateway.sees("lights/brief")
    await anyio.sleep(0.001)
    gateway.removes("lights/brief")
    await anyio.sleep(0.001)

    first, second = await anext(query), await anext(query)
    assert (first.kind, first.device.id) == ("appeared", "lights/quiet")
    assert (second.kind, second.device.name) == ("appeared", "name 99")
    assert await nothing_of(query)


async def test_a_reader_that_never_waits_lets_others_run(gateway: FakeGateway, node: Node) -> None:
    """Every hundred changes at least."""
    for number in range(1000):
        gateway.sees(f"lights/{number}")
    await anyio.sleep(0.001)
    turns = 0

    async def other() -> None:
        nonlocal turns
        while True:
            await anyio.lowlevel.checkpoint()
            turns += 1

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(other)
        query = Follow(node)
        for _ in range(1000):
            await anext(query)
        tasks.cancel_scope.cancel()
    assert turns >= 9


async def test_a_directory_that_fails_to_answer_is_asked_again_and_told_once() -> None:
    """A service that raises is not the end of the query."""
    graph = Graph()
    asked = 0

    def find(_request: FindDevicesRequest) -> FindDevicesResponse:
        nonlocal asked
        asked += 1
        if asked < 4:
            raise RuntimeError("not now")
        return FindDevicesResponse(devices=(), sequence=1)

    async with Node(graph, "discovery") as directory, Node(graph, "app") as node:
        directory.create_service(FindDevices, FIND_DEVICES, find)
        with capture_logs() as lines:
            assert not await nothing_of_within(Follow(node), 5)
        assert asked == 4
        assert [line["event"] for line in lines if line["node"] == "/app"] == ["devices.no_answer"]


async def nothing_of_within(query: Follow, seconds: float) -> bool:
    with anyio.move_on_after(seconds):
        await anext(query)
        return True
    return False


@pytest.mark.parametrize("closes", ["query", "node"])
async def test_a_query_ends_when_it_or_its_node_is_closed(
    gateway: FakeGateway, node: Node, graph: Graph, closes: str
) -> None:
    """For the reader the loop is over, whatever it waits for; nothing of it is left on the graph."""
    query = Follow(node)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(_read_all, query)
        await anyio.sleep(1)
        (query if closes == "query" else node).close()
    query.close()
    assert [change async for change in query] == []
    node.close()
    assert graph.get_endpoints(node="/app") == ()


async def test_a_query_without_a_directory_ends_with_its_node() -> None:
    """It does not wait for ever."""
    async with Node(Graph(), "app") as node, anyio.create_task_group() as tasks:
        tasks.start_soon(_read_all, Follow(node))
        await anyio.sleep(1)
        node.close()


async def _read_all(query: Follow) -> None:
    async for _ in query:
        pass
