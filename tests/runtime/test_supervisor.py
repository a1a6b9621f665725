"""A component that crashes is started anew and disturbs nobody."""

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from itertools import pairwise

import anyio
import pytest
from anyio.abc import TaskStatus
from structlog.testing import capture_logs

from homebot.clock import LoopClock
from homebot.errors import UsageError
from homebot.runtime.supervisor import Supervisor

pytestmark = pytest.mark.virtual_time


class Fragile:
    """Becomes ready, then crashes as often as it was told to, *after* seconds each time."""

    def __init__(self, crashes: int, after: float = 1.0) -> None:
        self.starts: list[float] = []
        self._crashes = crashes
        self._after = after

    async def work(self, *, task_status: TaskStatus[None]) -> None:
        self.starts.append(anyio.current_time())
        task_status.started()
        await anyio.sleep(self._after)
        if len(self.starts) <= self._crashes:
            raise RuntimeError("ouch")
        await anyio.sleep_forever()


async def test_a_crashed_component_is_started_anew_after_a_growing_delay() -> None:
    fragile = Fragile(crashes=3)
    supervisor = Supervisor(LoopClock())
    with capture_logs() as lines:
        async with supervisor.running("fragile", fragile.work):
            await anyio.sleep(60)

    assert fragile.starts == [0.0, 1.5, 3.5, 6.5]
    assert supervisor.restarts == {"fragile": 3}
    assert lines[0]["message"] == "fragile crashed (RuntimeError: ouch); restarting in 0.5 s"


async def test_one_traceback_is_shown_of_crashes_in_the_same_place() -> None:
    with capture_logs() as lines:
        async with Supervisor(LoopClock()).running("fragile", Fragile(crashes=3).work, "app fragile"):
            await anyio.sleep(60)
    crashes = [line for line in lines if line["event"] == "runtime.crashed"]
    assert ["exc_info" in line for line in crashes] == [True, False, False]
    assert crashes[1]["message"] == "app fragile crashed (RuntimeError: ouch); restarting in 1 s"


async def test_a_crash_in_another_place_has_a_traceback_of_its_own() -> None:
    errors = [ValueError("one"), TypeError("two"), TypeError("two")]

    async def work(*, task_status: TaskStatus[None]) -> None:
        task_status.started()
        await anyio.sleep(1)
        if errors:
            raise errors.pop(0)
        await anyio.sleep_forever()

    with capture_logs() as lines:
        async with Supervisor(LoopClock()).running("odd", work):
            await anyio.sleep(60)
    assert ["exc_info" in line for line in lines] == [True, True, False]


async def test_a_component_that_keeps_crashing_is_given_up_and_reported() -> None:
    fragile = Fragile(crashes=99)
    supervisor = Supervisor(LoopClock())
    with capture_logs() as lines:
        async with supervisor.running("fragile", fragile.work):
            await anyio.sleep(3600)

    assert supervisor.given_up == ["fragile"]
    assert len(fragile.starts) == 5
    assert lines[-1]["event"] == "runtime.given_up"
    assert lines[-1]["log_level"] == "critical"


async def test_a_component_that_was_given_up_is_tried_again_after_an_hour_but_an_app_never() -> None:
    part, app = Fragile(crashes=7), Fragile(crashes=7)
    supervisor = Supervisor(LoopClock())
    reasons: list[str] = []

    @asynccontextmanager
    async def down(why: str) -> AsyncIterator[None]:
        reasons.append(why)
        yield
        reasons.append("up")

    async with (
        supervisor.running("part", part.work, down=down),
        supervisor.running("app", app.work, "app", retry_after=math.inf),
    ):
        await anyio.sleep(3000)
        assert sorted(supervisor.given_up) == ["app", "part"]
        assert len(part.starts) == 5
        await anyio.sleep(3600)
        assert (len(part.starts), len(app.starts)) == (8, 5)
        assert supervisor.given_up == ["app"]
    assert reasons[8:10] == ["it crashed (RuntimeError: ouch) and starts again in 60 minutes", "up"]


async def test_a_component_is_restarted_by_hand_whether_it_runs_waits_or_was_given_up() -> None:
    fragile = Fragile(crashes=6)
    supervisor = Supervisor(LoopClock())
    async with supervisor.running("fragile", fragile.work):
        await anyio.sleep(1.2)  # it waits for its restart
        supervisor.restart("fragile")
        await anyio.sleep(60)
        assert (len(fragile.starts), supervisor.given_up) == (6, ["fragile"])
        supervisor.restart("fragile")
        await anyio.sleep(60)
        assert (len(fragile.starts), supervisor.given_up) == (7, [])
        supervisor.restart("fragile")
        await anyio.sleep(1)
        assert len(fragile.starts) == 8
        supervisor.restart("unknown")
    supervisor.restart("fragile")
    assert fragile.starts[1] == 1.2


async def test_a_mistake_of_the_user_at_the_first_start_ends_the_start() -> None:
    """Trying again would not mend the configuration."""

    async def misconfigured(*, task_status: TaskStatus[None]) -> None:
        raise UsageError("no such file")

    with pytest.raises(UsageError, match="no such file"):
        async with Supervisor(LoopClock()).running("app", misconfigured):
            pytest.fail("it must not start")


async def test_a_component_that_returns_is_done() -> None:
    """Not every app is there for ever."""

    async def short(*, task_status: TaskStatus[None]) -> None:
        return

    supervisor = Supervisor(LoopClock())
    async with supervisor.running("short", short):
        await anyio.sleep(100)
    assert supervisor.restarts == {}


async def test_entering_waits_until_the_component_is_ready() -> None:
    """Being ready is a signal, not a matter of time."""

    async def slow(*, task_status: TaskStatus[None]) -> None:
        await anyio.sleep(3)
        task_status.started()
        await anyio.sleep_forever()

    async with Supervisor(LoopClock()).running("slow", slow):
        assert anyio.current_time() == 3


async def test_crashes_far_apart_are_forgiven_and_do_not_make_the_next_start_slow() -> None:
    """Only those of the last minute count for the delay."""
    fragile = Fragile(crashes=99, after=100)
    supervisor = Supervisor(LoopClock())
    async with supervisor.running("fragile", fragile.work):
        await anyio.sleep(1000)
    assert supervisor.given_up == []
    assert [later - earlier for earlier, later in pairwise(fragile.starts)] == [100.5] * 9


async def test_a_component_that_never_says_it_is_ready_is_not_waited_for_without_end() -> None:
    """Ten seconds, and a word about it."""

    async def silent(*, task_status: TaskStatus[None]) -> None:
        await anyio.sleep_forever()

    with capture_logs() as lines:
        async with Supervisor(LoopClock()).running("silent", silent):
            assert anyio.current_time() == 10
    assert [line["message"] for line in lines] == [
        "silent is not ready after 10 s; homebot continues without waiting for it"
    ]


async def test_who_hurries_waits_for_nobody() -> None:
    """Neither for the one that is starting nor for the next."""

    async def silent(*, task_status: TaskStatus[None]) -> None:
        await anyio.sleep_forever()

    supervisor = Supervisor(LoopClock())
    async with anyio.create_task_group() as tasks:

        async def hurry() -> None:
            await anyio.sleep(1)
            supervisor.hurry()

        tasks.start_soon(hurry)
        async with supervisor.running("first", silent), supervisor.running("second", silent):
            assert anyio.current_time() == 1


async def test_a_component_that_crashes_while_it_stops_is_told_and_not_started_anew() -> None:
    """Its error must not keep the others from stopping."""

    async def sore(*, task_status: TaskStatus[None]) -> None:
        task_status.started()
        try:
            await anyio.sleep_forever()
        finally:
            raise RuntimeError("ouch")

    supervisor = Supervisor(LoopClock())
    with capture_logs() as lines:
        async with supervisor.running("sore", sore):
            pass
    assert [line["message"] for line in lines] == ["sore crashed (RuntimeError: ouch) while stopping"]
    assert supervisor.restarts == {}


async def test_the_first_of_several_errors_is_told() -> None:
    """A node that crashed in two places is one crash."""

    async def twice(*, task_status: TaskStatus[None]) -> None:
        raise ExceptionGroup("", [ExceptionGroup("", [ValueError("first")]), RuntimeError("second")])

    with capture_logs() as lines:
        async with Supervisor(LoopClock()).running("twice", twice):
            pass
    assert lines[0]["message"] == "twice crashed (ValueError: first); restarting in 0.5 s"


async def test_a_component_that_exits_has_crashed_and_nobody_else_is_disturbed() -> None:
    """``sys.exit()`` in an app is not the end of the house."""

    async def leaves(*, task_status: TaskStatus[None]) -> None:
        task_status.started()
        raise SystemExit(3)

    supervisor = Supervisor(LoopClock())
    with capture_logs() as lines:
        async with supervisor.running("app", leaves):
            await anyio.sleep(60)
    assert supervisor.given_up == ["app"]
    assert "app called sys.exit(3); to end it, let it return" in lines[0]["message"]
