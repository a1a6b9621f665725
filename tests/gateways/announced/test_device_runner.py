"""The work with one device: tried again, listed in time, reported as lost, and over when it is stopped."""

from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass

import anyio
import pytest

from homebot.devices import Sighting
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.errors import LinkError, RefusedError
from homebot.gateways.announced.device_runner import LISTED_WITHIN, SLEEPER_WITHIN, DeviceRunner, problems_of
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node, Subscription
from homebot.support.backoff import DEVICE_REFUSED_BACKOFF, Backoff
from homebot.testing.gateway_contract.steps import listen

pytestmark = pytest.mark.virtual_time

LAMP = GatewayDevice("hall", "Hall", (simple_part("light", settable=("on_off",)),))
NOTE = GatewayDevice("hall", "Hall")
STEADY = Backoff(first=2.0, factor=2.0, cap=8.0, late_cap=8.0, late_after=1e9, jitter=0.0)
"""Pauses of 2, 4 and 8 seconds."""


@dataclass
class Attempt:
    """What happens to one connection: it lasts *lasts* seconds, ends with *error*, and answers where it *answers*."""

    error: Exception | None
    lasts: float = 0.0
    answers: bool = False


class Runner(DeviceRunner):
    """Makes the connections of a plan, one after the other; the last one lasts.

    Attributes:
        began: The times of the attempts, in seconds from the beginning.
    """

    def __init__(self, gateway: MemoryGateway, plan: Iterable[Attempt]) -> None:
        clock = gateway.node.graph.clock
        super().__init__("Hall", "hall", gateway.devices, STEADY)
        self._plan = iter(plan)
        self._start = clock.monotonic()
        self.began: list[float] = []

    async def work(self) -> None:
        self.began.append(round(self.clock.monotonic() - self._start, 2))
        attempt = next(self._plan, None)
        if attempt is None:
            await anyio.sleep_forever()
            return
        if attempt.answers:
            self.on_answer()
            self._devices.put(LAMP, "it answers")
            self.report_reachable(reachable=True)
        try:
            await anyio.sleep(attempt.lasts)
        finally:
            if attempt.error is not None:
                raise attempt.error

    def list_unheard(self) -> None:
        self._devices.put(NOTE, "somebody says so", confirmed=False)


@dataclass
class House:
    """A runner in its gateway, and what the gateway says."""

    runner: Runner
    gateway: MemoryGateway
    sightings: Subscription[Sighting]
    reports: Subscription[Report]

    def reached(self) -> list[object]:
        """Return what was reported of whether the device can be reached, since the last call."""
        taken = iter(self.reports.take, None)
        return [one.value.plain() for report in taken for one in report.readings if one.capability == REACHABLE]


@asynccontextmanager
async def house(*plan: Attempt) -> AsyncIterator[House]:
    graph = Graph()
    async with (
        Node(graph, "memory", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        anyio.create_task_group() as tasks,
    ):
        gateway = MemoryGateway(node)
        await tasks.start(gateway.serve)
        sightings = listen(watcher, Sighting, gateway.names.received_topics)
        reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=1000)
        runner = Runner(gateway, plan)
        tasks.start_soon(runner.run)
        yield House(runner, gateway, sightings, reports)
        tasks.cancel_scope.cancel()


async def test_pauses_grow_until_a_connection_lasts() -> None:
    gone = LinkError("it is gone")
    async with house(*[Attempt(gone)] * 4, Attempt(gone, lasts=100.0, answers=True), Attempt(gone)) as home:
        await anyio.sleep(200)
        assert home.runner.began == [0, 2, 6, 14, 22, 124, 128]


async def test_a_device_that_does_not_answer_is_listed_in_time_by_what_is_known_of_it() -> None:
    async with house(Attempt(LinkError("it is gone"), lasts=100.0)) as home:
        await anyio.sleep(LISTED_WITHIN - 0.1)
        assert not home.gateway.devices.keys
        await anyio.sleep(0.2)
        assert home.gateway.devices.keys == ("hall",)
        assert not (await home.sightings.receive()).parts


async def test_a_lost_device_stays_and_cannot_be_reached_until_it_answers() -> None:
    gone = LinkError("it is gone")
    plan = Attempt(gone, lasts=1.0, answers=True), Attempt(gone), Attempt(None, 1000.0, answers=True)
    async with house(*plan) as home:
        await anyio.sleep(0.5)
        assert home.reached() == [True]
        await anyio.sleep(1)
        assert home.reached() == [False]
        assert (home.runner.problem, home.runner.needs_help) == ("it is gone", False)
        await anyio.sleep(10)
        assert home.reached() == [True]
        assert home.runner.problem == ""
        assert home.gateway.devices.keys == ("hall",)


async def test_of_a_device_that_sleeps_nothing_is_known() -> None:
    async with house(Attempt(LinkError("it is gone"), lasts=1.0, answers=True)) as home:
        home.runner.sleeps = True
        await anyio.sleep(2)
        assert home.reached() == [True, None]


async def test_a_device_that_sleeps_is_tried_so_often_that_it_is_met_awake() -> None:
    gone = LinkError("it is gone")
    async with house(*[Attempt(gone)] * 4) as home:
        home.runner.sleeps = True
        await anyio.sleep(100)
        assert home.runner.began == [0, 2, 6, 6 + SLEEPER_WITHIN, 6 + 2 * SLEEPER_WITHIN]


@pytest.mark.parametrize("error", [RefusedError("the connection", "give a password"), ValueError("a fault of ours")])
async def test_a_refusal_and_a_crash_are_told_of_and_not_tried_soon(error: Exception) -> None:
    async with house(Attempt(error), Attempt(None, 1000.0, answers=True)) as home:
        await anyio.sleep(1)
        (problem,) = problems_of([home.runner, None])
        assert problem.startswith("Hall: ")
        assert str(error) in problem
        await anyio.sleep(DEVICE_REFUSED_BACKOFF.first)
        assert len(home.runner.began) == 2
        assert home.runner.began[1] >= DEVICE_REFUSED_BACKOFF.first / 2
        assert list(problems_of([home.runner])) == []


async def test_a_restart_waits_for_nothing() -> None:
    async with house(Attempt(RefusedError("the connection", "give a password"))) as home:
        await anyio.sleep(1)
        home.runner.restart()
        await anyio.sleep(1)
        assert home.runner.began == [0, 1]


async def test_nothing_is_published_of_a_device_that_was_taken_away() -> None:
    """Not even where its connection ends at the same moment."""
    async with house(Attempt(LinkError("it is gone"), lasts=1.0)) as home:
        await anyio.sleep(0.5)
        home.runner.stop()
        await anyio.sleep(100)
        assert not home.gateway.devices.keys
        assert home.runner.began == [0]
