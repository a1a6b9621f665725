"""The gateways that control follows, in virtual time."""

import anyio
import pytest

from homebot.control.gateway_feed import GatewayFeed
from homebot.devices.device import Route
from homebot.devices.gateway_messages import Report
from homebot.devices.names import GatewayNames
from homebot.devices.value import PlainValue, Reading, Value
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from homebot.messages import Time

pytestmark = pytest.mark.virtual_time


async def test_a_gateway_that_starts_after_a_command_to_its_device_is_followed_too() -> None:
    """The raw commands to it were not in the journal."""
    graph, gateways = Graph(), list[str]()
    async with Node(graph, "control") as node, Node(graph, "late", namespace="/gateway") as late:
        feed = GatewayFeed(node)
        feed.on_gateway = gateways.append
        feed.watch((Route(gateway="late", key="lamp", part=""),), lambda *_: None)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(feed.run)
            await tasks.start(MemoryGateway(late).serve)
            await anyio.sleep(1)
            tasks.cancel_scope.cancel()
    assert gateways == ["late"]


async def test_a_gateway_without_a_possible_name_is_not_followed() -> None:
    graph, gateways = Graph(), list[str]()
    async with Node(graph, "control") as node:
        feed = GatewayFeed(node)
        feed.on_gateway = gateways.append
        feed.watch((Route(gateway="no such name", key="lamp", part=""),), lambda *_: None)
    assert gateways == []


async def test_a_gateway_reports_only_its_own_devices() -> None:
    """The directory does not believe it either."""
    graph, values = Graph(), list[PlainValue]()
    async with Node(graph, "control") as node, Node(graph, "liar", namespace="/gateway") as liar:
        feed = GatewayFeed(node)
        for gateway in ("liar", "mqtt"):
            feed.watch(
                (Route(gateway=gateway, key="lamp", part=""),), lambda _capability, value, *_: values.append(value)
            )
        reports = liar.create_publisher(Report, GatewayNames("liar").readings)
        for gateway, level in (("mqtt", 10.0), ("liar", 20.0)):
            reading = Reading(part="", capability="level", value=Value.of(level))
            reports.publish(
                Report(
                    gateway=gateway,
                    key="lamp",
                    address="",
                    retained=False,
                    readings=(reading,),
                    received_at=Time.from_seconds(1.0),
                )
            )
        await anyio.sleep(1)
    assert values == [20.0]
