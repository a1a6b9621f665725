"""A homebot to talk to: a graph with a door, on an event loop of its own in a thread."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import anyio
import pytest
from pydantic import SecretStr
from tests.graph.actions.fibonacci import Fibonacci, Result, Served

from homebot.bridges.rosapi import RosApi
from homebot.bridges.rosbridge import RosbridgeServer, RosbridgeSettings
from homebot.cli import main
from homebot.clock import Clock, ManualClock
from homebot.devices import (
    FIND_DEVICES,
    QUERY_DEVICES,
    Device,
    Endpoint,
    FindDevices,
    Found,
    KeyValue,
    QueryDevices,
    RawMessage,
)
from homebot.devices.client_rights import SIMULATED_HOUSE_RIGHTS
from homebot.devices.query.term_messages import read_terms
from homebot.devices.query.terms import And, TypeIs
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse, QueryDevicesRequest, QueryDevicesResponse
from homebot.graph import Graph, Node, Publisher, qos_profile_latched
from homebot.graph.actions import ActionServer
from homebot.messages import Int32, SetBool, String, Time
from homebot.messages.std_srvs import SetBoolRequest, SetBoolResponse
from homebot.words.queries import parse_query

TOKEN = "hunter2"
NOW = 1_800_000_000
HomebotWith = Callable[..., "Homebot"]
"""Runs a homebot with one more node, which the first argument makes of the graph; the second is its clock."""

Run = Callable[..., tuple[int, str]]
"""Runs a command, and returns its exit code and what it printed."""


@dataclass
class Homebot:
    """What runs in the thread; only :meth:`do` may touch the graph."""

    loop: asyncio.AbstractEventLoop
    graph: Graph
    port: int
    heard: list[str]
    chatter: Publisher[String]

    @property
    def door(self) -> str:
        return f"127.0.0.1:{self.port}"

    def do(self, function: Callable[[], None]) -> None:
        """Call *function* in the thread and wait for it."""

        async def call() -> None:
            function()

        asyncio.run_coroutine_threadsafe(call(), self.loop).result(5)


@pytest.fixture
def homebot() -> Iterator[Homebot]:
    with _running(None) as homebot:
        yield homebot


@pytest.fixture
def locked_homebot() -> Iterator[Homebot]:
    """Its door wants a token."""
    with _running(SecretStr(TOKEN)) as homebot:
        yield homebot


@pytest.fixture
def homebot_with() -> Iterator[HomebotWith]:
    with ExitStack() as stack:
        yield lambda extra, clock: stack.enter_context(_running(None, extra, clock))


@pytest.fixture
def run_with(homebot_with: HomebotWith, capsys: pytest.CaptureFixture[str]) -> Callable[[Callable[[Graph], Node]], Run]:
    """Starts a homebot with one more node, whose clock stands still at ``NOW``, for commands."""
    return lambda extra: run_at(homebot_with(extra, ManualClock(NOW)), capsys)


def run_at(homebot: Homebot, capsys: pytest.CaptureFixture[str]) -> Run:
    def run(*arguments: str) -> tuple[int, str]:
        code = main(["--door", homebot.door, *arguments])
        return code, "".join(capsys.readouterr())

    return run


@contextmanager
def _running(
    token: SecretStr | None, extra: Callable[[Graph], Node] | None = None, clock: Clock | None = None
) -> Iterator[Homebot]:
    ready = threading.Event()
    made: list[Homebot] = []
    stop: list[anyio.Event] = []

    async def run() -> None:
        graph = Graph(clock)
        heard: list[str] = []
        RosApi(Node(graph, "rosapi"))
        async with (
            Node(graph, "rosbridge_websocket") as door_node,
            (extra or _talker)(graph) as talker,
            Node(graph, "listener") as listener,
            anyio.create_task_group() as tasks,
        ):
            door = RosbridgeServer(
                door_node, RosbridgeSettings(port=0, token=token), local_rights=SIMULATED_HOUSE_RIGHTS, home="Café"
            )
            chatter = talker.create_publisher(String, "/chatter")
            listener.create_subscription(String, "/hello", lambda message: heard.append(message.data))
            await tasks.start(door.run)
            stop.append(anyio.Event())
            made.append(Homebot(asyncio.get_running_loop(), graph, door.port, heard, chatter))
            ready.set()
            await stop[0].wait()
            tasks.cancel_scope.cancel()

    thread = threading.Thread(target=anyio.run, args=(run,))
    thread.start()
    assert ready.wait(40)
    try:
        yield made[0]
    finally:
        made[0].loop.call_soon_threadsafe(stop[0].set)
        thread.join(10)
    assert not thread.is_alive()


def _talker(graph: Graph) -> Node:
    node = Node(graph, "talker")
    state = node.create_publisher(String, "/state", qos_profile_latched)
    state.publish(String(data="it's on: 5 lamps"))
    raw = node.create_publisher(RawMessage, "/raw", qos_profile_latched)
    stamp = Time(sec=1_700_000_000, nanosec=250_000_000)
    raw.publish(RawMessage(gateway="mqtt", key="k", address="a/b", payload=b"on", retained=False, received_at=stamp))
    ticks = node.create_publisher(Int32, "/ticks")
    node.create_publisher(Int32, "/_hidden")
    node.create_timer(0.02, lambda: ticks.publish(Int32(data=1)))

    def switch(request: SetBoolRequest) -> SetBoolResponse:
        return SetBoolResponse(success=request.data, message="done")

    async def count(goal: Served) -> Result:
        return Result(sequence=(goal.request.order,))

    def find(request: FindDevicesRequest) -> FindDevicesResponse:
        found = [one for one in (_lamp(stamp),) if request.service_type in {"", one.service_type}]
        return FindDevicesResponse(devices=tuple(found), sequence=1)

    def query(request: QueryDevicesRequest) -> QueryDevicesResponse:
        match read_terms(request.query, parse_query):
            case TypeIs(word, types) if "light" not in types:  # of which there is no device
                problem = "" if types else f"{word!r} is not a device type, and no device was announced as one; …"
                return QueryDevicesResponse(success=bool(types), message=problem)
            case TypeIs():
                pass
            case asked:
                assert asked == And(())
        return QueryDevicesResponse(success=True, results=(Found(device=_lamp(stamp), score=1.0, reasons=()),), total=1)

    node.declare_parameter("pace", 0.5)
    node.declare_parameter("words", ["on", "off"])
    ActionServer(node, Fibonacci, "/count", count)
    node.create_service(SetBool, "/switch", switch)
    node.create_service(FindDevices, FIND_DEVICES, find)
    node.create_service(QueryDevices, QUERY_DEVICES, query)
    return node


def _lamp(stamp: Time) -> Device:
    endpoint = Endpoint(gateway="mqtt", key="k", address="home/lights/lamp/out", command_address="home/lights/lamp/in")
    return Device(
        id="lights/lamp",
        name="Lamp\x1b[31m",
        service_type="lights",
        endpoints=(endpoint,),
        metadata=(KeyValue(key="room", value="kitchen"),),
        first_seen=stamp,
        last_seen=stamp,
        expires=Time(sec=1_700_003_600, nanosec=0),
        freshness="fresh",
    )
