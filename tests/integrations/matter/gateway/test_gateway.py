"""The Matter gateway with a simulated server: kinds of devices, absence, what goes wrong, and floods."""

import logging
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field

import anyio
import anyio.lowlevel
import pytest
from aiohttp import web
from anyio.abc import TaskGroup
from pydantic import ValidationError
from tests.gateways.http_servers import serving
from tests.gateways.watched_gateway import WatchedGateway, reading, receive, watched
from tests.integrations.matter.simulated.node import ServedMatterNode
from tests.integrations.matter.simulated.server import SimulatedMatterServer
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.devices import GatewayState
from homebot.devices.gateway_messages import SendCommandResponse
from homebot.devices.value import PlainValue
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.matter.gateway import MatterGateway, MatterGatewaySettings
from homebot.testing.gateway_contract.steps import KEPT


@dataclass
class House(WatchedGateway):
    """A gateway and the server that it is connected to."""

    gateway: MatterGateway
    server: SimulatedMatterServer
    watcher: Node
    tasks: TaskGroup
    orders: list[str] = field(default_factory=list)

    async def commission(self, kind: str, state: DeviceState) -> ServedMatterNode:
        device = SimulatedDeviceInfo("home", kind, f"The {kind}", "x", "hall")
        node = ServedMatterNode(device, self.orders.append, self.server)
        node.begin(state, has_power=True)
        await self.tasks.start(node.serve)
        return node

    async def send(self, key: str, capability: str, value: PlainValue, code: str = "") -> SendCommandResponse:
        return await self.command(key, "1", capability, value, code=code)


@asynccontextmanager
async def house(**settings: object) -> AsyncIterator[House]:
    server = SimulatedMatterServer()
    async with anyio.create_task_group() as tasks:
        await tasks.start(server.serve)
        async with gateway_to(server.url, **settings) as (gateway, watcher):
            yield House(gateway, server, watcher, tasks)
        tasks.cancel_scope.cancel()


def gateway_to(url: str, **settings: object) -> AbstractAsyncContextManager[tuple[MatterGateway, Node]]:
    """A gateway with its watcher."""
    table = MatterGatewaySettings.model_validate({"url": url, **settings})
    return watched("matter", lambda node: MatterGateway(node, table))


async def test_the_code_of_a_lock_reaches_it_and_no_log(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    async with house() as home:
        reports = home.reports()
        lock = await home.commission("lock", DeviceState(text="locked"))
        await reading(reports, "lock", lambda one: one == "locked")
        lock.change("1/257/51", True)
        with anyio.fail_after(PATIENCE):
            while (await home.send("node-1", "lock", "unlocked")).success:  # noqa: ASYNC110 - until the change is known
                await anyio.sleep(0.01)
        assert (await home.send("node-1", "lock", "unlocked", "4711")).success
        assert home.orders[-1] == "unlock"
        _, args = home.server.calls[-1]
        assert args["payload"] == {"PINCode": "NDcxMQ=="}
    assert "4711" not in caplog.text
    assert "NDcxMQ" not in caplog.text


async def test_a_node_that_loses_power_is_unreachable_and_stays() -> None:
    async with house() as home:
        reports, sightings = home.reports(), home.sightings()
        lamp = await home.commission("lamp", DeviceState(text="off"))
        await reading(reports, "reachable", lambda one: one is True)
        lamp.is_available = False
        home.server.miss(lamp)
        await reading(reports, "reachable", lambda one: one is False)
        response = await home.send("node-1", "on_off", True)
        assert (response.success, response.problem) == (False, "unreachable")
        lamp.is_available = True
        home.server.reach(lamp)
        await reading(reports, "reachable", lambda one: one is True)
        assert (await home.send("node-1", "on_off", True)).success
        kinds = [one.kind for one in iter(sightings.take, None)]
        assert "removed" not in kinds


async def test_a_value_that_the_server_missed_is_read_from_its_node() -> None:
    async with house() as home:
        reports = home.reports()
        lamp = await home.commission("lamp", DeviceState(text="off"))
        await reading(reports, "on_off", lambda one: one is False)
        lamp.attributes["1/6/0"] = True
        assert (await home.refresh("node-1", "1")).success
        await reading(reports, "on_off", lambda one: one is True)
        lamp.is_available = False
        home.server.miss(lamp)
        await reading(reports, "reachable", lambda one: one is False)
        assert "does not answer" in (await home.refresh("node-1", "1")).message


async def test_a_press_of_a_button_is_one_event() -> None:
    async with house() as home:
        reports = home.reports()
        button = await home.commission("contact", DeviceState(text="open"))
        button.attributes = {"1/29/0": [{"0": 15, "1": 3}], "1/59/0": 2, "1/59/2": 2, "1/59/65532": 0b11110}
        home.server.reach(button)
        event = {"node_id": 1, "endpoint_id": 1, "cluster_id": 59, "event_id": 6, "event_number": 1, "priority": 1}
        data = {"previousPosition": 1, "totalNumberOfPressesCounted": 2}
        home.server.send_event("node_event", {**event, "timestamp": 1, "timestamp_type": 1, "data": data})
        assert await reading(reports, "press", lambda one: one is not None) == "double"


async def test_a_value_that_the_device_does_not_take_is_refused() -> None:
    async with house() as home:
        reports = home.reports()
        node = await home.commission("contact", DeviceState(text="open"))
        node.attributes = {"1/29/0": [{"0": 43, "1": 3}], "1/514/0": 1, "1/514/2": 10, "1/514/3": 10}
        home.server.reach(node)
        await reading(reports, "fan_speed", lambda one: one == 10.0)
        response = await home.send("node-1", "fan_speed", 50.0)
        assert (response.success, response.problem) == (False, "refused")
        assert "0x88" in response.message


async def test_missed_changes_of_a_node_in_quarantine_are_asked_for() -> None:
    async with house(stale_after=0.3) as home:
        reports = home.reports()
        lamp = await home.commission("lamp", DeviceState(text="off"))
        await reading(reports, "on_off", lambda one: one is False)
        while not home.gateway.devices.engine.quarantine.quarantined():
            home.server.send_event("attribute_updated", [1, "1/6", True])
            await anyio.lowlevel.checkpoint()
        lamp.change("1/6/0", True)
        await reading(reports, "on_off", lambda one: one is True)


async def test_thousands_of_nodes_that_are_announced_at_once_stay_within_the_limit() -> None:
    async with house(max_nodes=20) as home:
        reports = home.reports()
        lamp = await home.commission("lamp", DeviceState(text="off"))
        await reading(reports, "on_off", lambda one: one is False)
        for number in range(size(2_000, 10_000)):
            home.server.send_event("node_added", {"node_id": 100 + number, "available": True, "attributes": {}})
            if number % 50 == 0:
                await anyio.lowlevel.checkpoint()
        await anyio.sleep(0.05)
        lamp.change("1/6/0", True)
        await reading(reports, "on_off", lambda one: one is True)
        assert len(home.gateway.devices.keys) == 20
        assert home.gateway.devices.counters.devices_refused > 0


@pytest.mark.parametrize(
    ("greeting", "reason"),
    [
        ('{"schema_version": 2}', "version 2"),
        ('{"schema_version": 30, "min_supported_schema_version": 20}', "20"),
        ('{"event": "x"}', "not a Matter server"),
        ("hello", "JSON"),
    ],
)
async def test_a_server_that_is_not_understood_makes_it_unavailable_with_the_reason(greeting: str, reason: str) -> None:
    async def greet(request: web.Request) -> web.StreamResponse:
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        await socket.send_str(greeting)
        async for _ in socket:
            pass
        return socket

    async with serving(greet) as url, gateway_to(f"{url}/ws") as (gateway, watcher):
        states = watcher.create_subscription(GatewayState, gateway.names.state, qos_profile=KEPT)
        assert reason in (await receive(states, lambda one: one.state == "unavailable")).reason


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("127.0.0.1:5580", "written like"),
        ("mqtt://127.0.0.1", "written like"),
        ("ws:///ws", "written like"),
        ("ws://me:secret@host/ws", "no password"),
        ("ws://[::1", "url"),
    ],
)
def test_an_address_that_is_none_is_refused_with_the_reason(url: str, reason: str) -> None:
    with pytest.raises(ValidationError, match=reason):
        MatterGatewaySettings(url=url)
