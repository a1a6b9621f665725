"""Callers that leave before the answer comes: the handler goes on, and what it ends with is dropped and counted."""

import asyncio
from collections.abc import Awaitable, Callable
from contextvars import ContextVar

import anyio
import pytest
from structlog.testing import capture_logs
from tests.graph.test_service import ASK, TriggerClient, answer, now

from homebot.errors import (
    RefusedError,
    ServiceFailedError,
    ServiceGoneError,
    ServiceTimeoutError,
    ServiceUnavailableError,
)
from homebot.graph import Graph, Node
from homebot.graph.service import MAX_AT_WORK, MAX_WAITING
from homebot.messages import Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest

StartNode = Callable[[str], Awaitable[Node]]

pytestmark = pytest.mark.virtual_time


class Slow:
    """A handler that takes its time, and notes how each of its calls ends."""

    def __init__(self, seconds: float = 3, error: Exception | None = None) -> None:
        self.seconds = seconds
        self.error = error
        self.ends: list[tuple[str, float]] = []
        self.at_work = 0
        self.most = 0

    async def __call__(self, _request: TriggerRequest) -> SuccessResponse:
        self.at_work += 1
        self.most = max(self.most, self.at_work)
        try:
            await anyio.sleep(self.seconds)
            self._fail()
        except asyncio.CancelledError:
            self.ends.append(("cancelled", now()))
            raise
        except Exception:
            self.ends.append(("failed", now()))
            raise
        else:
            self.ends.append(("done", now()))
        finally:
            self.at_work -= 1
        return answer(str(len(self.ends)))

    def _fail(self) -> None:
        if self.error is not None:
            raise self.error


@pytest.fixture
async def server(run: StartNode) -> Node:
    return await run("server")


@pytest.fixture
async def client(run: StartNode) -> TriggerClient:
    return (await run("caller")).create_client(Trigger, "/s")


async def give_up(client: TriggerClient, timeout: float) -> None:
    with pytest.raises(ServiceTimeoutError):
        await client.call(ASK, timeout)


async def be_cancelled(client: TriggerClient, timeout: float) -> None:
    with anyio.move_on_after(timeout) as scope:
        await client.call(ASK)
    assert scope.cancelled_caught


async def be_cancelled_by_asyncio(client: TriggerClient, timeout: float) -> None:
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(timeout):
            await client.call(ASK)


LEAVES = [give_up, be_cancelled, be_cancelled_by_asyncio]
Leave = Callable[[TriggerClient, float], Awaitable[None]]


@pytest.mark.parametrize("leave", LEAVES)
async def test_a_late_answer_is_dropped_and_counted(
    graph: Graph, server: Node, client: TriggerClient, leave: Leave
) -> None:
    handler = Slow()
    server.create_service(Trigger, "/s", handler)
    await leave(client, 1)
    assert (now(), handler.at_work, graph.failures.late_answers) == (1, 1, 0)
    await client.wait_for_handlers()
    assert (handler.ends, graph.failures.late_answers) == ([("done", 3)], 1)


@pytest.mark.parametrize("leave", LEAVES)
async def test_one_who_asks_for_it_cancels_the_handler_when_it_leaves(
    graph: Graph, server: Node, client: TriggerClient, leave: Leave
) -> None:
    handler = Slow()
    server.create_service(Trigger, "/s", handler, cancel_with_caller=True)
    await leave(client, 1)
    assert (handler.ends, graph.failures.late_answers) == ([("cancelled", 1)], 0)


@pytest.mark.parametrize("seconds", [1, 3])
async def test_the_caller_may_ask_for_it_too(graph: Graph, server: Node, client: TriggerClient, seconds: float) -> None:
    handler = Slow(seconds)
    server.create_service(Trigger, "/s", handler)
    if seconds < 2:
        assert (await client.call(ASK, 2, cancel_with_caller=True)).success
    else:
        with pytest.raises(ServiceTimeoutError):
            await client.call(ASK, 2, cancel_with_caller=True)
        assert handler.ends == [("cancelled", 2)]
    assert graph.failures.late_answers == 0


async def test_the_next_call_of_an_exclusive_service_begins_when_the_handler_has_ended(
    graph: Graph, server: Node, client: TriggerClient
) -> None:
    handler = Slow()
    server.create_service(Trigger, "/s", handler)
    await give_up(client, 1)
    assert await client.call(ASK, timeout=10) == answer("2")
    assert (now(), handler.most, graph.failures.late_answers) == (6, 1, 1)


async def test_a_late_failure_is_logged_and_counted_as_every_failure_is(
    graph: Graph, server: Node, client: TriggerClient
) -> None:
    server.create_service(Trigger, "/s", Slow(error=ValueError("no such lamp")))
    with capture_logs() as lines:
        await give_up(client, 1)
        await client.wait_for_handlers()
    assert [(one.node, one.callback, one.count, one.last) for one in graph.failures] == [
        ("/server", "handler of /s", 1, "ValueError: no such lamp")
    ]
    assert [line["message"] for line in lines] == [
        "the handler of /s failed (ValueError: no such lamp); its caller had left"
    ]
    assert graph.failures.late_answers == 1


async def test_a_late_error_that_is_an_answer_is_logged_and_counted_as_late(
    graph: Graph, server: Node, client: TriggerClient
) -> None:
    server.create_service(Trigger, "/s", Slow(error=RefusedError("it", "too hot")))
    with capture_logs() as lines:
        await give_up(client, 1)
        await client.wait_for_handlers()
    assert list(graph.failures) == []
    assert graph.failures.late_answers == 1
    assert [line["message"] for line in lines] == [
        f"/s failed when its caller had left (RefusedError: {RefusedError('it', 'too hot')})"
    ]


async def test_closing_the_server_ends_handlers_whose_callers_have_left(
    graph: Graph, server: Node, client: TriggerClient
) -> None:
    handler = Slow()
    serving = server.create_service(Trigger, "/s", handler)
    await give_up(client, 1)
    serving.close()
    await client.wait_for_handlers()
    assert (handler.ends, graph.failures.late_answers) == ([("cancelled", 1)], 0)
    assert list(graph.failures) == []


async def test_a_node_that_ends_ends_its_handlers_and_tells_their_callers(graph: Graph, client: TriggerClient) -> None:
    handler = Slow()
    async with Node(graph, "brief") as node:
        node.create_service(Trigger, "/s", handler, concurrent=True)
        calls = [asyncio.create_task(client.call(ASK)) for _ in range(3)]
        await anyio.sleep(1)
    ended = await asyncio.gather(*calls, return_exceptions=True)
    assert [type(one) for one in ended] == [ServiceGoneError] * 3
    assert (now(), handler.ends) == (1, [("cancelled", 1)] * 3)
    assert graph.failures.late_answers == 0


async def test_closing_a_service_answers_the_caller_at_once_also_if_the_handler_takes_long_to_end(
    server: Node, client: TriggerClient
) -> None:
    async def stubborn(_request: TriggerRequest) -> SuccessResponse:
        with anyio.CancelScope(shield=True):
            await anyio.sleep(10)
        return answer()

    serving = server.create_service(Trigger, "/s", stubborn)
    call = asyncio.create_task(client.call(ASK, timeout=2))
    await anyio.sleep(1)
    serving.close()
    with pytest.raises(ServiceGoneError):
        await call
    assert now() == 1
    await client.wait_for_handlers()
    assert now() == 10


async def test_handlers_beyond_the_room_of_a_concurrent_service_wait_in_line(
    graph: Graph, server: Node, client: TriggerClient
) -> None:
    handler = Slow(seconds=10)
    server.create_service(Trigger, "/s", handler, concurrent=True)
    async with anyio.create_task_group() as tasks:
        for _ in range(MAX_AT_WORK):
            tasks.start_soon(give_up, client, 1)
    async with anyio.create_task_group() as tasks:
        for _ in range(MAX_WAITING):
            tasks.start_soon(client.call, ASK, 100)
        await anyio.wait_all_tasks_blocked()
        with pytest.raises(ServiceUnavailableError, match="has 1,000 calls waiting already"):
            await client.call(ASK)
    assert (handler.most, len(handler.ends)) == (MAX_AT_WORK, MAX_AT_WORK + MAX_WAITING)
    assert (graph.failures.late_answers, graph.failures.refused_calls) == (MAX_AT_WORK, 1)


async def test_a_service_of_a_node_that_does_not_run_is_served_by_the_callers_task(
    graph: Graph, client: TriggerClient
) -> None:
    handler = Slow()
    node = Node(graph, "idle")
    node.create_service(Trigger, "/s", handler)
    assert await client.call(ASK) == answer("1")
    await give_up(client, 1)
    assert handler.ends == [("done", 3), ("cancelled", 4)]
    node.close()


_seen: ContextVar[str] = ContextVar("_seen")


async def test_all_steps_of_a_handler_see_the_context_variables_of_its_caller_and_change_none(
    server: Node, client: TriggerClient
) -> None:
    async def handle(_request: TriggerRequest) -> SuccessResponse:
        token = _seen.set(f"{_seen.get()} of the handler")
        await anyio.sleep(1)
        message = _seen.get()
        _seen.reset(token)
        return answer(f"{message}, {_seen.get()}")

    server.create_service(Trigger, "/s", handle)
    _seen.set("value")
    for _ in range(2):
        assert await client.call(ASK) == answer("value of the handler, value")
    assert _seen.get() == "value"


@pytest.mark.parametrize("waits_first", [False, True])
@pytest.mark.parametrize("goes_on", [False, True])
async def test_a_handler_that_cancels_its_own_task_fails_itself_alone(
    graph: Graph, server: Node, client: TriggerClient, *, waits_first: bool, goes_on: bool
) -> None:
    is_harmless = False
    inner = server.create_client(Trigger, "/inner")
    server.create_service(Trigger, "/inner", Slow(), concurrent=True)

    async def handle(_request: TriggerRequest) -> SuccessResponse:
        task = asyncio.current_task()
        assert task is not None
        if is_harmless:
            await inner.call(ASK)
            return answer(f"{task.cancelling()}")
        if waits_first:
            await anyio.sleep(1)
        task.cancel()
        if goes_on:
            await anyio.sleep(1)
        return answer("cancelled in vain")

    server.create_service(Trigger, "/s", handle, concurrent=True)
    for pause in (1, 0, 0, 1, 1):
        if goes_on:
            with pytest.raises(ServiceFailedError, match="something that its handler awaited was cancelled"):
                await client.call(ASK)
        else:
            assert await client.call(ASK) == answer("cancelled in vain")
        if pause:
            await anyio.sleep(pause)
    is_harmless = True
    assert await asyncio.gather(*(client.call(ASK) for _ in range(3))) == [answer("0")] * 3
    assert sum(one.count for one in graph.failures) == (5 if goes_on else 0)


async def test_a_handler_whose_caller_gave_up_may_wait_for_its_own_caller_s_service(
    server: Node, client: TriggerClient, run: StartNode
) -> None:
    """A deadlock while the caller waits; none when it has left."""
    other = await run("other")
    to_other = other.create_client(Trigger, "/other")
    outcomes: list[object] = []

    async def first(_request: TriggerRequest) -> SuccessResponse:
        if outcomes:
            return answer("again")
        outcomes.append("called")
        with pytest.raises(ServiceTimeoutError):
            await to_other.call(ASK, 1)
        await anyio.sleep(3)
        return answer("first")

    async def back(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(2)
        outcomes.append(await client.call(ASK))
        return answer("back")

    server.create_service(Trigger, "/s", first)
    other.create_service(Trigger, "/other", back)
    assert await client.call(ASK) == answer("first")
    await to_other.wait_for_handlers()
    assert outcomes == ["called", answer("again")]
