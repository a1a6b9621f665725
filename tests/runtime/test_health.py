"""``/homebot/health`` counts what the graph counts."""

import anyio
import pytest
from tests.graph.actions.fibonacci import Client, Feedback, Fibonacci, Goal, Result, Served

from homebot import App
from homebot.config import parse_config
from homebot.devices.health import GetHealth, HealthRequest
from homebot.errors import ServiceTimeoutError
from homebot.graph import Node
from homebot.graph.actions import ActionServer
from homebot.messages import Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest
from homebot.runtime import Runtime


@pytest.mark.virtual_time
async def test_late_answers_are_counted() -> None:
    async def slow(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(2)
        return SuccessResponse(success=True, message="")

    async with Runtime(parse_config({}, "test"), with_door=False) as runtime, Node(runtime.graph, "node") as node:
        node.create_service(Trigger, "/slow", slow)
        with pytest.raises(ServiceTimeoutError):
            await node.create_client(Trigger, "/slow").call(TriggerRequest(), timeout=1)
        await anyio.sleep(2)
        health = await node.create_client(GetHealth, "/homebot/health").call(HealthRequest())
        counts = {one.name: one.count for one in health.counts}
        assert (counts["answers_late"], counts["calls_refused"], counts["callback_failures"]) == (1, 0, 0)


@pytest.mark.virtual_time
async def test_a_handler_that_does_not_end_is_a_problem() -> None:
    async def stuck(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep_forever()
        raise AssertionError

    async with Runtime(parse_config({}, "test"), with_door=False) as runtime, Node(runtime.graph, "node") as node:
        node.create_service(Trigger, "/stuck", stuck)
        health = node.create_client(GetHealth, "/homebot/health")
        with pytest.raises(ServiceTimeoutError):
            await node.create_client(Trigger, "/stuck").call(TriggerRequest())
        await anyio.sleep(60)
        assert (await health.call(HealthRequest())).troubles == ()
        await anyio.sleep(300)
        assert (await health.call(HealthRequest())).troubles == (
            "a handler of /stuck has been running for 6 minutes: its caller gave up, and later calls may wait for it",
        )


@pytest.mark.virtual_time
async def test_feedback_that_came_faster_than_it_was_read_is_counted_also_after_its_goal() -> None:
    async def hurry(goal: Served) -> Result:
        for number in range(270):
            goal.publish_feedback(Feedback(sequence=(number,)))
        goal.succeed()
        return Result(sequence=())

    read: list[Feedback] = []
    async with Runtime(parse_config({}, "test"), with_door=False) as runtime, Node(runtime.graph, "node") as node:
        ActionServer(node, Fibonacci, "fib", hurry)
        client = Client(node, Fibonacci, "fib")
        await client.perform(Goal(order=1), read.append)
        await anyio.sleep(1)
        client.close()
        health = await node.create_client(GetHealth, "/homebot/health").call(HealthRequest())
        assert {one.name: one.count for one in health.counts}["messages_lost"] == 270 - len(read) > 0


class Clumsy(App):
    """Has a job that fails each time."""

    async def run(self) -> None:
        self.every("1s", self.tick, name="tick")
        await anyio.sleep_forever()

    def tick(self) -> None:
        raise ValueError("tock")


@pytest.mark.virtual_time
async def test_a_job_that_was_given_up_is_a_failure_with_that_outcome() -> None:
    config = parse_config({"apps": {"clumsy": {"class": f"{__name__}:Clumsy"}}}, "test")
    async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "node") as node:
        health = node.create_client(GetHealth, "/homebot/health")
        await anyio.sleep(2.5)
        assert [one.outcome for one in (await health.call(HealthRequest())).failures] == [""]
        await anyio.sleep(10)
        found = await health.call(HealthRequest())
        (failure,) = found.failures
        assert found.troubles == ()
        assert (failure.part, failure.what, failure.outcome) == ("clumsy", "the job tick failed", "given up")
