"""Services: what each kind of server does to its callers, and that nobody ever hangs."""

import asyncio
from collections.abc import Awaitable, Callable

import anyio
import pytest

from homebot.errors import (
    ClosedError,
    DuplicateNameError,
    ServiceFailedError,
    ServiceGoneError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TypeMismatchError,
    UsageError,
)
from homebot.graph import Client, Graph, Node, Service
from homebot.messages import SetBool, String, Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest

TriggerClient = Client[TriggerRequest, SuccessResponse]

ASK = TriggerRequest()
pytestmark = pytest.mark.virtual_time


def answer(message: str = "") -> SuccessResponse:
    return SuccessResponse(success=True, message=message)


class Gate:
    """A handler that waits to be let on, and notes what happens to it."""

    def __init__(self) -> None:
        self.opened = anyio.Event()
        self.started = 0
        self.running = 0
        self.most = 0
        self.cancelled = 0

    async def __call__(self, _request: TriggerRequest) -> SuccessResponse:
        self.started += 1
        self.running += 1
        self.most = max(self.most, self.running)
        try:
            await self.opened.wait()
        except asyncio.CancelledError:
            self.cancelled += 1
            raise
        finally:
            self.running -= 1
        return answer(str(self.started))


@pytest.fixture
def gate() -> Gate:
    return Gate()


@pytest.fixture
def client(node: Node) -> TriggerClient:
    return node.create_client(Trigger, "s")


def now() -> float:
    return asyncio.get_running_loop().time()


async def answer_later(_request: TriggerRequest) -> SuccessResponse:
    await anyio.sleep(1)
    await anyio.lowlevel.checkpoint()
    await anyio.sleep(1)
    return answer("yes")


async def answer_at_once(_request: TriggerRequest) -> SuccessResponse:
    return answer("yes")


def promise(_request: TriggerRequest) -> asyncio.Future[SuccessResponse]:
    future = asyncio.get_running_loop().create_future()
    asyncio.get_running_loop().call_later(1, future.set_result, answer("yes"))
    return future


@pytest.mark.parametrize(
    ("handler", "seconds"),
    [(lambda _request: answer("yes"), 0), (answer_at_once, 0), (answer_later, 2), (promise, 1)],
    ids=["function", "coroutine", "waiting coroutine", "another awaitable"],
)
async def test_each_kind_of_handler_answers(
    node: Node, client: TriggerClient, handler: Callable[[TriggerRequest], SuccessResponse], seconds: float
) -> None:
    node.create_service(Trigger, "s", handler)
    assert await client.call(ASK) == answer("yes")
    assert now() == seconds


def refuse(_request: TriggerRequest) -> SuccessResponse:
    raise UsageError("there is no such lamp")


async def fail_in_a_group(_request: TriggerRequest) -> SuccessResponse:
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(fail_later)
    return answer()


async def fail_later() -> None:
    await anyio.sleep(1)
    raise ValueError("no such lamp")


async def exceed_a_limit(_request: TriggerRequest) -> SuccessResponse:
    with anyio.fail_after(1):
        await anyio.sleep_forever()
    return answer()


async def wait_for_the_dead(_request: TriggerRequest) -> SuccessResponse:
    doomed: asyncio.Future[SuccessResponse] = asyncio.get_running_loop().create_future()
    asyncio.get_running_loop().call_later(1, doomed.cancel)
    return await doomed


@pytest.mark.parametrize(
    ("handler", "problem"),
    [
        (refuse, "service /s failed: there is no such lamp"),
        (fail_in_a_group, "service /s failed: ValueError: no such lamp"),
        (exceed_a_limit, "TimeoutError"),
        (wait_for_the_dead, "something that its handler awaited was cancelled"),
        (lambda _request: String(data="x"), r"the server returned String\(data='x'\), which is not its response"),
    ],
    ids=["refusal", "task group", "time-out", "cancelled future", "response of another type"],
)
async def test_a_failure_of_the_server_is_told_to_its_caller(
    node: Node, client: TriggerClient, handler: Callable[[TriggerRequest], SuccessResponse], problem: str
) -> None:
    node.create_service(Trigger, "s", handler)
    with pytest.raises(ServiceFailedError, match=problem):
        await client.call(ASK)


async def test_without_a_server_a_call_fails_at_once(client: TriggerClient) -> None:
    with pytest.raises(ServiceUnavailableError, match="service /s has no server; wait for it"):
        await client.call(ASK)
    assert now() == 0


@pytest.mark.parametrize("waits", [False, True])
async def test_a_raising_server_gives_its_reason_and_cause_and_goes_on(
    node: Node, client: TriggerClient, *, waits: bool
) -> None:
    async def fail(_request: TriggerRequest) -> SuccessResponse:
        if waits:
            await anyio.sleep(1)
        raise ValueError("no such lamp")

    node.create_service(Trigger, "s", fail)
    for _ in range(2):
        with pytest.raises(ServiceFailedError) as caught:
            await client.call(ASK)
        assert str(caught.value) == "service /s failed: ValueError: no such lamp"
        assert caught.value.reason == "ValueError: no such lamp"
        assert isinstance(caught.value.__cause__, ValueError)


async def test_a_request_of_another_type_is_refused(node: Node, client: TriggerClient) -> None:
    node.create_service(Trigger, "s", lambda _request: answer())
    with pytest.raises(TypeMismatchError, match="/s takes a TriggerRequest, got a String"):
        await client.call(String(data="x"))  # type: ignore[arg-type]  # the mistake under test


async def test_a_call_has_a_time_limit_by_default(node: Node, client: TriggerClient, gate: Gate) -> None:
    node.create_service(Trigger, "s", gate)
    with pytest.raises(ServiceTimeoutError, match=r"service /s did not answer within 5 s"):
        await client.call(ASK)
    assert now() == 5


async def test_a_dying_server_ends_the_calls_in_its_line_too(node: Node, client: TriggerClient, gate: Gate) -> None:
    server = node.create_service(Trigger, "s", gate)
    calls = [asyncio.create_task(client.call(ASK)) for _ in range(3)]
    await anyio.wait_all_tasks_blocked()
    closed_at = now()
    server.close()
    server.close()
    ended = await asyncio.gather(*calls, return_exceptions=True)
    assert [str(one) for one in ended] == [str(ServiceGoneError("/s"))] * 3
    assert (gate.started, gate.cancelled, now()) == (1, 1, closed_at)


async def test_a_server_may_close_itself_while_it_answers(node: Node, client: TriggerClient) -> None:
    servers: list[Service[TriggerRequest, SuccessResponse]] = []

    async def last(_request: TriggerRequest) -> SuccessResponse:
        servers[0].close()
        await anyio.sleep(1)
        return answer("last")

    servers.append(node.create_service(Trigger, "s", last))
    assert await client.call(ASK) == answer("last")
    assert not client.service_is_ready()


async def test_the_time_limit_covers_the_line(node: Node, client: TriggerClient) -> None:
    async def slow(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(3)
        return answer()

    node.create_service(Trigger, "s", slow)
    times: list[tuple[str, float]] = []

    async def call(name: str, timeout: float) -> None:
        try:
            await client.call(ASK, timeout)
        except ServiceTimeoutError:
            times.append((f"{name} gave up", now()))
        else:
            times.append((name, now()))

    async with anyio.create_task_group() as tasks:
        for name, timeout in (("first", 10), ("in line", 2), ("at work", 5), ("last", 20)):
            tasks.start_soon(call, name, timeout)
    assert times == [("in line gave up", 2), ("first", 3), ("at work gave up", 5), ("last", 9)]


async def test_a_handler_that_ends_with_its_caller_is_closed_with_an_abandoned_call(
    node: Node, client: TriggerClient, gate: Gate
) -> None:
    server = node.create_service(Trigger, "s", gate)
    call = client.call(ASK, cancel_with_caller=True)
    call.send(None)
    assert (gate.running, server.room) == (1, 0)
    call.close()
    assert (gate.running, server.room) == (0, 1)


async def test_what_a_handler_ended_with_when_its_caller_was_cancelled_at_once_is_dropped(
    node: Node, client: TriggerClient, graph: Graph
) -> None:
    async def cancel_its_caller(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(1)
        asyncio.get_running_loop().call_soon(call.cancel)  # before the caller's turn comes, after the answer
        return answer()

    node.create_service(Trigger, "s", cancel_its_caller)
    call = asyncio.ensure_future(client.call(ASK))
    await asyncio.wait([call])
    assert call.cancelled()
    assert graph.failures.late_answers == 1


async def test_it_is_told_so_also_round_another_service(node: Node, client: TriggerClient) -> None:
    other = node.create_client(Trigger, "other")

    async def there(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(1)
        return await other.call(ASK)

    async def back(_request: TriggerRequest) -> SuccessResponse:
        return await client.call(ASK)

    node.create_service(Trigger, "s", there)
    node.create_service(Trigger, "other", back)
    with pytest.raises(ServiceFailedError, match="the handler of /s calls itself"):
        await client.call(ASK)


async def test_one_in_line_whose_handler_calls_itself_is_told_so(node: Node, client: TriggerClient) -> None:
    async def recurse(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(1)
        return await client.call(ASK)

    node.create_service(Trigger, "s", recurse)
    ended = await asyncio.gather(*(client.call(ASK) for _ in range(3)), return_exceptions=True)
    assert [isinstance(one, ServiceFailedError) and "calls itself" in one.reason for one in ended] == [True] * 3


async def test_a_concurrent_handler_may_call_itself(node: Node, client: TriggerClient) -> None:
    depth = 0

    async def recurse(_request: TriggerRequest) -> SuccessResponse:
        nonlocal depth
        depth += 1
        await anyio.lowlevel.checkpoint()
        return await client.call(ASK) if depth < 5 else answer("bottom")

    node.create_service(Trigger, "s", recurse, concurrent=True)
    assert await client.call(ASK) == answer("bottom")


@pytest.mark.parametrize(
    ("inner_timeout", "outer_timeout", "error"),
    [(1, 5, ServiceFailedError), (5, 1, ServiceTimeoutError)],
)
async def test_a_nested_time_limit_ends_the_call_it_belongs_to(
    node: Node,
    client: TriggerClient,
    inner_timeout: float,
    outer_timeout: float,
    error: type[Exception],
) -> None:
    inner = node.create_client(Trigger, "inner")

    async def outer_handler(_request: TriggerRequest) -> SuccessResponse:
        return await inner.call(ASK, inner_timeout)

    async def forever(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep_forever()
        return answer()

    node.create_service(Trigger, "s", outer_handler)
    node.create_service(Trigger, "inner", forever)
    with pytest.raises(error):
        await client.call(ASK, outer_timeout)
    assert now() == 1


async def test_a_handler_may_run_tasks_of_its_own(node: Node, client: TriggerClient) -> None:
    done: list[int] = []

    async def work(number: int) -> None:
        await anyio.sleep(number)
        done.append(number)

    async def spread(_request: TriggerRequest) -> SuccessResponse:
        async with anyio.create_task_group() as tasks:
            for number in (3, 1, 2):
                tasks.start_soon(work, number)
        return answer()

    node.create_service(Trigger, "s", spread)
    await client.call(ASK)
    assert done == [1, 2, 3]
    with pytest.raises(ServiceTimeoutError):
        await client.call(ASK, timeout=1.5)
    assert done == [1, 2, 3, 1]


async def test_waiting_for_a_server_ends_when_it_comes(node: Node, client: TriggerClient) -> None:
    waiting = asyncio.create_task(client.wait_for_service())
    await anyio.sleep(3)
    node.create_service(Trigger, "s", lambda _request: answer())
    assert await waiting
    assert now() == 3
    assert await client.wait_for_service(timeout=0)
    assert client.service_is_ready()


async def test_waiting_goes_on_when_a_server_came_and_went(node: Node, client: TriggerClient) -> None:
    waiting = asyncio.create_task(client.wait_for_service(timeout=2))
    await anyio.wait_all_tasks_blocked()
    node.create_service(Trigger, "s", lambda _request: answer()).close()
    assert not await waiting
    assert now() == 2


async def test_a_closed_client_is_refused_and_stops_waiting(node: Node, client: TriggerClient) -> None:
    waiting = asyncio.create_task(client.wait_for_service())
    await anyio.wait_all_tasks_blocked()
    client.close()
    client.close()
    with pytest.raises(ClosedError, match="the client of /node for /s is closed"):
        await waiting
    node.create_service(Trigger, "s", lambda _request: answer())
    with pytest.raises(ClosedError):
        await client.call(ASK)


async def test_a_second_server_on_one_name_is_refused(run: Callable[[str], Awaitable[Node]]) -> None:
    one, other = await run("one"), await run("other")
    first = one.create_service(Trigger, "/s", lambda _request: answer())
    with pytest.raises(DuplicateNameError, match="/s is already served by /one"):
        other.create_service(Trigger, "/s", lambda _request: answer())
    first.close()
    assert other.create_service(Trigger, "/s", lambda _request: answer()).service_name == "/s"


async def test_another_type_on_a_service_name_is_refused(node: Node, client: TriggerClient, graph: Graph) -> None:
    with pytest.raises(
        TypeMismatchError, match="/node uses /s as std_srvs/srv/SetBool, but it is a std_srvs/srv/Trigger"
    ):
        node.create_service(SetBool, "s", lambda _request: SetBool.Response(success=True, message=""))
    with pytest.raises(TypeMismatchError):
        node.create_client(SetBool, "s")
    client.close()
    assert graph.get_service_type("/s") is None


async def test_a_service_whose_server_cannot_be_loaded_says_why_at_each_use_until_it_can(graph: Graph) -> None:
    problems = [ImportError("no module acme"), ImportError("no module acme")]

    async with Node(graph, "late") as node, Node(graph, "other") as other:

        def start() -> None:
            if problems:
                raise problems.pop()
            node.create_service(Trigger, "/one", lambda _: answer())

        node.offer_service("std_srvs/srv/Trigger", "/one", start)
        for _ in range(2):
            with pytest.raises(ImportError, match="acme"):
                await other.create_client(Trigger, "/one").call(Trigger.Request())
        assert (await other.create_client(Trigger, "/one").call(Trigger.Request())).success


async def test_the_types_of_services_are_listed_although_the_first_call_of_one_withdraws_another(graph: Graph) -> None:
    async with Node(graph, "late") as node:

        def start() -> None:
            node.create_service(Trigger, "/one", lambda _: answer())
            graph.get_service_type("/two")  # starts that as well

        node.offer_service("std_srvs/srv/Trigger", "/one", start)
        node.offer_service("std_srvs/srv/Empty", "/two", lambda: None)
        assert Trigger in graph.get_service_types(lambda _: True)


async def test_calls_without_a_caller_keep_the_limit_of_their_server(
    node: Node, client: TriggerClient, gate: Gate
) -> None:
    """One runs at a time, 1,000 wait, and more are dropped and counted."""
    node.create_service(Trigger, "s", gate)
    for _ in range(5000):
        client.send(ASK)
    await anyio.wait_all_tasks_blocked()
    assert (gate.started, node.graph.failures.refused_calls) == (1, 3999)
    gate.opened.set()
    await anyio.sleep(1)
    assert (gate.started, gate.most, gate.running) == (1001, 1, 0)
    await client.call(ASK)


async def test_a_handler_may_send_its_own_service_a_call_for_later(node: Node, client: TriggerClient) -> None:
    seen = []

    async def again(_request: TriggerRequest) -> SuccessResponse:
        seen.append(now())
        if len(seen) < 3:
            client.send(ASK)
        await anyio.sleep(1)
        return answer()

    node.create_service(Trigger, "s", again)
    client.send(ASK)
    await anyio.sleep(10)
    assert [at - seen[0] for at in seen] == [0, 1, 2]


async def test_calls_without_a_caller_that_wait_end_with_their_server(
    node: Node, client: TriggerClient, gate: Gate
) -> None:
    service = node.create_service(Trigger, "s", gate)
    for _ in range(3):
        client.send(ASK)
    await anyio.wait_all_tasks_blocked()
    service.close()
    await anyio.wait_all_tasks_blocked()
    assert (gate.started, gate.running, len(service.line)) == (1, 0, 0)
    node.create_service(Trigger, "s", lambda _request: answer("new"))
    assert (await client.call(ASK)).message == "new"


async def test_what_an_offered_service_loads_is_loaded_before_its_first_call_and_not_when_a_client_is_made() -> None:
    """In a thread: a client inside the process loaded the modules of a server while everything else waited."""
    graph, steps = Graph(), list[str]()
    async with Node(graph, "late") as node, Node(graph, "caller") as caller:

        def start() -> None:
            steps.append("start")
            node.create_service(Trigger, "/one", lambda _: answer())

        node.offer_service("std_srvs/srv/Trigger", "/one", start, lambda: steps.append("load"))
        client = caller.create_client(Trigger, "/one")
        assert client.service_is_ready()
        assert steps == []
        assert (await client.call(Trigger.Request())).success
        await client.call(Trigger.Request())
        assert steps == ["load", "start"]
        node.offer_service("std_srvs/srv/Trigger", "/two", lambda: None, lambda: None)
        gone = caller.create_client(Trigger, "/two")
    assert not gone.service_is_ready()
