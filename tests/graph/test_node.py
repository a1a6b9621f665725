"""Nodes: names, both spellings, life and death."""

import asyncio
from collections.abc import Callable

import anyio
import pytest

from homebot.errors import AbortError, ClosedError, ExitError, InvalidNameError, UsageError
from homebot.graph import Graph, Node
from homebot.messages import String, Trigger
from homebot.messages.std_srvs import SuccessResponse


@pytest.mark.parametrize(
    ("namespace", "name", "full", "resolved"),
    [
        ("/", "/p", "/n", "/p"),
        ("/", "p", "/n", "/p"),
        ("/a", "p", "/a/n", "/a/p"),
        ("a", "~/p", "/a/n", "/a/n/p"),
        ("/a/n", "~", "/a/n/n", "/a/n/n"),
    ],
)
async def test_names_are_relative_to_the_node(
    graph: Graph, namespace: str, name: str, full: str, resolved: str
) -> None:
    node = Node(graph, "n", namespace=namespace)
    assert (node.full_name, node.resolve_name(name)) == (full, resolved)
    assert node.create_publisher(String, name).topic_name == resolved


async def test_an_illegal_name_leaves_no_node_behind(graph: Graph) -> None:
    with pytest.raises(InvalidNameError):
        Node(graph, "no good")
    assert graph.get_node_names() == ()


@pytest.mark.virtual_time
async def test_the_spelling_of_rclpy_works(graph: Graph) -> None:
    """Talker, listener, server and timer as an rclpy user writes them."""
    heard: list[str] = []
    talker, listener = Node(graph, "talker"), Node(graph, "listener")
    publisher = talker.create_publisher(String, "chatter", 10)
    talker.create_timer(0.5, lambda: publisher.publish(String(data="hello")))
    listener.create_subscription(String, "chatter", lambda message: heard.append(message.data), 10)
    listener.create_service(Trigger, "reset", lambda _request: SuccessResponse(success=True, message="done"))
    listener.declare_parameter("loud", value=True)
    listener.get_logger().debug("listener.ready")
    client = talker.create_client(Trigger, "reset")
    async with talker, listener:
        assert await client.wait_for_service(timeout=1.0)
        assert (await client.call(Trigger.Request())).message == "done"
        await anyio.sleep(1.75)
    assert heard == ["hello"] * 3
    assert listener.get_parameter("loud").value is True


async def test_callbacks_made_before_the_start_wait_for_it(graph: Graph) -> None:
    got: list[String] = []
    node = Node(graph, "node")
    node.create_subscription(String, "t", got.append)
    node.create_publisher(String, "t").publish(String(data="early"))
    await anyio.wait_all_tasks_blocked()
    assert got == []
    async with node:
        await anyio.wait_all_tasks_blocked()
    assert got == [String(data="early")]


async def test_leaving_the_block_removes_everything_the_node_made(graph: Graph) -> None:
    async with Node(graph, "node") as node:
        node.create_publisher(String, "p")
        node.create_subscription(String, "s", lambda _message: None)
        node.create_client(Trigger, "c")
        node.create_service(Trigger, "v", lambda _request: SuccessResponse(success=True, message=""))
        node.create_timer(1, lambda: None)
    assert node.is_closed
    assert graph.get_endpoints() == ()
    assert graph.get_topic_names_and_types() == {}
    assert graph.get_service_type("/c") is None


async def test_a_task_of_the_node_ends_with_it_and_may_publish_a_last_word(graph: Graph) -> None:
    last = Node(graph, "listener").create_subscription(String, "t")

    async with Node(graph, "node") as node:
        publisher = node.create_publisher(String, "t")

        async def work() -> None:
            try:
                await anyio.sleep_forever()
            finally:
                publisher.publish(String(data="bye"))

        node.create_task(work)
        await anyio.wait_all_tasks_blocked()
    assert last.take() == String(data="bye")


async def test_closing_a_running_node_ends_its_tasks_but_not_the_block_around_it(graph: Graph) -> None:
    ended = anyio.Event()

    async def work() -> None:
        try:
            await anyio.sleep_forever()
        finally:
            ended.set()

    async with Node(graph, "node") as node:
        node.create_task(work)
        await anyio.wait_all_tasks_blocked()
        node.close()
        node.close()
        with anyio.fail_after(1):
            await ended.wait()
        assert graph.get_node_names() == ()


@pytest.mark.parametrize("concurrent", [False, True])
async def test_a_callback_that_exits_has_failed_and_is_not_the_end_of_the_process(
    graph: Graph, *, concurrent: bool
) -> None:
    def leave(message: String) -> None:
        raise SystemExit(message.data)

    async with Node(graph, "node") as node:
        node.create_subscription(String, "topic", leave, concurrent=concurrent)
        node.create_publisher(String, "topic").publish(String(data="now"))
        await anyio.wait_all_tasks_blocked()
    (failure,) = graph.failures
    assert failure.last == "ExitError: /node called sys.exit('now'); to end it, let it return"


@pytest.mark.parametrize("error", [SystemExit("now"), asyncio.CancelledError(), GeneratorExit()])
async def test_a_task_that_ends_as_only_python_may_end_it_is_a_crash_of_its_node(
    graph: Graph, error: BaseException
) -> None:
    async def leave() -> None:
        raise error

    async def run() -> None:
        async with Node(graph, "node") as node:
            node.create_task(leave)
            await anyio.sleep_forever()

    with pytest.raises((ExitError, AbortError), match="/node"):
        await run()


async def test_closing_a_node_while_a_task_of_it_was_cancelled_by_another_does_not_end_the_block(graph: Graph) -> None:
    """The cancellation is not that of the node's scope, which would keep it for itself."""
    broken: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def wait() -> None:
        await broken

    async with Node(graph, "node") as node:
        node.create_task(wait)
        await anyio.wait_all_tasks_blocked()
        broken.cancel()
        node.close()
        await anyio.wait_all_tasks_blocked()
        assert not graph.get_node_names()


@pytest.mark.parametrize(
    "use",
    [
        lambda node: node.create_publisher(String, "t"),
        lambda node: node.create_subscription(String, "t"),
        lambda node: node.create_client(Trigger, "s"),
        lambda node: node.create_service(Trigger, "s", lambda _request: None),
        lambda node: node.create_timer(1, lambda: None),
        lambda node: node.create_task(anyio.sleep_forever),
    ],
)
async def test_a_closed_node_makes_nothing_more(graph: Graph, use: Callable[[Node], object]) -> None:
    node = Node(graph, "node")
    node.close()
    with pytest.raises(ClosedError, match="the node /node is closed"):
        use(node)


async def test_a_closed_node_does_not_start_again(graph: Graph) -> None:
    async with Node(graph, "node") as node:
        pass
    with pytest.raises(ClosedError):
        await node.__aenter__()


async def test_a_running_node_does_not_start_twice(graph: Graph) -> None:
    async with Node(graph, "node") as node:
        with pytest.raises(UsageError, match="the node /node is already running"):
            await node.__aenter__()


async def test_leaving_a_node_that_never_started_does_nothing(graph: Graph) -> None:
    node = Node(graph, "node")
    await node.__aexit__(None, None, None)
    assert not node.is_closed


async def test_an_error_in_the_block_comes_out_as_itself(graph: Graph) -> None:
    node = Node(graph, "node")
    with pytest.raises(ValueError, match="mine"):
        async with node:
            raise ValueError("mine")
    assert node.is_closed


async def test_an_error_in_a_task_comes_out_as_itself(graph: Graph) -> None:
    async def fail() -> None:
        raise ValueError("mine")

    node = Node(graph, "node")
    node.create_task(fail)
    with pytest.raises(ValueError, match="mine"):
        async with node:
            await anyio.sleep_forever()
    assert node.is_closed


async def test_the_only_error_of_a_group_comes_out_with_its_own_context(graph: Graph) -> None:
    """Not with the group, whose traceback a log would show beside its own."""
    first, mine = KeyError("first"), ValueError("mine")
    mine.__context__ = first
    with pytest.raises(ValueError, match="mine") as caught:
        async with Node(graph, "node"):
            raise ExceptionGroup("tasks", [mine])
    assert caught.value.__context__ is first


async def test_several_errors_come_out_as_a_group(graph: Graph) -> None:
    async def fail() -> None:
        raise ValueError

    node = Node(graph, "node")
    node.create_task(fail)
    node.create_task(fail)
    with pytest.raises(ExceptionGroup) as caught:
        async with node:
            await anyio.sleep_forever()
    assert len(caught.value.exceptions) == 2
