"""``homebot app list``: apps with their jobs, when these are called next, and why one is not."""

import asyncio
import json

import anyio
import pytest
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
        assert runtime.door is not None
        door = ["--door", f"127.0.0.1:{runtime.door.port}"]
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
