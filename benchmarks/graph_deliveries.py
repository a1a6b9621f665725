"""Deliveries inside the process: one publisher, 1, 10 or 100 listeners.

The cadence is the same for all: a burst of messages is published, then the loop turns until every listener has had
every one of them, then comes the next burst. A listener counts, and does nothing else.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterable, Awaitable, Callable, Iterator
from contextlib import AsyncExitStack
from itertools import repeat
from typing import TypeAlias

from homebot.graph import Graph, Node
from plan import Plan
from reading import Reading, make_reading
from report import Aim, Comparison, Report, compare, per_second
from rounds import Measure, measure_interleaved

__all__ = ["run"]

TOPIC = "/reading"
DELIVERIES = 100_000
HOME_ASSISTANT_DELIVERIES = 20_000

ASYNC = "async callback"
PLAIN = "plain callback"
ITERATE = "async for"
HA_ASYNC = "Home Assistant, async listener"
HA_CALLBACK = "Home Assistant, @callback"
QUEUE = "asyncio.Queue"
BARE = "bare look-up loop"

Publish: TypeAlias = Callable[[Reading], Awaitable[None] | None]


class Counter:
    """Counts deliveries, in the three forms that a listener has."""

    def __init__(self) -> None:
        self.count = 0

    async def asynchronous(self, _message: Reading) -> None:
        self.count += 1

    def plain(self, _message: Reading) -> None:
        self.count += 1


def run(plan: Plan) -> Report:
    comparisons: list[Comparison] = []
    for listeners, burst in ((1, 1), (1, 100), (10, 100), (100, 100)):
        for built in (False, True):
            case = f"1 -> {listeners}{', one at a time' if burst == 1 else ''}, {'built' if built else 'pre-built'}"
            contenders = _contenders(plan, listeners, burst, built=built)
            samples = measure_interleaved(contenders, plan.rounds(7))
            factor = 10 if listeners == 1 else 15
            aims = (Aim("at least", factor), Aim("at least", 0.5)) if burst > 1 else (None, None)
            pairs = [
                (ASYNC, HA_ASYNC, aims[0]),
                (PLAIN, HA_CALLBACK, None),
                (ITERATE, QUEUE, None),
                (ASYNC, BARE, aims[1]),
            ]
            comparisons += compare(case, samples, pairs, per_second)
    return Report("Graph: deliveries per second", comparisons)


def _contenders(plan: Plan, listeners: int, burst: int, *, built: bool) -> dict[str, Measure]:
    messages = max(burst, plan.count(DELIVERIES) // listeners // burst * burst)

    def in_process(contender: Callable[[int, int, int, bool], Awaitable[float]]) -> Measure:
        return lambda: asyncio.run(_as_coroutine(contender(messages, listeners, burst, built)))

    contenders: dict[str, Measure] = {
        ASYNC: in_process(homebot_async_callback),
        PLAIN: in_process(homebot_plain_callback),
        ITERATE: in_process(homebot_async_for),
        QUEUE: in_process(asyncio_queue),
        BARE: in_process(bare_loop),
    }
    if plan.home_assistant is not None:
        events = max(burst, plan.count(HOME_ASSISTANT_DELIVERIES) // listeners // burst * burst)
        facts = {"messages": events, "listeners": listeners, "burst": burst, "built": int(built)}
        contenders[HA_ASYNC] = lambda: plan.ask_home_assistant("deliver", kind="async", **facts)
        contenders[HA_CALLBACK] = lambda: plan.ask_home_assistant("deliver", kind="callback", **facts)
    return contenders


async def _as_coroutine(figure: Awaitable[float]) -> float:
    return await figure


async def homebot_async_callback(messages: int, listeners: int, burst: int, built: bool) -> float:
    counter = Counter()
    return await _through_the_graph(counter, counter.asynchronous, messages, listeners, burst, built)


async def homebot_plain_callback(messages: int, listeners: int, burst: int, built: bool) -> float:
    counter = Counter()
    return await _through_the_graph(counter, counter.plain, messages, listeners, burst, built)


async def homebot_async_for(messages: int, listeners: int, burst: int, built: bool) -> float:
    return await _through_the_graph(Counter(), None, messages, listeners, burst, built)


async def _through_the_graph(
    counter: Counter, callback: Publish | None, messages: int, listeners: int, burst: int, built: bool
) -> float:
    graph = Graph()
    async with AsyncExitStack() as stack:
        node = await stack.enter_async_context(Node(graph, "publisher"))
        publisher = node.create_publisher(Reading, TOPIC, burst)
        for number in range(listeners):
            listener = await stack.enter_async_context(Node(graph, f"listener_{number}"))
            if callback is not None:
                listener.create_subscription(Reading, TOPIC, callback, burst)
                continue
            subscription = listener.create_subscription(Reading, TOPIC, qos_profile=burst)

            async def iterate(subscription: AsyncIterable[Reading] = subscription) -> None:
                async for _message in subscription:
                    counter.count += 1

            listener.create_task(iterate)
        return await _publish_all(publisher.publish, counter, messages, listeners, burst, built)


async def _publish_all(
    publish: Publish, counter: Counter, messages: int, listeners: int, burst: int, built: bool
) -> float:
    """Publish in bursts; return deliveries per second."""
    await asyncio.sleep(0)
    await asyncio.sleep(0)  # every listener waits now
    wanted = 0
    started = time.perf_counter()
    for _ in range(messages // burst):
        for message in _messages(burst, built=built):
            publish(message)
        wanted += burst * listeners
        while counter.count < wanted:
            await asyncio.sleep(0)
    return counter.count / (time.perf_counter() - started)


async def asyncio_queue(messages: int, listeners: int, burst: int, built: bool) -> float:
    """One asyncio.Queue and one task for each listener; ``put_nowait`` into each."""
    counter = Counter()
    queues = [asyncio.Queue[Reading](burst) for _ in range(listeners)]

    async def listen(queue: asyncio.Queue[Reading]) -> None:
        while True:
            await queue.get()
            counter.count += 1

    def publish(message: Reading) -> None:
        for queue in queues:
            queue.put_nowait(message)

    async with asyncio.TaskGroup() as tasks:
        listening = [tasks.create_task(listen(queue)) for queue in queues]
        figure = await _publish_all(publish, counter, messages, listeners, burst, built)
        for task in listening:
            task.cancel()
    return figure


async def bare_loop(messages: int, listeners: int, burst: int, built: bool) -> float:
    """The least a typed bus can do: look up the topic, check the type, await each listener; no queue, no task."""
    counter = Counter()
    topics = {TOPIC: (Reading, [counter.asynchronous] * listeners)}

    async def publish(topic: str, message: Reading) -> None:
        message_type, callbacks = topics[topic]
        if message.__class__ is not message_type:
            raise TypeError(topic)
        for callback in callbacks:
            await callback(message)

    started = time.perf_counter()
    for _ in range(messages // burst):
        for message in _messages(burst, built=built):
            await publish(TOPIC, message)
        await asyncio.sleep(0)
    return counter.count / (time.perf_counter() - started)


def _messages(burst: int, *, built: bool) -> Iterator[Reading]:
    return map(make_reading, range(burst)) if built else repeat(_READY, burst)


_READY = make_reading(0)
