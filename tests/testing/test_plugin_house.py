"""The fixtures ``house`` and ``homebot`` in other people's test runs, whoever runs their async tests."""

import re
from importlib import import_module
from inspect import iscoroutinefunction

import pytest
from tests.sizes import nightly
from tests.testing.conftest import ANYIO_ON_ASYNCIO, Tried

from homebot.plugins import load_plugin, plugin_names
from homebot.testing import plugin

pytest_plugins = ["pytester"]

# A run inside the process forgets what was imported in it: what is loaded here is loaded once.
for name in (
    *("apps.jobs", "apps.light_service", "apps.reactions", "bridges.rosapi", "control.control_layer", "control.learnt"),
    *("conventions.secrets", "devices.commander", "devices.hold", "devices.outcomes", "devices.command_sender"),
    *("mqtt.client.aiomqtt_adapter", "testing.event_log", "testing.house_marks", "testing.mqtt"),
):
    import_module(f"homebot.{name}")
for convention in plugin_names("homebot.mqtt_conventions"):
    load_plugin("homebot.mqtt_conventions", convention)

START = """
import asyncio, pytest
from homebot.house import SimulatedLamp, World

def loop():
    return type(asyncio.get_running_loop()).__name__
"""

USE = (
    START
    + """
async def test_a_day_of_the_house(house):
    assert loop() == "VirtualTimeLoop"
    await house.run_for("1h")
    await house.run_until("02:00")
    assert house.now.hour == 2

@pytest.mark.house(
    "light_service", world=lambda: World.of(SimulatedLamp("desk")), root="villa", start="2026-07-01 06:30"
)
async def test_the_mark_says_what_is_in_it(house):
    assert (house.now.month, list(house.world.devices)) == (7, ["desk"])
    await house.says("villa/lights/shelf/out", "on")
    assert await house.hears("villa/lights/shelf/in") == "off"

class TestInAClass:
    @pytest.mark.parametrize("hours", [1, 2])
    async def test_with_parameters(self, hours, house):
        await house.run_for(hours * 3600)
        assert house.now.hour == hours

@pytest.mark.homebot("light_service")
async def test_a_real_homebot(homebot):
    assert loop() != "VirtualTimeLoop"
    assert homebot.runtime.rosbridge.port and homebot.broker_url
    await homebot.says("home425/lights/desk/out", "on")
    assert await homebot.hears("home425/lights/desk/in") == "off"

{mark}

{fixture}
async def warm(house):
    await house.run_for("1h")
    yield house
    await house.run_for("1h")

@pytest.fixture
def behind(warm):
    return warm

async def test_a_fixture_of_my_own_uses_it(behind):
    assert loop() == "VirtualTimeLoop" and behind.now.hour == 1

async def test_other_tests_keep_their_loop():
    assert loop() != "VirtualTimeLoop"
"""
)
ALL = 7

PYTEST_ASYNCIO = "import pytest_asyncio\n\n@pytest_asyncio.fixture"


@pytest.mark.no_cover
def test_pytest_asyncio_in_strict_mode(tried: Tried) -> None:
    tried(USE.format(mark="pytestmark = pytest.mark.asyncio", fixture=PYTEST_ASYNCIO), "-p no:anyio", passed=ALL)


def test_pytest_asyncio_in_auto_mode(tried: Tried) -> None:
    tried(USE.format(mark="", fixture="@pytest.fixture"), "--asyncio-mode=auto", passed=ALL)


def test_pytest_asyncio_with_one_loop_for_all_tests(tried: Tried) -> None:
    """A test in virtual time gets its own nevertheless, and what lives on the wide loop stays there."""
    wide = """
UP = []

@pytest.fixture(scope="session")
async def database():
    UP.append(loop())
    yield

async def test_before(database): pass
async def test_between(house): assert loop() == "VirtualTimeLoop"
async def test_after(database, homebot): assert UP == [loop()]
"""
    scopes = "-o asyncio_default_fixture_loop_scope=session -o asyncio_default_test_loop_scope=session"
    tried(START + wide, f"--asyncio-mode=auto {scopes}", passed=3)


@pytest.mark.no_cover
def test_the_plugin_of_anyio(tried: Tried) -> None:
    tried(
        USE.format(mark="pytestmark = pytest.mark.anyio", fixture="@pytest.fixture"),
        "-p no:asyncio",
        conftest=ANYIO_ON_ASYNCIO,
        passed=ALL,
    )


@pytest.mark.no_cover
def test_no_plugin_at_all(tried: Tried) -> None:
    """Then homebot runs the tests that use its fixtures, and those alone."""
    options = "-p no:asyncio -p no:anyio -k 'not fixture_of_my_own and not other_tests'"
    tried(USE.format(mark="", fixture="@pytest.fixture"), options, passed=ALL - 2, deselected=2)


def test_xdist(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        "async def test_one(house): pass\n\nasync def test_two(homebot): pass\n\n"
        "def test_three(mqtt_broker_thread): pass\n"
    )
    pytester.runpytest_subprocess("-p", "no:cacheprovider", "-p", "no:asyncio", "-n", "1").assert_outcomes(passed=3)


def test_without_a_mark_the_house_is_that_of_the_thesis_and_tests_do_not_share_it(tried: Tried) -> None:
    tests = """
SHARED = World.of(SimulatedLamp("desk"))

@pytest.mark.parametrize("again", [1, 2])
@pytest.mark.house(world=SHARED)
async def test_each_has_its_own(house, again):
    assert house.world is not SHARED
    await house.run_for("1h")

async def test_the_thesis(house):
    assert "firstlevel1" in house.world.devices
"""
    tried(START + tests, passed=3)


def test_a_file_lies_beside_the_test(pytester: pytest.Pytester, tried: Tried) -> None:
    folder = pytester.mkdir("below")
    (folder / "house.toml").write_text("[rooms.hall]\n[devices.desk]\nkind = 'lamp'\nroom = 'hall'\n")
    (folder / "homebot.toml").write_text("[home]\nname = 'villa'\n[apps.light_service]\n")
    (folder / "test_files.py").write_text(
        START
        + """
@pytest.mark.house(world="house.toml", seed=7, config="homebot.toml", root="villa")
async def test_a_house(house):
    assert list(house.world.devices) == ["desk"]
    await house.press("desk", "on")
    assert house.world.device("desk").state() == "off"  # the light service of homebot.toml

@pytest.mark.house(config={"apps": {"mine": {"class": "light_service"}}})
async def test_tables(house):
    assert "/mine" in house.runtime.graph.get_node_names()

@pytest.mark.homebot(config="homebot.toml", root="villa")
async def test_a_homebot(homebot):
    await homebot.says("villa/lights/desk/out", "on")
    assert await homebot.hears("villa/lights/desk/in") == "off"
"""
    )
    tried("", passed=3)


def test_the_nearest_mark_counts_most(tried: Tried) -> None:
    tests = """
from homebot.apps import App

class Mine(App):
    async def run(self): pass

pytestmark = pytest.mark.house("light_service", root="villa", start="2026-07-01")

@pytest.mark.house(Mine, start="2026-08-01")
async def test_the_nearest(house):
    assert house.now.month == 8
    await house.says("villa/lights/desk/out", "on")
    await house.run_for(1)
    assert "villa/lights/desk/out on" in str(house.log) and "/in off" not in str(house.log)
"""
    tried(START + tests, passed=1)


def test_a_homebot_on_the_broker_of_the_test(tried: Tried) -> None:
    tests = """
@pytest.fixture
def homebot_config(mqtt_broker):
    return {"gateways": {"mqtt": {"url": mqtt_broker.url, "act": True}}}

@pytest.mark.homebot("light_service")
async def test_it(homebot, mqtt_broker):
    assert homebot.broker_url == mqtt_broker.url
    await mqtt_broker.publish("home425/lights/desk/out", "on")
    await mqtt_broker.expect("home425/lights/desk/in", "off")
"""
    tried(START + tests, "--asyncio-mode=auto", passed=1)


MISTAKES = {
    "@pytest.mark.house(wrold=1)": "@pytest.mark.house, wrold is unknown; known are allow_crashes, config, *",
    "@pytest.mark.house(config={'x': 1})": "@pytest.mark.house, config: tables: x: unknown key; *",
    "@pytest.mark.house(world='no.toml')": "@pytest.mark.house, world: *no.toml does not exist*",
    "@pytest.mark.house(world=5)": "@pytest.mark.house, world: 5 is not a house: give a TOML file, a World, or a *",
    "@pytest.mark.house(start='noon')": "@pytest.mark.house, start: 'noon' is not a time; *",
    "@pytest.mark.house(heartbeat=0)": "@pytest.mark.house, heartbeat: 0 is not a heartbeat interval; *",
    "@pytest.mark.house(seed='x')": "@pytest.mark.house, seed: 'x' is not a whole number",
    "@pytest.mark.house(5)": "@pytest.mark.house, app 1: 5 is not an app: *",
    "@pytest.mark.house('no_such')": "*no_such*is not installed*",
    "@pytest.mark.homebot(world=1)": "@pytest.mark.homebot, world is unknown; known are allow_crashes, config, root",
    "@pytest.mark.homebot(config=5)": "@pytest.mark.homebot, config: 5 is not a configuration: *",
    "@pytest.mark.homebot(config={'x': 1})": "@pytest.mark.homebot, config: tables: x: unknown key; *",
}


def test_a_mistake_in_a_mark_is_told_with_the_argument(tried: Tried) -> None:
    tests = [
        f"{mark}\nasync def test_{number}({'homebot' if 'homebot' in mark else 'house'}): pass\n"
        for number, mark in enumerate(MISTAKES)
    ]
    run = tried("import pytest\n" + "\n".join(tests), errors=len(MISTAKES), lines=list(MISTAKES.values()))
    run.stdout.no_fnmatch_line("*During handling*")  # each was told three times


def test_what_cannot_be_is_told_with_the_way_out(pytester: pytest.Pytester, tried: Tried) -> None:
    tests = """
def test_plain(house): pass

async def test_two_times(house, mqtt_broker_thread): pass

@pytest.fixture(scope="module")
async def wide(anyio_backend): yield

@pytest.mark.anyio
async def test_a_wide_fixture(wide): pass

@pytest.mark.anyio
async def test_on_its_loop(house): pass
"""
    pytester.makeconftest(
        "import pytest\n\n@pytest.fixture(scope='session')\ndef anyio_backend():\n    return 'asyncio'\n"
    )
    tried(
        START + tests,
        "-p no:asyncio",
        passed=1,
        errors=3,
        lines=[
            "`house` needs an async test: write `async def test_plain(*):`",
            "`house` has its own time and broker, `mqtt_broker` runs in real time: use only one of them",
            "`house` needs a loop of virtual time, and this test runs on a *Loop, which could not be replaced. *",
        ],
    )


def test_a_test_that_two_plug_ins_want_is_told_so(tried: Tried) -> None:
    tried(
        START + "\n@pytest.mark.anyio\nasync def test_it(house): pass\n",
        "--asyncio-mode=auto",
        conftest=ANYIO_ON_ASYNCIO,
        errors=1,
        lines=["`house` has one loop, but two plug-ins claim this test: pytest-asyncio*"],
    )


def test_a_class_alone_is_marked_with_args(tried: Tried) -> None:
    """What ``mark(Class)`` means to pytest is that the class is marked."""
    tests = """
from homebot.apps import App

ran = []

class Mine(App):
    async def run(self): ran.append(self)

@pytest.mark.house.with_args(Mine)
async def test_it(house):
    assert len(ran) == 1
"""
    tried(START + tests, passed=1)


def test_a_failed_test_shows_what_happened(tried: Tried) -> None:
    tests = """
from homebot.apps import App

class Broken(App):
    async def run(self): raise RuntimeError("broken")

@pytest.mark.house(Broken, world=World.of)
async def test_it(house):
    await house.says("home425/lights/desk/out", "on")
    await house.hears("home425/lights/desk/in", within=60)
"""
    tried(
        START + tests,
        failed=1,
        lines=[
            "*what happened in `house`*",
            "it is 2026-01-01 00:01:00 UTC in the house; crashed: broken",
            "broken: it crashed: RuntimeError: broken",
            "00:00:00.000  desk                on",
        ],
    )


def test_a_failed_test_says_what_was_commanded_before_its_first_line(tried: Tried) -> None:
    """It said that nothing was, although the app had turned on the lamps as it began."""
    tests = """
from homebot import App, Light

class Bright(App):
    async def run(self):
        self.on(self.devices.follow(Light).only("appeared"), self.light)

    async def light(self, change):
        await change.handle.turn_on()
        raise ValueError("odd")

@pytest.mark.house(Bright, world=lambda: World.of(SimulatedLamp("desk")))
async def test_it(house):
    assert False
"""
    lines = [
        "bright: the handler light failed: ValueError: odd",
        "00:00:00.000  lights/desk *→ on * bright",
    ]
    tried(START + tests, failed=1, lines=lines)


def test_an_app_that_crashed_fails_its_test_unless_that_is_meant(tried: Tried) -> None:
    """It was started again, so that the test itself may see nothing of it."""
    tests = """
from homebot.apps import App

class Broken(App):
    async def run(self): raise RuntimeError("broken")

@pytest.mark.house(Broken, world=World.of)
async def test_it(house):
    await house.run_for("1m")

@pytest.mark.house(Broken, world=World.of, allow_crashes=True)
async def test_that_it_crashes(house):
    await house.run_for("1m")
    assert house.crashed == ("broken",)
"""
    tried(
        START + tests,
        passed=2,
        errors=1,
        lines=["broken crashed; where that is meant, @pytest.mark.house(allow_crashes=True)"],
    )


BLOCKING = """
import select, time
from homebot import App, Light

class Blocking(App):
    async def run(self):
        self.on(self.devices.follow(Light).became(on=True), self.seen)

    async def seen(self, change):
        {code}

@pytest.mark.{fixture}.with_args(Blocking)
async def test_it({fixture}):
    await {fixture}.says("home425/lights/desk/out", "on")
    await {fixture}.becomes("desk", on=True)
    await asyncio.sleep(1)
"""


@pytest.mark.parametrize("fixture", ["house", "homebot"])
def test_an_app_that_waits_without_await_fails_its_test_with_its_line(tried: Tried, fixture: str) -> None:
    """In virtual time nobody saw it; at home nothing else would have run."""
    tests = BLOCKING.format(fixture=fixture, code="select.select((), (), (), 3)")
    line = "*.py:15 (seen) blocked the event loop: make it await, or run it in a thread; where that is meant*"
    tried(START + tests, passed=1, errors=1, lines=[line])


@nightly
def test_an_app_that_never_ends_its_turn_ends_its_test_after_half_a_minute(tried: Tried) -> None:
    """Pytest hung for ever, although the guide promised it."""
    lines = ["blocking crashed; *.py:15 (seen) blocked the event loop: make it await, or run it in a thread*"]
    tried(START + BLOCKING.format(fixture="house", code="while True: pass"), passed=1, errors=1, lines=lines)


def test_a_misspelt_name_in_a_query_of_an_app_fails_its_test(tried: Tried) -> None:
    """The query waits for a device that has the name, so that a short test sees nothing of it."""
    tests = """
from homebot import App, DoorLock, Light

class Misspelt(App):
    async def run(self):
        self.on(self.devices.follow(Light, name="dsek"), print)
        await self.devices.find(Light, name="desck")
        await self.devices.find(Light, area="nowhere")
        await self.devices.find(DoorLock)

class Once(App):
    async def run(self):
        await self.devices.find(Light, name="desck")

WORLD = {"world": lambda: World.of(SimulatedLamp("desk"))}

@pytest.mark.house(Misspelt, **WORLD)
async def test_it(house):
    await house.run_for("1s")

@pytest.mark.parametrize("time", ["1s", "1m"])
@pytest.mark.house(Once, **WORLD)
async def test_an_app_that_ends_at_once(house, time):
    await house.run_for(time)

@pytest.mark.house(Misspelt, allow_crashes=True, **WORLD)
async def test_that_it_waits(house):
    await house.run_for("1m")
    assert house.crashed == ()
"""
    find = "misspelt: find(Light, name='desck'): nothing is called 'desck'; did you mean desk?"
    follow = "misspelt: follow(Light, name='dsek'): nothing is called 'dsek'; did you mean desk?"
    room = "misspelt: find(Light, area='nowhere'): no device is in 'nowhere'; *"
    kind = "misspelt: find(DoorLock): nothing in the house is of this type"
    tried(
        START + tests,
        passed=4,
        errors=3,
        lines=[
            f"{find}; {room}; {kind}; {follow}; where that is meant, *allow_crashes=True)",
            "once: find(Light, name='desck'): nothing is called 'desck'; did you mean desk?; where that is meant, *",
            "once: find(Light, name='desck'): nothing is called 'desck'; did you mean desk? *",
        ],
    )


def test_a_house_of_ones_own_is_left_alone(pytester: pytest.Pytester, tried: Tried) -> None:
    """Others may have fixtures of these names, in tests without any loop."""
    tests = """
import pytest

@pytest.fixture
def house(): return "brick"

@pytest.fixture
def homebot(): return "tin"

def test_it(house, homebot): assert (house, homebot) == ("brick", "tin")
"""
    pytester.makepyfile(
        test_beside_ours="""
import pytest

@pytest.fixture
def mqtt_broker(): return "mine"

async def test_it(mqtt_broker, house): assert mqtt_broker == "mine"
"""
    )
    tried(tests, "--asyncio-mode=auto", passed=2)


def test_loops_that_others_choose_stay_theirs(pytester: pytest.Pytester, tried: Tried) -> None:
    pytester.makeconftest(
        """
import asyncio

class Chosen(asyncio.SelectorEventLoop): pass

def pytest_asyncio_loop_factories(config, item):
    return {"chosen": Chosen}
"""
    )
    tests = """
async def test_mine(): assert loop() == "Chosen"
async def test_virtual(house): assert loop() == "VirtualTimeLoop"
async def test_real(homebot): assert loop() == "Chosen"
"""
    tried(START + tests, "--asyncio-mode=auto", passed=3)


def test_another_library_than_asyncio_is_refused(tried: Tried) -> None:
    tests = """
@pytest.fixture
def anyio_backend(): return "trio"

@pytest.mark.anyio
async def test_it(homebot): pass
"""
    tried(
        START + tests,
        "-p no:asyncio",
        errors=1,
        lines=["`homebot` runs on asyncio, this test on trio: write a fixture *"],
    )


def test_a_run_without_our_fixtures_loads_nothing_for_them(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
import sys

def test_it():
    loaded = {name.removeprefix("homebot.testing.") for name in sys.modules if name.startswith("homebot")}
    ours = {"plugin", "house_fixtures", "pytest_loops", "pytest_asyncio_loops"}
    assert loaded == {"homebot", "homebot.testing", *ours}
"""
    )
    pytester.runpytest_subprocess("-p", "no:cacheprovider").assert_outcomes(passed=1)


def test_a_command_that_nobody_awaits_and_a_hold_that_nobody_enters_fail_their_test(tried: Tried) -> None:
    tests = """
        import gc
        from homebot.devices.handles import Light
        from homebot.devices.hold import HoldBlock

        async def test_forgets():
            Light.turn_off(None)
            gc.collect()

        async def test_forgets_a_step_of_its_own(house):
            house.run_for("1h")
            gc.collect()

        async def test_forgets_to_enter():
            HoldBlock(None, None, "", "open", "robot", 10.0)
            gc.collect()

        async def test_that_is_well():
            pass
        """
    tried(tests, "--asyncio-mode=auto", passed=1, failed=3)


def test_every_command_of_every_kind_is_among_those() -> None:
    handles = import_module("homebot.devices.handles")
    kinds = [one for name in handles.__all__ if isinstance(one := getattr(handles, name), type)]
    commands = {
        command.__qualname__
        for kind in kinds
        if issubclass(kind, handles.Handle)
        for base in kind.__mro__
        for command in vars(base).values()
        if iscoroutinefunction(command)
    }
    pattern = plugin._FORGOTTEN_COMMANDS[0].split(":")[1]
    assert len(commands) > 25
    assert [one for one in commands if not re.match(pattern, f"coroutine '{one}' was never awaited")] == []


def test_an_app_of_the_test_has_the_settings_of_the_table_of_its_name(tried: Tried, pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        garden="""
from homebot import App
from homebot.apps import AppSettings

class Settings(AppSettings):
    plant: str = ""

class Garden(App[Settings]):
    async def run(self):
        await self.notify(self.settings.plant)
"""
    )
    tests = """
@pytest.mark.house("garden:Garden", config={"apps": {"garden": {"plant": "rose"}}})
async def test_it(house):
    assert [one.text for one in house.notifications] == ["rose"]
"""
    tried(START + tests, passed=1)


def test_an_app_that_is_reloaded_keeps_what_lasts_over_a_restart(tried: Tried, pytester: pytest.Pytester) -> None:
    """The durable timer is called when it would have been, the other is gone, and ``run`` begins anew."""
    pytester.makepyfile(
        cellar="""
from homebot import App

class Cellar(App):
    async def run(self):
        self.store["starts"] = self.store.get("starts", 0) + 1
        if self.store["starts"] == 1:
            self.after("1h", self.tell, name="kept", durable=True)
            self.after("1h", self.notify_lost)

    async def tell(self):
        await self.notify(f"{self.store['starts']} starts")

    async def notify_lost(self):
        await self.notify("lost")
"""
    )
    tests = """
@pytest.mark.house("cellar:Cellar")
async def test_it(house):
    await house.run_for("40m")
    await house.reload("cellar")
    await house.run_for("19m")
    assert house.notifications == ()
    await house.run_for("1m")
    assert [one.text for one in house.notifications] == ["2 starts"]

@pytest.mark.house("cellar:Cellar")
async def test_its_name_is_looked_up(house):
    with pytest.raises(Exception, match="no app 'celar' runs; did you mean cellar?"):
        await house.reload("celar")
"""
    tried(START + tests, passed=2)


def test_a_failed_test_shows_commands_and_changes_and_no_raw_messages(tried: Tried) -> None:
    """Under 40 lines of at most 120 columns, the newest last."""
    tests = """
from homebot.house import SimulatedLamp

@pytest.mark.house("light_service", world=lambda: World.of(SimulatedLamp("hall")))
async def test_it(house):
    for number in range(30):
        await house.run_for(f"{10 + number}m7s")  # not a timer
        await house.press("hall", "on")
    await house.becomes("hall", on=True, within="5m")
"""
    result = tried(START + tests, failed=1)
    lines = result.stdout.lines
    begin = next(number for number, line in enumerate(lines) if "what happened in `house`" in line)
    end = next(number for number, line in enumerate(lines[begin + 1 :], begin + 1) if line.startswith(("---", "===")))
    shown = lines[begin:end]
    assert len(shown) < 40
    assert max(map(len, shown)) <= 120
    assert not any("mqtt" in line for line in shown)
    cells = [line.split()[1:] for line in shown[2:]]
    assert ["lights/hall", "on", "by", "hand"] in cells
    assert cells[-1] == ["lights/hall", "off", "as", "commanded", "light_service"]
    result.stdout.fnmatch_lines(["E*hall did not become on=True within 5m: it is on=False"])
