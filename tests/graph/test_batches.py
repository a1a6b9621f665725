"""Reading a topic in batches."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import anyio
from structlog.testing import capture_logs
from tests.graph.test_topic import text

from homebot.graph import Graph, Node
from homebot.messages import String


async def test_all_that_wait_are_given_together(node: Node) -> None:
    batches: list[list[str]] = []
    subscription, publisher = node.create_subscription(String, "t"), node.create_publisher(String, "t")
    node.create_task(lambda: subscription.run_batches(lambda some: batches.append([one.data for one in some])))
    await anyio.wait_all_tasks_blocked()
    for number in range(3):
        publisher.publish(text(number))
    await anyio.wait_all_tasks_blocked()
    publisher.publish(text(3))
    await anyio.wait_all_tasks_blocked()
    assert batches == [["0", "1", "2"], ["3"]]


async def test_what_is_left_waits_where_losses_are_counted_and_comes_after_other_tasks(node: Node) -> None:
    got: list[str] = []
    subscription, publisher = node.create_subscription(String, "t", qos_profile=3), node.create_publisher(String, "t")

    def take_one(waiting: Iterator[String]) -> None:
        got.extend([one.data for one in islice(waiting, 1)])

    async def interfere() -> None:
        got.append("other task")
        for word in ("3", "4"):
            publisher.publish(text(word))

    for number in range(3):
        publisher.publish(text(number))
    node.create_task(lambda: subscription.run_batches(take_one))
    node.create_task(interfere)
    await anyio.wait_all_tasks_blocked()
    assert got == ["0", "other task", "2", "3", "4"]
    assert subscription.lost == 1


async def test_an_error_costs_the_message_that_was_taken_last_and_is_told(graph: Graph) -> None:
    got: list[str] = []

    def fail(waiting: Iterator[String]) -> None:
        for message in waiting:
            if message.data == "boom":
                raise ValueError(message.data)
            got.append(message.data)

    with capture_logs() as lines:
        async with Node(graph, "failing") as node:
            subscription, publisher = node.create_subscription(String, "t"), node.create_publisher(String, "t")
            node.create_task(lambda: subscription.run_batches(fail))
            for word in ("1", "boom", "2", "boom", "3"):
                publisher.publish(text(word))
            await anyio.wait_all_tasks_blocked()
    assert got == ["1", "2", "3"]
    assert "graph.callback_failed" in {line["event"] for line in lines}


async def test_it_ends_with_the_subscription_once_all_is_taken(node: Node) -> None:
    got: list[str] = []
    subscription, publisher = node.create_subscription(String, "t"), node.create_publisher(String, "t")
    publisher.publish(text(1))
    subscription.close()
    await subscription.run_batches(lambda some: got.extend([one.data for one in some]))
    assert got == ["1"]
