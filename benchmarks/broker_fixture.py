"""What a test with ``mqtt_broker`` costs, next to a trivial echo server, and its client's part next to Mosquitto."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from functools import partial

from fixture_clients import ANSWER, CLIENTS, PAYLOAD, TOPIC, TestSteps
from homebot.testing.mqtt import BrokerThread, TestBroker, broker_thread, serve_broker
from mosquitto import mosquitto
from plan import Plan
from report import Aim, Comparison, Report, compare, milliseconds
from rounds import Measure, measure_interleaved, median

__all__ = ["run"]

TITLE = "One test with a broker of its own"
ROUNDS = 10
TESTS = 20  # in one round
ECHO = "echo server"
OURS = "mqtt_broker"
PEER = "Mosquitto"
RAW = "raw asyncio client"
EXCHANGES = 4  # CONNECT, SUBSCRIBE, PUBLISH, and one for `expect`


def run(plan: Plan) -> Report:
    rounds, tests = plan.rounds(ROUNDS), plan.count(TESTS)
    comparisons: list[Comparison] = []
    with broker_thread() as thread:
        contenders: dict[str, Measure] = {
            name: partial(repeated, tests, partial(fresh_broker, thread, steps)) for name, steps in CLIENTS.items()
        }
        contenders[ECHO] = lambda: repeated(tests, lambda: asyncio.run(echo()))
        samples = measure_interleaved(contenders, rounds)
        pairs = [(name, ECHO, Aim("at most", 3) if name == RAW else None) for name in CLIENTS]
        comparisons += compare("whole test", samples, pairs, milliseconds)
        notes, missing = [f"Each figure is the median of {rounds * tests} tests."], []
        if plan.mosquitto is None:
            missing.append("the client's part, as Mosquitto is not installed")
        else:
            comparisons += beside_mosquitto(thread, plan.mosquitto, rounds, tests)
    return Report(TITLE, comparisons, notes, missing=missing)


def beside_mosquitto(thread: BrokerThread, program: str, rounds: int, tests: int) -> list[Comparison]:
    """The same steps with brokers that are there already, so that Mosquitto's start is left out."""
    comparisons: list[Comparison] = []
    with serve_broker(thread, TestBroker) as broker, mosquitto(program) as peer:
        for name, steps in CLIENTS.items():
            contenders: dict[str, Measure] = {
                title: partial(repeated, tests, partial(meet, port, steps))
                for title, port in ((OURS, broker.port), (PEER, peer))
            }
            samples = measure_interleaved(contenders, rounds)
            comparisons += compare(f"client's part: {name}", samples, [(OURS, PEER, None)], milliseconds)
    return comparisons


def repeated(tests: int, test: Callable[[], None]) -> float:
    """Seconds that the median of *tests* tests takes."""
    times = []
    for _ in range(tests):
        started = time.perf_counter()
        test()
        times.append(time.perf_counter() - started)
    return median(times)


def fresh_broker(thread: BrokerThread, steps: TestSteps) -> None:
    with serve_broker(thread, TestBroker) as broker:

        async def check() -> None:
            await broker.expect(TOPIC, PAYLOAD)

        asyncio.run(steps(broker.port, check))


def meet(port: int, steps: TestSteps) -> None:
    asyncio.run(steps(port, nothing))


async def nothing() -> None:
    pass


async def echo() -> None:
    async with await asyncio.start_server(answer, "127.0.0.1", 0) as server:
        reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
        for _ in range(EXCHANGES):
            writer.write(ANSWER)
            await reader.readexactly(len(ANSWER))
        writer.close()
        await writer.wait_closed()


async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(1024):
        writer.write(data)
    writer.close()
