"""``homebot app list``: apps with their jobs, when these are called next, and why one is not."""

import asyncio
import json
from typing import Self

import anyio
import pytest
from structlog.testing import capture_logs
from tests.patience import PATIENCE

from homebot import App
from homebot.cli.commands.app import _rows
from homebot.cli.main import main
from homebot.clock import read_zone
from homebot.config import parse_config
from homebot.devices.app_messages import AppInfo, AppsRequest, ListApps
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import LIST_APPS, RUNTIME_HEALTH
from homebot.graph import Node
from homebot.runtime import Runtime

ZONE = "Asia/Kolkata"
read_zone(ZONE)  # before any loop runs


class Hall(App):
    async def run(self) -> None:
        self.every("0.01s", self.work, name="slow")
        self.every("0.01s", self.fail, name="odd")
        self.daily("22:00", self.work, name="evening")
        await anyio.sleep_forever()

    async def work(self) -> None:
        await anyio.sleep_forever()

    def fail(self) -> None:
        raise ValueError("no lamp")


def home() -> Runtime:
    tables: dict[str, object] = {
        "apps": {"hall": {"class": f"{__name__}:Hall"}},
        "door": {"port": 0},
        "discovery": {"persist": False},
    }
    tables["home"] = {"zone": ZONE}
    return Runtime(parse_config(tables, "test"))


class Numbers:
    """A live query of numbers."""

    def __init__(self) -> None:
        self._last = 0

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> int:
        await anyio.sleep(0.001)
        self._last += 1
        return self._last


class Odd(App):
    async def run(self) -> None:
        self.on(Numbers(), self.fail)

    def fail(self, number: int) -> None:
        raise ValueError(f"no lamp {number}")


async def test_a_handler_that_was_given_up_is_listed_and_in_the_health() -> None:
    tables = {"apps": {"odd": {"class": f"{__name__}:Odd"}}, "discovery": {"persist": False}}
    async with Runtime(parse_config(tables, "test"), with_door=False) as runtime, Node(runtime.graph, "client") as node:
        client, health = node.create_client(ListApps, LIST_APPS), node.create_client(GetHealth, RUNTIME_HEALTH)
        with anyio.fail_after(PATIENCE):
            while True:
                if found := (await client.call(AppsRequest())).apps[0].jobs:
                    break
                await anyio.sleep(0.01)
        assert [(one.name, one.note) for one in found] == [
            ("handler fail", "failed 5 times in a row and is not called any more (ValueError: no lamp 5)")
        ]
        failures = (await health.call(HealthRequest())).failures
        assert [(one.part, one.what, one.outcome) for one in failures] == [
            ("odd", "the handler fail failed", "given up")
        ]


class Fragile(App):
    async def run(self) -> None:
        self.start_task(self.fail)

    async def fail(self) -> None:
        raise ValueError("no lamp")


async def test_the_log_shows_the_error_of_a_task_once() -> None:
    """It showed three tracebacks: the error in its group, the group, and the error."""
    tables = {"apps": {"fragile": {"class": f"{__name__}:Fragile"}}, "discovery": {"persist": False}}
    with capture_logs() as lines, anyio.fail_after(PATIENCE):
        async with Runtime(parse_config(tables, "test"), with_door=False):
            while True:
                if crashes := [one for one in lines if one["event"] == "runtime.crashed"]:
                    break
                await anyio.sleep(0.01)
    error = crashes[0]["exc_info"]
    assert (str(error), error.__context__, error.__cause__) == ("no lamp", None, None)


async def test_apps_are_listed_with_their_jobs_by_a_service_and_by_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    async with home() as runtime, Node(runtime.graph, "client") as node:
        client = node.create_client(ListApps, LIST_APPS)
        with anyio.fail_after(PATIENCE):
            while True:
                (app,) = (await client.call(AppsRequest())).apps
                if any(job.name == "odd" and job.note for job in app.jobs):
                    break
                await anyio.sleep(0.01)
        slow, odd, evening = app.jobs
        assert (app.name, app.state, app.crashes) == ("hall", "running", 0)
        assert slow.running_since.sec > 0
        assert odd.next.sec == 0
        assert odd.note == "failed 5 times in a row and is not called any more (ValueError: no lamp)"
        assert (evening.text, evening.running_since.sec) == ("daily at 22:00", 0)
        assert 0 < evening.next.to_seconds() - runtime.graph.clock.now() <= 25 * 3600
        health = await node.create_client(GetHealth, RUNTIME_HEALTH).call(HealthRequest())
        assert [(one.what, one.outcome) for one in health.failures if one.part == "hall"] == [
            ("the job odd failed", "given up")
        ]
        assert runtime.rosbridge is not None
        door = ["--door", f"127.0.0.1:{runtime.rosbridge.port}"]
        capsys.readouterr()
        assert await asyncio.to_thread(main, ["app", "list", *door]) == 0
        printed = capsys.readouterr().out
        (line,) = (one for one in printed.splitlines() if "evening (daily at 22:00)" in one)
        assert " 22:00 IST, in " in line
        assert "running since" in printed
        assert await asyncio.to_thread(main, ["app", "list", "--json", *door]) == 0
        text = capsys.readouterr().out
        (listed,), _ = json.JSONDecoder().raw_decode(text, text.index("[\n"))  # the log may say more after it
        assert [job["name"] for job in listed["jobs"]] == ["slow", "odd", "evening"]


@pytest.mark.parametrize(("crashes", "text"), [(1, "crashed once"), (3, "crashed 3 times")])
def test_the_crashes_of_an_app_are_in_its_state(crashes: int, text: str) -> None:
    app = AppInfo(name="hall", state="running", crashes=crashes, last_crash="ValueError: no lamp")
    assert _rows(app, 0.0, read_zone(ZONE)) == [("hall", f"running, {text}: ValueError: no lamp", "", "", "")]
