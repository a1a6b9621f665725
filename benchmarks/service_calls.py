"""Service calls, one after the other: the caller waits for each."""

from __future__ import annotations

import asyncio
import time

from homebot.graph import Graph, Node
from homebot.messages import Message, ServiceType
from plan import Plan
from report import Aim, Report, compare, per_second
from rounds import Measure, measure_interleaved

__all__ = ["run"]

CALLS = 50_000
HOME_ASSISTANT_CALLS = 10_000

ASYNC = "async handler"
PLAIN = "plain handler"
HA_ASYNC = "Home Assistant, async handler"
HA_CALLBACK = "Home Assistant, @callback"


class AddRequest(Message):
    a: int
    b: int


class AddResponse(Message):
    sum: int


Add = ServiceType("bench/srv/Add", AddRequest, AddResponse)

RESPONSE = AddResponse(sum=3)


def run(plan: Plan) -> Report:
    calls = plan.count(CALLS)
    contenders: dict[str, Measure] = {
        ASYNC: lambda: asyncio.run(homebot_calls(calls, is_async=True)),
        PLAIN: lambda: asyncio.run(homebot_calls(calls, is_async=False)),
    }
    if plan.home_assistant is not None:
        contenders[HA_ASYNC] = lambda: plan.ask_home_assistant(
            "call", kind="async", calls=plan.count(HOME_ASSISTANT_CALLS)
        )
        contenders[HA_CALLBACK] = lambda: plan.ask_home_assistant(
            "call", kind="callback", calls=plan.count(HOME_ASSISTANT_CALLS)
        )
    samples = measure_interleaved(contenders, plan.rounds(7))
    pairs = [(ASYNC, HA_ASYNC, Aim("at least", 4)), (PLAIN, HA_CALLBACK, None)]
    return Report("Services: calls per second", compare("request pre-built", samples, pairs, per_second))


async def homebot_calls(calls: int, *, is_async: bool) -> float:
    async def answer(_request: AddRequest) -> AddResponse:
        return RESPONSE

    def answer_now(_request: AddRequest) -> AddResponse:
        return RESPONSE

    graph = Graph()
    async with Node(graph, "server") as server, Node(graph, "caller") as caller:
        server.create_service(Add, "/add", answer if is_async else answer_now)
        call, request = caller.create_client(Add, "/add").call, AddRequest(a=1, b=2)
        started = time.perf_counter()
        for _ in range(calls):
            await call(request)
        return calls / (time.perf_counter() - started)
