"""What a handler may wait for in its first step: it is told how that ended, in a task of its node."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Generator
from types import coroutine

import anyio
import pytest

from homebot.errors import ServiceGoneError
from homebot.graph import Graph, Node
from homebot.messages import Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest

ASK = TriggerRequest()
pytestmark = pytest.mark.virtual_time


def in_a_moment(do: Callable[[asyncio.Future[str]], object]) -> asyncio.Future[str]:
    future: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    asyncio.get_running_loop().call_later(1, do, future)
    return future


async def a_result() -> str:
    return await in_a_moment(lambda future: future.set_result("result"))


async def an_error() -> str:
    try:
        return await in_a_moment(lambda future: future.set_exception(KeyError("error")))
    except KeyError as exc:
        return str(exc.args[0])


async def a_cancellation() -> str:
    """Of what it waits for: nobody cancels the handler."""
    try:
        return await in_a_moment(lambda future: future.cancel())
    except asyncio.CancelledError:
        return "cancelled"


async def a_task() -> str:
    return await asyncio.create_task(asyncio.sleep(1, "task"))


async def the_next_turn() -> str:
    await asyncio.sleep(0)
    return "turn"


async def nothing_that_can_be_awaited() -> str:
    try:
        await yields("this")
    except RuntimeError as exc:
        return str(exc)
    raise AssertionError


@coroutine
def yields(what: object) -> Generator[object, None, None]:
    yield what


@pytest.mark.parametrize(
    ("wait", "result"),
    [
        (a_result, "result"),
        (an_error, "error"),
        (a_cancellation, "cancelled"),
        (a_task, "task"),
        (the_next_turn, "turn"),
        (nothing_that_can_be_awaited, "Task got bad yield: 'this'"),
    ],
)
async def test_a_handler_is_told_how_its_first_wait_ended(
    graph: Graph, wait: Callable[[], Awaitable[str]], result: str
) -> None:
    async def handle(_: TriggerRequest) -> SuccessResponse:
        first = await wait()
        return SuccessResponse(success=True, message=f"{first}, {await wait()}")

    async with Node(graph, "server") as server, Node(graph, "caller") as caller:
        server.create_service(Trigger, "/s", handle)
        client = caller.create_client(Trigger, "/s")
        for _ in range(3):  # at first in a new task, then in one that is free
            assert (await client.call(ASK)).message == f"{result}, {result}"


async def test_a_handler_that_waits_ends_with_its_node(graph: Graph) -> None:
    """Told by what it waits for, or while that is done already."""
    ended: list[str] = []
    future: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def handle(_: TriggerRequest) -> SuccessResponse:
        try:
            await (the_next_turn() if not ended else future)
        except asyncio.CancelledError:
            ended.append("cancelled")
            raise
        ended.append("done")
        return SuccessResponse(success=True, message="")

    async with Node(graph, "caller") as caller, anyio.create_task_group() as tasks:
        client = caller.create_client(Trigger, "/s")

        async def call() -> None:
            with pytest.raises(ServiceGoneError):
                await client.call(ASK)

        async with Node(graph, "server") as server:
            server.create_service(Trigger, "/s", handle)
            await client.call(ASK)
            tasks.start_soon(call)
            await anyio.wait_all_tasks_blocked()
            assert ended == ["done"]
    assert ended == ["done", "cancelled"]
    assert future.cancelled()
