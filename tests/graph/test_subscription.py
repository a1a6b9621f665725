"""Reading a topic: iteration, callbacks and batches."""

import asyncio
from collections.abc import Iterator
from itertools import islice

import anyio
import pytest
from structlog.testing import capture_logs
from tests.graph.test_topic import text

from homebot.errors import UsageError
from homebot.graph import OTHERS, DurabilityPolicy, Graph, GraphEntity, Node, QoSProfile
from homebot.messages import String


async def test_iterating_reads_until_the_subscription_is_closed(node: Node) -> None:
    subscription, publisher = node.create_subscription(String, "t"), node.create_publisher(String, "t")
    got: list[str] = []

    async def read() -> None:
        got.extend([message.data async for message in subscription])

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await anyio.wait_all_tasks_blocked()
        publisher.publish(text(1))
        publisher.publish(text(2))
        subscription.close()
    assert got == ["1", "2"]


async def test_a_callback_gets_one_message_at_a_time(node: Node) -> None:
    running, most, got = 0, 0, []

    async def slow(message: String) -> None:
        nonlocal running, most
        running += 1
        most = max(most, running)
        await anyio.lowlevel.checkpoint()
        got.append(message.data)
        running -= 1

    node.create_subscription(String, "t", slow)
    publisher = node.create_publisher(String, "t")
    for number in range(5):
        publisher.publish(text(number))
    await anyio.wait_all_tasks_blocked()
    assert most == 1
    assert got == ["0", "1", "2", "3", "4"]


async def test_a_concurrent_callback_runs_side_by_side_up_to_the_depth(node: Node) -> None:
    running, most = 0, 0
    gate = anyio.Event()

    async def slow(_message: String) -> None:
        nonlocal running, most
        running += 1
        most = max(most, running)
        await gate.wait()
        running -= 1

    subscription = node.create_subscription(String, "t", slow, 3, concurrent=True)
    publisher = node.create_publisher(String, "t")
    for number in range(3):
        publisher.publish(text(number))
    await anyio.wait_all_tasks_blocked()
    for number in range(5):
        publisher.publish(text(number))
    await anyio.wait_all_tasks_blocked()
    assert (running, most, subscription.lost) == (3, 3, 2)
    gate.set()
    await anyio.wait_all_tasks_blocked()
    assert (running, most) == (0, 3)


async def test_concurrent_callbacks_begin_in_order_each_in_a_task_of_its_own(node: Node) -> None:
    """Whether a message comes alone or with others, and while earlier ones are still handled."""
    begun: list[str] = []
    tasks: set[int] = set()
    done = anyio.Event()

    async def slow(message: String) -> None:
        begun.append(message.data)
        tasks.add(anyio.get_current_task().id)
        await done.wait()

    publisher = node.create_publisher(String, "t")
    node.create_subscription(String, "t", slow, concurrent=True)
    for burst in (["1"], ["2", "3", "4"], ["5"], ["6", "7"]):
        for word in burst:
            publisher.publish(text(word))
        await anyio.wait_all_tasks_blocked()
    assert begun == list("1234567")
    assert len(tasks) == 7
    done.set()


@pytest.mark.parametrize("is_busy", [False, True])
async def test_a_concurrent_subscription_ends_with_what_it_handles(graph: Graph, *, is_busy: bool) -> None:
    gate, done = anyio.Event(), list[str]()

    async def handle(message: String) -> None:
        if is_busy:
            await gate.wait()
        done.append(message.data)

    async with Node(graph, "reader") as reader, Node(graph, "writer") as writer:
        subscription = reader.create_subscription(String, "t", handle, concurrent=True)
        before = len(asyncio.all_tasks())
        publisher = writer.create_publisher(String, "t")
        for word in ("1", "2"):
            publisher.publish(text(word))
            await anyio.wait_all_tasks_blocked()
        subscription.close()
        gate.set()
        await anyio.wait_all_tasks_blocked()
        assert done == ["1", "2"]
        assert len(asyncio.all_tasks()) <= before


async def test_a_callback_that_feeds_itself_lets_others_run(node: Node) -> None:
    publisher = node.create_publisher(String, "t")
    node.create_subscription(String, "t", publisher.publish)
    publisher.publish(text(1))
    for _ in range(10):
        await anyio.lowlevel.checkpoint()


async def test_a_reader_that_comes_beside_a_callback_is_refused(node: Node) -> None:
    subscription = node.create_subscription(String, "t", lambda _message: None)
    await anyio.wait_all_tasks_blocked()
    with pytest.raises(UsageError, match="two tasks read from one subscription"):
        await subscription.receive()


async def test_a_closed_subscription_calls_back_for_what_was_there_and_ends_its_task(node: Node) -> None:
    got: list[String] = []
    subscription = node.create_subscription(String, "t", got.append)
    publisher = node.create_publisher(String, "t")
    publisher.publish(text(1))
    subscription.close()
    publisher.publish(text(2))
    await anyio.wait_all_tasks_blocked()
    assert got == [text(1)]


@pytest.mark.parametrize("concurrent", [False, True])
async def test_an_error_in_a_callback_costs_its_message_and_is_told(graph: Graph, *, concurrent: bool) -> None:
    heard: list[str] = []

    def fail(message: String) -> None:
        heard.append(message.data)
        if message.data == "boom":
            raise ValueError(message.data)

    async with Node(graph, "other") as other:
        got: list[String] = []
        other.create_subscription(String, "t", got.append)
        failing = Node(graph, "failing")
        failing.create_subscription(String, "t", fail, concurrent=concurrent)
        publisher = other.create_publisher(String, "t")
        with capture_logs() as lines:
            async with failing:
                for word in ("boom", "boom", "good"):
                    publisher.publish(text(word))
                await anyio.wait_all_tasks_blocked()
        assert heard == ["boom", "boom", "good"]
        assert got == [text("boom"), text("boom"), text("good")]
        assert [line["message"] for line in lines] == [
            "the handler of /t failed (ValueError: boom); its message is lost"
        ]
        (failure,) = graph.failures
        assert (failure.node, failure.callback, failure.count) == ("/failing", "handler of /t", 2)


@pytest.mark.parametrize(
    ("from_node", "unheard", "heard"), [("/wanted", "/other", "/wanted"), (OTHERS, "/reader", "/other")]
)
async def test_a_subscription_from_some_nodes_gets_what_those_publish_and_nothing_else(
    graph: Graph, from_node: str, unheard: str, heard: str
) -> None:
    """Also what is kept for late joiners, and whoever comes first."""
    latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    nodes = {f"/{name}": Node(graph, name) for name in ("reader", "wanted", "other")}
    reader = nodes["/reader"]
    early = reader.create_subscription(String, "/t", qos_profile=latched, from_node=from_node)
    publishers = [nodes[name].create_publisher(String, "/t", latched) for name in (unheard, heard)]
    for publisher in publishers:
        publisher.publish(text(publisher.info.node))
    late = reader.create_subscription(String, "/t", qos_profile=latched, from_node=from_node)
    for subscription in (early, late):
        assert [subscription.take(), subscription.take()] == [text(heard), None]
    assert publishers[0].subscription_count == 0


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


@pytest.mark.parametrize("lifespan", [0.0, 60.0])
async def test_a_reader_that_asks_learns_who_sent_each_message_and_whether_that_is_gone(
    node: Node, lifespan: float
) -> None:
    senders: dict[str, GraphEntity | None] = {}
    qos = QoSProfile(lifespan=lifespan, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    early, late = (node.create_publisher(String, "t", qos) for _ in "ab")
    early.publish(text(1))
    plain = node.create_subscription(String, "t", None, qos)
    asking = node.create_subscription(
        String, "t", lambda message: senders.update({message.data: asking.sender}), qos, names_sender=True
    )
    late.publish(text(2))
    early.close()
    await anyio.wait_all_tasks_blocked()
    assert senders == {"1": early, "2": late}
    assert (early.is_closed, late.is_closed) == (True, False)
    assert [plain.take(), plain.take(), plain.sender] == [text(1), text(2), None]
