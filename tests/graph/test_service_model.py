"""Services under random time limits and cancellations: nothing is lost or done twice, and the counts add up."""

import asyncio
from collections import Counter
from dataclasses import dataclass
from typing import Literal

import anyio
from hypothesis import given, settings
from hypothesis import strategies as st

from homebot.errors import RefusedError, ServiceError, ServiceFailedError, ServiceGoneError, ServiceTimeoutError
from homebot.graph import Client, Graph, Node
from homebot.messages import Message, ServiceType
from homebot.testing import VirtualTimeLoop


class EchoRequest(Message):
    """The number of a call."""

    number: int


class EchoResponse(Message):
    """The same number."""

    number: int


Echo = ServiceType("test_msgs/srv/Echo", EchoRequest, EchoResponse)
EchoClient = Client[EchoRequest, EchoResponse]

Wait = Literal["none", "sleep", "scope", "group", "call"]
End = Literal["answer", "refuse", "fail"]

SERVICES = ("exclusive", "concurrent", "other")
HALF_SECONDS = st.integers(0, 8).map(lambda halves: halves / 2)  # so that many things happen at once


@dataclass(frozen=True)
class Plan:
    """One call, and what its handler does."""

    begins: float
    service: str
    timeout: float
    cancelled_after: float | None
    cancels: bool
    wait: Wait
    seconds: float
    end: End


PLANS = st.builds(
    Plan,
    begins=HALF_SECONDS,
    service=st.sampled_from(SERVICES),
    timeout=HALF_SECONDS.map(lambda seconds: seconds + 0.5),
    cancelled_after=st.none() | HALF_SECONDS,
    cancels=st.booleans(),
    wait=st.sampled_from(["none", "sleep", "scope", "group", "call"]),
    seconds=HALF_SECONDS,
    end=st.sampled_from(["answer", "answer", "refuse", "fail"]),
)


class Trial:
    """Carries out plans and notes how each call and each handler ends, by the number of the call."""

    def __init__(self, plans: list[Plan]) -> None:
        self.plans = plans
        self.graph: Graph
        self.clients: dict[str, EchoClient] = {}
        self.begun: list[int] = []
        self.ends: list[tuple[int, str]] = []
        self.outcomes: dict[int, str] = {}
        self.at_work: Counter[str] = Counter()

    async def run(self, closes_after: float) -> None:
        """Run all; the node of two of the services ends after *closes_after* seconds."""
        self.graph = Graph()
        async with Node(self.graph, "caller") as caller, Node(self.graph, "long") as long:
            async with anyio.create_task_group() as tasks, Node(self.graph, "short") as short:
                for node, name in ((short, "exclusive"), (short, "concurrent"), (long, "other")):
                    node.create_service(Echo, f"/{name}", self._handle, concurrent=name == "concurrent")
                    self.clients[name] = caller.create_client(Echo, f"/{name}")
                for number in range(len(self.plans)):
                    tasks.start_soon(self._follow, number)
                await anyio.sleep(closes_after)
            for client in self.clients.values():
                await client.wait_for_handlers()

    async def _follow(self, number: int) -> None:
        plan = self.plans[number]
        await anyio.sleep(plan.begins)
        with anyio.move_on_after(plan.cancelled_after):
            await self._call(number, plan.service)

    async def _call(self, number: int, name: str) -> None:
        """Make a call and note its outcome."""
        plan = self.plans[number % len(self.plans)]
        try:
            response = await self.clients[name].call(
                EchoRequest(number=number), plan.timeout, cancel_with_caller=plan.cancels
            )
            assert response.number == number
            self._note(number, "answer")
        except asyncio.CancelledError:
            self._note(number, "cancelled")
            raise
        except ServiceFailedError as exc:
            self._note(number, "refuse" if "no wish" in exc.reason else "fail" if "ouch" in exc.reason else exc.reason)
        except ServiceTimeoutError:
            self._note(number, "timeout")
        except ServiceGoneError:
            self._note(number, "gone")
        except ServiceError:
            self._note(number, "unavailable")

    def _note(self, number: int, outcome: str) -> None:
        assert number not in self.outcomes
        self.outcomes[number] = outcome

    async def _handle(self, request: EchoRequest) -> EchoResponse:
        number = request.number
        plan = self.plans[number % len(self.plans)]
        name = plan.service if number < len(self.plans) else "other"
        self.begun.append(number)
        self.at_work[name] += 1
        assert name == "concurrent" or self.at_work[name] == 1
        end = "cancelled"
        try:
            await self._wait(plan, number)
            end = plan.end
        finally:
            self.ends.append((number, end))
            self.at_work[name] -= 1
        if end == "refuse":
            raise RefusedError("the echo", "no wish")
        if end == "fail":
            raise ValueError("ouch")
        return EchoResponse(number=number)

    async def _wait(self, plan: Plan, number: int) -> None:
        match plan.wait:
            case "sleep":
                await anyio.sleep(plan.seconds)
            case "scope":
                with anyio.move_on_after(plan.seconds):
                    await anyio.sleep_forever()
            case "group":
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(anyio.sleep, plan.seconds)
            case "call" if plan.service != "other" and number < len(self.plans):
                await self._call(number + len(self.plans), "other")
            case _:
                pass


@settings(deadline=None)
@given(plans=st.lists(PLANS, min_size=1, max_size=25), closes_after=HALF_SECONDS.map(lambda seconds: 5 * seconds))
def test_each_handler_ends_once_each_caller_gets_its_own_answer_and_the_counts_add_up(
    plans: list[Plan], closes_after: float
) -> None:
    trial = Trial(plans)
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(trial.run(closes_after))
    ends = dict(trial.ends)
    assert sorted(trial.begun) == sorted(number for number, _ in trial.ends) == sorted(ends)
    assert set(trial.at_work.values()) <= {0}
    expected_kinds = {"answer", "refuse", "fail", "cancelled", "timeout", "gone", "unavailable"}
    assert set(trial.outcomes.values()) <= expected_kinds
    heard = {number for number, outcome in trial.outcomes.items() if outcome in {"answer", "refuse", "fail"}}
    assert all(ends[number] == trial.outcomes[number] for number in heard)
    ended_by_themselves = {number for number, end in ends.items() if end != "cancelled"}
    assert trial.graph.failures.late_answers == len(ended_by_themselves - heard)
    assert sum(one.count for one in trial.graph.failures) == sum(end == "fail" for end in ends.values())
