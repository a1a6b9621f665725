"""A service that reaches nothing ends with an error; one that reached something goes on."""

from functools import partial

import anyio
import pytest
from anyio.abc import TaskStatus
from structlog.testing import capture_logs

from homebot.cli.commands.run import _run
from homebot.cli.service_manager import CONNECTS_WITHIN
from homebot.config import Config, parse_config
from homebot.gateways.memory import MemoryGateway
from homebot.runtime import Runtime

pytestmark = pytest.mark.virtual_time


class Unplugged(MemoryGateway):
    """A gateway whose radio is plugged in long after the hour of a run."""

    connects_after = CONNECTS_WITHIN * 20

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        self.set_unavailable("there is no radio")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(super().serve)
            task_status.started()
            await anyio.sleep(self.connects_after)
            self.set_available()
            await anyio.sleep(1)
            self.set_unavailable("somebody took it")


class Late(Unplugged):
    """One that is plugged in just in time, and out again."""

    connects_after = CONNECTS_WITHIN - 10


def config(*kinds: type[MemoryGateway]) -> Config:
    tables = {one.__name__.lower(): {"class": f"{one.__module__}:{one.__name__}"} for one in kinds}
    return parse_config({"gateways": tables}, "test")


async def run(*kinds: type[MemoryGateway]) -> tuple[int, float]:
    """Run for an hour at most; return the exit code and the seconds."""
    wanted = config(*kinds)
    begin = anyio.current_time()
    code = await _run(partial(Runtime, wanted, with_door=False), 3600.0, lambda: wanted)
    return code, anyio.current_time() - begin


async def test_a_service_that_never_connected_fails_after_five_minutes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOMEBOT_SERVICE", "1")
    with capture_logs() as lines:
        code, seconds = await run(Unplugged)
    assert (code, round(seconds)) == (1, CONNECTS_WITHIN)
    (line,) = [one for one in lines if one["event"] == "runtime.never_connected"]
    assert line["message"].startswith("no gateway was connected within 5 minutes (unplugged); the service ends")


@pytest.mark.parametrize(("kinds", "code"), [((Unplugged, Late), 1), ((Late,), 0), ((), 0)])
async def test_a_service_that_connected_once_or_has_nothing_to_connect_goes_on(
    monkeypatch: pytest.MonkeyPatch, kinds: tuple[type[MemoryGateway], ...], code: int
) -> None:
    """At its end a gateway that never did counts."""
    monkeypatch.setenv("HOMEBOT_SERVICE", "1")
    found, seconds = await run(*kinds)
    assert found == code
    assert seconds >= 3600


async def test_a_run_for_a_time_fails_if_a_gateway_never_connected_and_names_it_with_the_reason() -> None:
    with capture_logs() as lines:
        code, seconds = await run(Unplugged, Late)
    assert code == 1
    assert seconds >= 3600
    (line,) = [one["message"] for one in lines if one["event"] == "runtime.never_connected"]
    assert line == "never connected in 3600 s: gateway unplugged: there is no radio"


async def test_a_run_for_a_time_in_which_each_gateway_connected_once_is_well() -> None:
    """Also if its link was lost later."""
    with capture_logs() as lines:
        code, _ = await run(Late)
    assert code == 0
    assert "runtime.never_connected" not in [one["event"] for one in lines]
