"""The load of the graph, measured while somebody asks."""

import time

import anyio
import pytest

from homebot.bridges.rosapi.load import LoadMeter, MeasureLoadRequest
from homebot.graph import Graph, Node
from homebot.messages.std_msgs import String


@pytest.mark.virtual_time
async def test_rates_queues_losses_and_slow_handlers_are_measured_while_somebody_asks() -> None:
    graph = Graph()
    async with Node(graph, "talker") as talker, Node(graph, "listener") as listener, Node(graph, "rosapi") as node:

        async def handle(_: String) -> None:
            await anyio.sleep(0.3)

        publisher = talker.create_publisher(String, "/t", 10)
        subscription = listener.create_subscription(String, "/t", handle, 5)
        meter = LoadMeter(node)
        meter.measure(MeasureLoadRequest())
        for _ in range(20):
            publisher.publish(String(data="x"))
        await anyio.sleep(0.4)
        found = meter.measure(MeasureLoadRequest())
        (queue,) = [one for one in found.queues if one.topic == "/t"]
        assert {one.topic: one.published for one in found.topics}["/t"] == 20
        assert (queue.node, queue.waiting, queue.lost) == ("/listener", 3, 15)
        assert queue.slowest == pytest.approx(0.3)
        await anyio.sleep(30)
        assert subscription.slowest is None  # nobody asks any more
        assert meter.measure(MeasureLoadRequest()).lag < 0.1


async def test_a_blocked_loop_shows_as_lag() -> None:
    async with Node(Graph(), "rosapi") as node:
        meter = LoadMeter(node)
        meter.measure(MeasureLoadRequest())
        await anyio.sleep(0.01)
        time.sleep(0.3)  # noqa: ASYNC251 - the fault
        await anyio.sleep(0.06)
        assert 0.2 < meter.measure(MeasureLoadRequest()).lag < 5
