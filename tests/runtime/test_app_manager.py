"""Apps that are loaded, unloaded and reloaded while homebot runs."""

import asyncio
import gc
import os
import sys
import traceback
import weakref
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from structlog.testing import capture_logs
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.cli.main import main
from homebot.clock import LoopClock
from homebot.config import Config, load_config, parse_config
from homebot.devices.app_messages import ChangeAppRequest, ChangeAppResponse, ReloadApp
from homebot.devices.names import LOAD_APP, RELOAD_APP, UNLOAD_APP
from homebot.devices.own_services import right_to_call
from homebot.errors import ConfigError, HomebotError, UsageError
from homebot.graph import Node
from homebot.messages.std_msgs import String
from homebot.rights import Right
from homebot.runtime import Runtime
from homebot.support.data_folder import data_directory
from homebot.support.owner_token import OWNER_FILE

HALL = """
import anyio
from homebot import App
from homebot.apps import AppSettings
from homebot.messages.std_msgs import String

class Settings(AppSettings):
    word: str = "word"

class Hall(App[Settings]):
    async def run(self):
        self.node.create_subscription(String, "heard", lambda _: None)
        self.node.create_timer(3600, lambda: None)
        self.start_task(anyio.sleep_forever)
        self.store["runs"] = [*self.store.get("runs", []), WORD + " " + self.settings.word]
        await anyio.sleep_forever()

WORD = "first"
"""


@asynccontextmanager
async def home(folder: Path, *, with_door: bool = False) -> AsyncIterator[Runtime]:
    """A home with the app ``hall`` in a file."""
    (folder / "hall.py").write_text(HALL)
    config = folder / "homebot.toml"
    config.write_text('[apps.hall]\nclass = "hall:Hall"\n[door]\nport = 0\n')
    sys.path.insert(0, str(folder))
    read = await asyncio.to_thread(load_config, config)
    owner = data_directory() / OWNER_FILE
    runtime = Runtime(read, with_door=with_door, read_config=lambda: load_config(config), owner_file=owner)
    async with runtime:
        runtime.app_manager.trial = 0.05
        yield runtime
    sys.modules.pop("hall", None)
    sys.path.remove(str(folder))


def runs(runtime: Runtime) -> list[str]:
    found: list[str] = runtime.app_host.context.store_of("hall").get("runs", [])
    return found


def change(folder: Path, old: str, new: str) -> None:
    """Save a file of the same length and time, which Python's cache takes for the same."""
    file = folder / "hall.py"
    before = file.stat()
    text = file.read_text()
    changed = text.replace(old, new)
    assert text != changed
    file.write_text(changed)
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))


async def test_a_reload_takes_code_and_settings_as_they_are_now(tmp_path: Path) -> None:
    async with home(tmp_path) as runtime:
        assert await runtime.app_manager.reload("hall") == "reloaded the app hall"
        change(tmp_path, "first", "again")
        await runtime.app_manager.reload("hall")
        with (tmp_path / "homebot.toml").open("a") as file:
            file.write("[apps.hall.x]\n")
        with pytest.raises(UsageError, match=r"hall is not reloaded, the old one runs: .*apps\.hall\.x: unknown key"):
            await runtime.app_manager.reload("hall")
        assert runs(runtime) == ["first word", "first word", "again word"]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("async def run(self):", "async def run(self:", r"SyntaxError: .*line 11"),
        ("class ", "raise SystemExit(3)\nclass ", r"it calls sys\.exit\(\)"),
        ("import anyio", "import anyone", "No module named 'anyone'"),
        ('WORD = "first"', "", "NameError: name 'WORD' is not defined"),
        ("class Hall(", "class Room(", "has no class|no attribute|not a class"),
        ("await anyio.sleep_forever()", "raise RuntimeError('ouch')", "RuntimeError: ouch"),
    ],
)
async def test_a_reload_that_fails_leaves_the_old_code_running(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    async with home(tmp_path) as runtime:
        before = sys.modules["hall"]
        change(tmp_path, old, new)
        with pytest.raises(UsageError, match=f"hall is not reloaded, the old one runs: .*({problem})"):
            await runtime.app_manager.reload("hall")
        assert sys.modules["hall"] is before
        assert runtime.graph.get_node("/hall") is not None
        assert runs(runtime)[-1] == "first word"
        assert runtime.supervisor.given_up == []
        assert all(crash.state == "running again" for crash in runtime.supervisor.crashes.values())
        change(tmp_path, new, old) if new else (tmp_path / "hall.py").write_text(HALL)
        await runtime.app_manager.reload("hall")


async def test_an_app_is_loaded_from_a_file_and_unloaded(tmp_path: Path) -> None:
    async with home(tmp_path) as runtime:
        file = tmp_path / "porch.py"
        file.write_text(HALL.replace("Hall", "PorchLight").replace("first", "porch"))
        assert await runtime.app_manager.load(str(file)) == "loaded the app porch_light"
        with pytest.raises(UsageError, match="porch_light is already running; `homebot app reload porch_light`"):
            await runtime.app_manager.load(str(file))
        await runtime.app_manager.reload("porch_light")
        assert [app.name for app in runtime.app_manager.apps] == ["hall", "porch_light"]
        await runtime.app_manager.unload("hall")
        assert runtime.graph.get_node("/hall") is None
        with pytest.raises(UsageError, match="no app 'porch_lihgt' runs; did you mean porch_light"):
            await runtime.app_manager.unload("porch_lihgt")
        await runtime.app_manager.load("hall")
        assert [app.name for app in runtime.app_manager.apps] == ["porch_light", "hall"]
        file.write_text(
            HALL.replace("Hall", "Other").replace("await anyio", "raise ValueError(1)\n        await anyio")
        )
        with pytest.raises(UsageError, match="other is not loaded: ValueError: 1"):
            await runtime.app_manager.load(str(file))
        assert "other" not in runtime.supervisor.crashes
        with pytest.raises(ConfigError, match=r"'lihgt_service' is not installed .*did you mean light_service"):
            await runtime.app_manager.load("lihgt_service")
        sys.modules.pop("porch", None)


SWALLOWS = """
import asyncio
import anyio
from homebot import App

async def wait():
    while True:
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            pass

class Deaf(App):
    async def run(self):
        BODY
"""
SWALLOWERS = (
    "self.start_task(wait)\n        await wait()",
    "self.kept = asyncio.create_task(wait())\n        await asyncio.sleep(3600)",
    "async with asyncio.TaskGroup() as tasks:\n            tasks.create_task(wait())",
    "async with anyio.create_task_group() as tasks:\n            tasks.start_soon(wait)",
)

CREATES = """
import asyncio
import anyio
from homebot import App
from homebot.devices.app_messages import ChangeAppResponse, ReloadApp
from homebot.messages.std_msgs import String

ENDED = []

async def fail():
    await asyncio.sleep(0.01)
    raise ValueError("lost")

async def last():
    try:
        await asyncio.sleep(3600)
    finally:
        ENDED.append("last")

class Maker(App):
    async def run(self):
        self.last = asyncio.create_task(last())
        self.node.create_service(ReloadApp, "make", self.serve_make)
        self.node.create_subscription(String, "told", self.hear)
        loop = asyncio.get_running_loop()
        BODY
        await asyncio.sleep(3600)

    async def serve_make(self, request):
        await asyncio.sleep(0.01)
        self.served = asyncio.create_task(fail())
        return ChangeAppResponse()

    def hear(self, message):
        self.heard = asyncio.create_task(fail())
"""


CRASHES = (
    "self.kept = asyncio.create_task(fail())",
    "asyncio.ensure_future(fail())",
    "self.kept = loop.create_task(fail(), name='kept')",
    "loop.call_later(0.01, lambda: loop.create_task(fail()))",
    "await asyncio.wait([asyncio.create_task(fail())])",
    "self.start_task(lambda: self.serve_make(None))",
    "await asyncio.sleep(1)  # a call of its service",
    "await asyncio.sleep(1)  # a message",
)
RUNS_ON = """
        (await asyncio.wait([asyncio.create_task(fail())]))[0].pop().exception()
        await asyncio.gather(asyncio.create_task(fail()), fail(), return_exceptions=True)
        asyncio.create_task(fail()).add_done_callback(lambda task: task.exception())
        loop.call_later(0.01, asyncio.create_task(asyncio.sleep(3600)).cancel)
        for wait in (lambda task: task, asyncio.shield, lambda task: asyncio.wait_for(task, 1)):
            try:
                await wait(asyncio.create_task(fail()))
            except ValueError:
                pass
        try:
            async with asyncio.TaskGroup() as tasks, anyio.create_task_group() as others:
                tasks.create_task(fail())
                others.start_soon(fail)
        except* ValueError:
            pass
        try:
            async with asyncio.timeout(0.01):
                await asyncio.create_task(asyncio.sleep(3600))
        except TimeoutError:
            ENDED.append("first")
"""


async def test_a_task_that_an_app_creates_with_asyncio_is_watched_like_its_own(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Its error was silent while the app kept the task, and it went on without the app."""
    async with home(tmp_path) as runtime, Node(runtime.graph, "tester") as node:
        runtime.app_manager.trial = 0.0
        for number, body in enumerate((*CRASHES, RUNS_ON)):
            file = tmp_path / f"maker_{number}.py"
            file.write_text(CREATES.replace("BODY", body))
            with capture_logs() as lines:
                await runtime.app_manager.load(str(file))
                if "service" in body:
                    await node.create_client(ReloadApp, "make").call(ChangeAppRequest(app=""))
                elif "message" in body:
                    node.create_publisher(String, "told").publish(String(data="a word"))
                await anyio.sleep(0.2)
                await runtime.app_manager.unload("maker")
            errors = [line for line in lines if line["log_level"] in ("error", "critical")]
            found = [
                (line["component"], traceback.extract_tb(line["exc_info"].__traceback__)[-1][:2]) for line in errors
            ]
            assert found == ([] if body == RUNS_ON else [("maker", (str(file), 12))]), (body, errors)
            ended = sys.modules.pop(file.stem).ENDED
            assert ended == (["first", "last"] if body == RUNS_ON else ["last"]), body
        assert caplog.records == []


@pytest.mark.parametrize("body", SWALLOWERS)
async def test_an_app_that_swallows_its_cancellation_is_named_with_its_line_and_closed(
    tmp_path: Path, body: str
) -> None:
    """Unloading it hung for ever, and so did the end of homebot, which named others."""
    file = tmp_path / "deaf.py"
    file.write_text(SWALLOWS.replace("BODY", body))
    async with home(tmp_path) as runtime:
        runtime.app_manager.ends_within = 0.2
        await runtime.app_manager.load(str(file))
        with anyio.fail_after(PATIENCE), pytest.raises(UsageError) as caught:
            await runtime.app_manager.unload("deaf")
        place = f"{file}:9 (wait)"
        assert str(caught.value).startswith(f"the app deaf did not end in 0.2 s: {place} swallows")
        assert runtime.graph.get_node("/deaf") is None
        await runtime.app_manager.reload("hall")
        await runtime.app_manager.load(str(file))  # left to the end of homebot
    assert runtime.app_host.running == {}
    sys.modules.pop("deaf", None)


async def test_a_package_is_reloaded_with_its_folder_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "my_home"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "words.py").write_text("WORD = 'first'\n")
    (package / "hall.py").write_text(HALL.replace('WORD = "first"', "from my_home.words import WORD"))
    (tmp_path / "helpers.py").write_text("")
    (tmp_path / "homebot.toml").write_text('[apps.hall]\nclass = "my_home.hall:Hall"\n')
    read = await asyncio.to_thread(load_config, tmp_path / "homebot.toml")
    async with Runtime(read, with_door=False) as runtime:
        runtime.app_manager.trial = 0.05
        import helpers  # type: ignore[import-not-found]  # noqa: PLC0415 - it is made above

        (package / "words.py").write_text("WORD = 'again'\n")
        await runtime.app_manager.reload("hall")
        assert runs(runtime) == ["first word", "again word"]
        assert sys.modules["helpers"] is helpers
        good = sys.modules["my_home.words"]
        (package / "words.py").write_text("WORD = \n")
        with pytest.raises(UsageError, match=r"the old one runs: .*SyntaxError"):
            await runtime.app_manager.reload("hall")
        assert sys.modules["my_home.words"] is good is sys.modules["my_home"].words
    for name in ("helpers", "my_home", "my_home.words", "my_home.hall"):
        sys.modules.pop(name, None)


async def test_an_app_of_homebot_is_reloaded_with_its_settings_alone(tmp_path: Path) -> None:
    """A second class App would be another class."""
    (tmp_path / "homebot.toml").write_text("[apps.lights_out]\n")
    config = tmp_path / "homebot.toml"
    read = await asyncio.to_thread(load_config, config)
    async with Runtime(read, with_door=False, read_config=lambda: load_config(config)) as runtime:
        runtime.app_manager.trial = 0.05
        before = sys.modules["homebot.apps.lights_out"]
        config.write_text("[apps.lights_out]\nquiet_after = 1700\n")
        await runtime.app_manager.reload("lights_out")
        assert runtime.app_manager.apps[0].settings.model_dump()["quiet_after"] == 1700
        assert sys.modules["homebot.apps.lights_out"] is before
        config.write_text("[apps.lights_out]\nact = 'light in hall'\n")
        with pytest.raises(HomebotError, match=r"apps\.lights_out\.act: has changed; reload the configuration first"):
            await runtime.app_manager.reload("lights_out")


async def test_clients_load_and_reload_by_services_and_by_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with home(tmp_path, with_door=True) as runtime:
        assert {LOAD_APP, RELOAD_APP} <= runtime.graph.get_service_names_and_types().keys()
        async with Node(runtime.graph, "client") as node:
            answer = await node.create_client(ReloadApp, RELOAD_APP).call(ChangeAppRequest(app="hal"), timeout=60)
            assert answer == ChangeAppResponse(success=False, message="no app 'hal' runs; did you mean hall?")
        assert runtime.rosbridge is not None
        door = ["--door", f"127.0.0.1:{runtime.rosbridge.port}"]
        for words, code in ((("reload", "hall"), 0), (("unload", "hall"), 0), (("unload", "hall"), 1)):
            assert await asyncio.to_thread(main, ["app", *words, *door]) == code
        said = capsys.readouterr()
        printed = [line for line in said.out.splitlines() if not line.startswith("[")]  # without the log
        assert printed == ["reloaded the app hall", "unloaded the app hall"]
        assert "homebot: no app 'hall' runs" in said.err


@pytest.mark.parametrize("service", [LOAD_APP, UNLOAD_APP, RELOAD_APP])
def test_only_those_who_manage_homebot_change_its_apps(service: str) -> None:
    """A file that is loaded is a program."""
    assert right_to_call(service) is Right.MANAGE


async def test_old_code_is_freed_where_python_seldom_collects_old_objects(tmp_path: Path) -> None:
    """As it does in a process that serves: a thousand reloads left 14 MB."""
    async with home(tmp_path) as runtime:
        runtime.app_manager.trial = 0.0
        await runtime.app_manager.reload("hall")
        second = weakref.ref(runtime.app_manager.apps[0].kind)
        gc.disable()
        try:
            for _ in range(100):
                await runtime.app_manager.reload("hall")
        finally:
            gc.enable()
        assert second() is None


def resident() -> int:
    """Return the bytes of memory that the process has."""
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="it reads Linux's figures of the process")
async def test_reloads_leave_nothing_behind(tmp_path: Path) -> None:
    """Once ``/rosout`` keeps as many lines as it may, the caches of Python are full, and what begins late has begun."""
    rounds = size(200, 1000)
    of_timers = {"TimerHandle", "Context", "hamt", "hamt_bitmap_node"}  # asyncio keeps up to 100 that were cancelled

    def seen(runtime: Runtime) -> tuple[int, int, int, int]:
        gc.collect()
        endpoints = len(runtime.graph.get_endpoints())
        objects = sum(type(item).__name__ not in of_timers for item in gc.get_objects())
        return len(asyncio.all_tasks()), endpoints, len(sys.modules), objects

    async def reload(runtime: Runtime, times: int) -> None:
        for _ in range(times):
            await runtime.app_manager.reload("hall")
            runtime.app_host.context.store_of("hall").clear()

    async with home(tmp_path) as runtime:
        runtime.app_manager.trial = 0.0
        for number in range(1000):
            runtime.app_manager._report("test.line", "a line", f"{number}")
        await reload(runtime, 400)
        with anyio.fail_after(PATIENCE):
            while "/alerts" not in runtime.graph.get_node_names():  # noqa: ASYNC110 - it begins when all else has
                await anyio.sleep(0.01)
        await reload(runtime, rounds)
        first, before = seen(runtime), resident()
        await reload(runtime, rounds)
        second, grown = seen(runtime), resident() - before
        assert second[:3] == first[:3]
        assert abs(second[3] - first[3]) < rounds / 2  # objects; an app alone has more
        assert grown < 1_000_000


TIMER = """
import anyio
from homebot import App

class Timer(App):
    async def run(self):
        self.after(DELAY, self.off, name="off", durable=True, catch_up=CATCH_UP)
        await anyio.sleep_forever()

    def off(self):
        self.store["off"] = self.store.get("off", 0) + 1

DELAY, CATCH_UP = "2h", "0s"
"""


def put_timer(folder: Path) -> Config:
    """An app with a durable timer."""
    (folder / "timer.py").write_text(TIMER)
    return parse_config({"apps": {"timer": {"class": "timer:Timer"}}, "door": {"port": 0}}, "test")


async def test_a_durable_timer_stays_over_a_reload_and_is_taken_over_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    async with Runtime(put_timer(tmp_path), with_door=False) as runtime:
        runtime.app_manager.trial = 0.05
        (before,) = runtime.app_host.running["timer"].jobs
        for old, new in (('"2h"', '"4h"'), ("self.after(", "0 and self.after("), (', "0s"', ', "1s"')):
            (tmp_path / "timer.py").write_text((tmp_path / "timer.py").read_text().replace(old, new))
            await runtime.app_manager.reload("timer")
            (job,) = runtime.app_host.running["timer"].jobs
            assert (job.name, job is before) == ("off", False)
            assert job.next is not None
            assert before.next is not None
            assert abs((job.next - before.next).total_seconds()) < 5
        (tmp_path / "timer.py").write_text(TIMER.replace("self.after(", "0 and self.after(").replace("off", "on"))
        with capture_logs() as lines:
            await runtime.app_manager.reload("timer")
        assert runtime.app_host.running["timer"].jobs == ()
        assert "the job off is skipped: its method off is gone" in str(lines)


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    ("catch_up", "found"),
    [
        ("0s", [(12.0, 0, [2.0]), (15.0, 0, [2.0]), (15.5, 0, [1.5])]),
        ("90m", [(12.0, 0, [2.0]), (15.0, 1, []), (15.5, 1, [2.0])]),
    ],
)
async def test_a_durable_timer_that_was_due_while_homebot_was_stopped_is_called_if_it_catches_up_else_begun_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, catch_up: str, found: list[tuple[float, int, list[float]]]
) -> None:
    """For each start its hour, the calls so far, and the hours until the next."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "timer", raising=False)
    config, index = put_timer(tmp_path), tmp_path / "index.sqlite"
    (tmp_path / "timer.py").write_text(TIMER.replace('"0s"', f'"{catch_up}"'))
    for hour, calls, left in found:
        clock = LoopClock(1_780_000_000.0 + 3600 * hour)
        with capture_logs() as lines:
            async with Runtime(config, with_door=False, index_file=index, clock=clock) as runtime:
                await anyio.sleep(1)
                timer = runtime.app_host.running["timer"]
                times = [job.next.timestamp() - clock.now() for job in timer.jobs if job.next is not None]
                assert (timer.store.get("off", 0), [round(one / 3600, 2) for one in times]) == (calls, left)
        is_skipped = (hour, catch_up) == (15.0, "0s")
        assert ("the job off is skipped: it was due 1 h 0 min ago" in str(lines)) == is_skipped
