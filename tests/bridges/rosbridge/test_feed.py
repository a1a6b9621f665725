"""How fast a topic goes to a client, in virtual time."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.bridges.rosbridge.backlog import Backlog, TotalBacklog
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import SubscribeOperation
from homebot.bridges.rosbridge.subscriptions import Feed
from homebot.bridges.time_slices import ServerTurns
from homebot.errors import LinkError
from homebot.graph import Graph, Node, Publisher
from homebot.messages import Int32
from homebot.messages.json import JsonObject

pytestmark = pytest.mark.virtual_time


class Client:
    """Takes frames and notes when each came."""

    def __init__(self) -> None:
        self.frames: list[tuple[float, JsonObject]] = []
        self.is_gone = False

    async def send(self, text: str | bytes) -> None:
        if self.is_gone:
            raise LinkError("gone")
        self.frames.append((round(anyio.current_time() - self.started, 3), json.loads(text)))

    def start(self) -> None:
        self.started = anyio.current_time()

    @property
    def seen(self) -> list[tuple[float, object]]:
        return [(when, frame["msg"]["data"]) for when, frame in self.frames if isinstance(frame["msg"], dict)]


@asynccontextmanager
async def feeding(client: Client, *requests: SubscribeOperation) -> AsyncIterator[Publisher[Int32]]:
    graph = Graph()
    outbox = Outbox(client.send, lambda: None, ServerTurns(), 1000)
    feed = Feed(Node(graph, "door"), "/n", Int32, 10, Backlog(10_000, TotalBacklog(10_000)), outbox)
    for request in requests:
        feed.add(request)
    publisher = Node(graph, "talker").create_publisher(Int32, "/n")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(outbox.run)
        client.start()
        yield publisher
        feed.close()
        tasks.cancel_scope.cancel()


def request(identifier: str, throttle_rate: float = 0, queue_length: int = 0) -> SubscribeOperation:
    return SubscribeOperation(
        op="subscribe", id=identifier, topic="/n", throttle_rate=throttle_rate, queue_length=queue_length
    )


async def test_without_a_queue_messages_while_throttled_are_dropped() -> None:
    client = Client()
    async with feeding(client, request("a", throttle_rate=100)) as publisher:
        for number in range(9):
            publisher.publish(Int32(data=number))
            await anyio.sleep(0.03)
    assert client.seen == [(0.0, 0), (0.12, 4), (0.24, 8)]


async def test_a_queue_keeps_the_newest_messages_while_throttled() -> None:
    client = Client()
    async with feeding(client, request("a", throttle_rate=100, queue_length=2)) as publisher:
        for number in range(5):
            publisher.publish(Int32(data=number))
        await anyio.sleep(1)
    assert client.seen == [(0.0, 0), (0.1, 3), (0.2, 4)]
    assert all("lost" not in frame for _, frame in client.frames)


async def test_several_requests_get_the_lowest_throttle_and_the_longest_queue() -> None:
    client = Client()
    requests = request("a", throttle_rate=500, queue_length=3), request("b", throttle_rate=100)
    async with feeding(client, *requests) as publisher:
        for number in range(5):
            publisher.publish(Int32(data=number))
        await anyio.sleep(1)
    assert client.seen == [(0.0, 0), (0.1, 2), (0.2, 3), (0.3, 4)]


async def test_losses_are_reported_with_the_next_message() -> None:
    client = Client()
    async with feeding(client, request("a")) as publisher:
        for number in range(13):
            publisher.publish(Int32(data=number))
        await anyio.sleep(1)
    assert [frame.get("lost", 0) for _, frame in client.frames] == [3] + [0] * 9


async def test_a_closed_feed_sends_nothing_more_also_while_it_was_throttled() -> None:
    client = Client()
    async with feeding(client, request("a", throttle_rate=100, queue_length=2)) as publisher:
        for number in range(3):
            publisher.publish(Int32(data=number))
        await anyio.sleep(0.05)
    await anyio.sleep(1)
    assert client.seen == [(0.0, 0)]
