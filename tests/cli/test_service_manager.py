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
    """A gateway whose radio is plugged in after a while, if ever."""

    connects_after = CONNECTS_WITHIN * 10

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        self.set_unavailable("there is no radio")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(super().serve)
            task_status.started()
            await anyio.sleep(self.connects_after)
            self.set_available()


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


@pytest.mark.parametrize("kinds", [(Unplugged, Late), ()])
async def test_a_service_that_connected_once_or_has_nothing_to_connect_goes_on(
    monkeypatch: pytest.MonkeyPatch, kinds: tuple[type[MemoryGateway], ...]
) -> None:
    monkeypatch.setenv("HOMEBOT_SERVICE", "1")
    code, seconds = await run(*kinds)
    assert code == 0
    assert seconds >= 3600


async def test_what_a_person_started_waits_for_ever() -> None:
    assert (await run(Unplugged))[0] == 0
