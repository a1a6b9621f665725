"""Whatever comes out of one app's code ends or costs nobody else anything.

Every place where a runtime runs the code of an app, against every kind of thing that may come out of it.
"""

import asyncio
import sys
from collections.abc import Callable
from typing import Any, ClassVar, NoReturn

import anyio
import anyio.lowlevel
import pytest
from pydantic import BaseModel

from homebot.apps import App
from homebot.config import parse_config
from homebot.errors import ParameterError, ServiceFailedError
from homebot.graph import Node, Parameter
from homebot.messages import String, Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest
from homebot.runtime import Runtime
from homebot.support.isolation import run_as
from homebot.testing import FakeGateway

pytestmark = [
    pytest.mark.virtual_time,
    # A GeneratorExit ends a coroutine as if it were thrown away.
    pytest.mark.filterwarnings("ignore:coroutine .* was never awaited"),
]


async def _await_a_cancelled_task() -> None:
    task = asyncio.create_task(anyio.sleep_forever())
    await anyio.lowlevel.checkpoint()
    task.cancel()
    await task


async def _await_what_a_scope_cancelled() -> None:
    """The error says that a scope of anyio was cancelled, as one of ours says; but it is not one of ours."""
    scope = anyio.CancelScope()
    broken: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def cancelled() -> None:
        with scope:
            try:
                await anyio.sleep_forever()
            except asyncio.CancelledError as exc:
                broken.cancel(exc.args[0])
                raise

    task = asyncio.create_task(cancelled())
    await anyio.lowlevel.checkpoint()
    scope.cancel()
    try:
        await broken
    finally:
        await asyncio.gather(task, return_exceptions=True)


async def _cancel_itself() -> None:
    task = asyncio.current_task()
    assert task is not None
    task.cancel()
    await anyio.lowlevel.checkpoint()


def _raising(error: Callable[[], BaseException]) -> Callable[[], Any]:
    async def fail() -> NoReturn:
        await anyio.lowlevel.checkpoint()
        raise error()

    return fail


KINDS: dict[str, Callable[[], Any]] = {
    "exception": _raising(lambda: ValueError("ouch")),
    "stray cancellation": _await_a_cancelled_task,
    "stray cancellation of a scope": _await_what_a_scope_cancelled,
    "raised cancellation": _raising(asyncio.CancelledError),
    "own cancellation": _cancel_itself,
    "SystemExit": _raising(lambda: SystemExit(3)),
    "GeneratorExit": _raising(GeneratorExit),
    "group": _raising(lambda: BaseExceptionGroup("", [SystemExit(1), asyncio.CancelledError(), ValueError("ouch")])),
}

SITES = ("run", "task", "handler", "concurrent handler", "timer", "follow", "end")


class Hostile(App):
    """Does what it was told to where it was told to."""

    kind: ClassVar[str] = ""
    site: ClassVar[str] = ""
    handled: ClassVar[list[str]] = []

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        self.fail = KINDS[self.kind]
        if "handler" in self.site:
            node.create_subscription(String, "/work", self.handle, concurrent=self.site.startswith("concurrent"))
        elif self.site == "timer":
            node.create_timer(1, self.tick)
        elif self.site == "task":
            node.create_task(self.fail)

    async def handle(self, message: String) -> None:
        self.handled.append(message.data)
        if message.data == "bad":
            await self.fail()

    async def tick(self) -> None:
        self.handled.append("tick")
        if len(self.handled) == 1:
            await self.fail()

    async def run(self) -> None:
        if self.site == "run":
            await self.fail()
        if self.site == "follow":
            async for _change in self.devices.follow("lights"):
                await self.fail()
        try:
            await anyio.sleep_forever()
        finally:
            if self.site == "end":
                with anyio.CancelScope(shield=True):
                    await self.fail()


class Steady(App):
    """Counts the seconds, and answers."""

    seconds: ClassVar[int] = 0
    starts: ClassVar[int] = 0

    async def run(self) -> None:
        Steady.starts += 1
        self.node.create_service(Trigger, "/steady", lambda _request: SuccessResponse(success=True, message="here"))
        while True:
            await anyio.sleep(1)
            Steady.seconds += 1


@pytest.fixture(autouse=True)
def _anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])
    Steady.seconds = Steady.starts = 0
    Hostile.handled.clear()


def _runtime(*apps: type[App]) -> Runtime:
    tables = {kind.__name__.lower(): {"class": f"{__name__}:{kind.__name__}"} for kind in apps}
    return Runtime(parse_config({"apps": tables}, "test"), with_door=False)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("site", SITES)
async def test_what_comes_out_of_an_app_costs_nobody_else_anything(
    kind: str, site: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Hostile, "kind", kind)
    monkeypatch.setattr(Hostile, "site", site)
    with anyio.fail_after(60):
        async with _runtime(Hostile, Steady) as runtime:
            node = Node(runtime.graph, "outside")
            publisher = node.create_publisher(String, "/work", 100)
            for word in ("good", "bad", "good", "bad", "good"):
                publisher.publish(String(data=word))
            FakeGateway(Node(runtime.graph, "fake", namespace="/gateway")).sees("lights/lamp")
            await anyio.sleep(10)
            assert (Steady.starts, Steady.seconds) == (1, 9)
            assert (await node.create_client(Trigger, "/steady").call(Trigger.Request())).message == "here"
            crashes, failures = runtime.supervisor.crashes, {one.node: one.count for one in runtime.graph.failures}
            if "handler" in site:
                assert Hostile.handled == ["good", "bad", "good", "bad", "good"]
                assert (crashes, failures) == ({}, {"/hostile": 2})
            elif site == "timer":
                assert len(Hostile.handled) >= 9
                assert (crashes, failures) == ({}, {"/hostile": 1})
            elif site == "end":
                assert (crashes, failures) == ({}, {})
            else:
                assert failures == {}
                assert crashes["hostile"].count >= 2
                assert crashes["hostile"].state in {"running again", "given up", "restarting"}
    if site == "end" and "cancellation" not in kind:  # one that ends by a cancellation when it is to end has obeyed
        assert runtime.supervisor.crashes["hostile"].state == "stopped"


@pytest.mark.parametrize("kind", KINDS)
async def test_what_comes_out_of_a_service_is_an_error_of_its_caller_that_both_outlive(kind: str) -> None:
    async with _runtime(Steady) as runtime, Node(runtime.graph, "server") as server, Node(runtime.graph, "x") as caller:

        async def serve(_request: TriggerRequest) -> SuccessResponse:
            await KINDS[kind]()
            raise AssertionError

        server.create_service(Trigger, "/hostile", serve)
        client = caller.create_client(Trigger, "/hostile")
        answers: list[BaseException | None] = []

        async def ask(_message: String) -> None:
            try:
                await client.call(Trigger.Request())
            except ServiceFailedError as exc:
                answers.append(exc)

        caller.create_subscription(String, "/ask", ask)
        publisher = caller.create_publisher(String, "/ask")
        await anyio.sleep(0.1)  # so that no second of the app ends with one of these
        for _ in range(3):
            publisher.publish(String(data=""))
            await anyio.sleep(1)
        await anyio.sleep(0.5)  # the third second of the app ends at the same instant
        assert len(answers) == 3
        assert {one.node: one.count for one in runtime.graph.failures} == {"/server": 3}
        assert (Steady.starts, Steady.seconds) == (1, 3)


@pytest.mark.parametrize("error", [ValueError, asyncio.CancelledError, SystemExit, GeneratorExit])
async def test_a_check_of_a_parameter_that_fails_refuses_the_value(error: type[BaseException]) -> None:
    def check(_parameter: Parameter) -> str | None:
        raise error

    async with _runtime(Steady) as runtime, Node(runtime.graph, "node") as node:
        node.declare_parameter("level", 1)
        node.parameters.add_on_set_callback(check)
        with pytest.raises(ParameterError, match="its check failed"):
            node.parameters.set("level", 2)
        assert node.get_parameter("level").value == 1
        assert [(one.node, one.callback, one.count) for one in runtime.graph.failures] == [
            ("/node", "check of parameter level", 1)
        ]


@pytest.mark.parametrize("site", ["run", "handler", "timer", "task"])
@pytest.mark.parametrize("kind", ["stray cancellation", "raised cancellation", "own cancellation"])
async def test_a_real_end_is_never_taken_for_a_stray_cancellation_also_when_both_come_at_once(
    kind: str, site: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The runtime is left while the app's own cancellation is under way: it ends, at once and for good."""
    monkeypatch.setattr(Hostile, "kind", kind)
    monkeypatch.setattr(Hostile, "site", site)
    for steps in range(12):
        runtime = _runtime(Hostile)
        with anyio.fail_after(5):
            async with runtime:
                node = Node(runtime.graph, "outside")
                node.create_publisher(String, "/work").publish(String(data="bad"))
                if site == "timer":
                    await anyio.sleep(1)
                for _ in range(steps):
                    await asyncio.sleep(0)
        assert runtime.graph.get_node("/hostile") is None


async def test_a_runtime_that_is_cancelled_from_outside_ends_as_cancelled() -> None:
    """As by ``asyncio.timeout`` around it: the cancellation reaches who asked for it."""

    async def run() -> None:
        async with asyncio.timeout(3), _runtime(Steady):
            await anyio.sleep_forever()

    with pytest.raises(TimeoutError):
        await run()
    assert Steady.seconds >= 2


async def test_the_end_of_a_keyboard_interrupt_is_the_program() -> None:
    async def interrupt() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        await run_as("app", interrupt)
