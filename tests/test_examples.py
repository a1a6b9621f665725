"""Every example runs as it is."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from anyio import to_thread
from tests.shell import homebot_in
from tests.sizes import nightly
from tests.whole_house import WHOLE_HOUSE

from homebot.house import thesis_world
from homebot.testing import EventLog, virtual_house_of

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize(
    ("program", "last_line"),
    [
        ("01_talker_and_listener.py", "heard three"),
        ("03_services.py", "ServiceUnavailableError: service /switch has no server"),
        ("04_live_devices.py", "that is all"),
    ],
)
def test_an_example_runs_and_ends_as_it_should(program: str, last_line: str) -> None:
    """Its last word shows that it came to its end."""
    done = subprocess.run(
        [sys.executable, EXAMPLES / program], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert any(line.startswith(last_line) for line in done.stdout.splitlines())


def test_the_app_runs_as_a_program_until_ctrl_c() -> None:
    """In the simulated house."""
    program = [sys.executable, str(EXAMPLES / "02_window_light" / "window_light.py")]
    environment = {**unmarked(), "HOMEBOT_DOOR": "127.0.0.1:0"}
    with subprocess.Popen(program, stderr=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stderr is not None
        assert any("running the app window_light" in line for line in process.stderr)  # reads until that line
        process.send_signal(signal.SIGINT)
        _, rest = process.communicate(timeout=120)
    assert "Traceback" not in rest
    assert process.returncode == 0


def test_the_gateway_runs_as_the_list_says_and_changes_nothing_of_the_example(tmp_path: Path) -> None:
    """Its lamps are files that it writes: they are made, in a folder that git ignores."""
    row = next(line for line in (EXAMPLES / "README.md").read_text().splitlines() if line.startswith("| `06_gateway/`"))
    begin, *prepare, run = re.findall(r"`(.*?)`", row)[1].split(" && ")
    assert begin == "cd examples/06_gateway"
    assert prepare
    assert "/examples/06_gateway/lamps/" in (EXAMPLES.parent / ".gitignore").read_text().splitlines()
    folder = tmp_path / "06_gateway"
    shutil.copytree(EXAMPLES / "06_gateway", folder, ignore=shutil.ignore_patterns("lamps", "__pycache__"))
    given = {path: path.read_bytes() for path in folder.iterdir()}
    for command in prepare:
        subprocess.run(["sh", "-c", command], cwd=folder, check=True)
    program, *arguments = shlex.split(run)
    assert program == "homebot"
    assert arguments.pop(0) == "run"
    with homebot_in(folder, *arguments, until=("found hall on folder",)):
        pass
    assert {path.name for path in folder.iterdir()} - {path.name for path in given} <= {"lamps", "__pycache__"}
    given.pop(folder / "homebot.toml")  # homebot writes the id of the home into it
    assert {path: path.read_bytes() for path in given} == given


@WHOLE_HOUSE
def test_the_robot_turns_on_the_nearest_lamp_by_the_way_through_the_door_if_it_sees_it() -> None:
    """By air the lamp behind the wall is nearer; it is not in view, and stays off. The program has at most 40 lines."""
    folder = EXAMPLES / "08_robot"
    assert len((folder / "robot.py").read_text().splitlines()) <= 40
    until = ("found hall_lamp", "found kitchen_lamp", "the robot is in hall")
    with homebot_in(folder, "--config", "homebot.toml", "--house", "house.toml", until=until) as homebot:
        done = homebot.run("python robot.py")
        other = homebot.run("python robot.py")
        still_off = homebot.run("homebot find 'off light'").stdout
        homebot.run("homebot do kitchen_lamp on")
        dark = homebot.run("python robot.py")
    assert (dark.returncode, dark.stderr[:12]) == (1, "rosie was in"), dark.stderr  # no lamp is off any more
    assert other.returncode == 1
    assert re.match("kitchen_lamp stays as it is: .*(sees none of them|is not in view)", other.stderr), other.stderr
    assert "kitchen_lamp" in still_off
    assert "hall_lamp" not in still_off
    assert done.returncode == 0, done.stderr
    hall, kitchen, seen, outcome = done.stdout.splitlines()
    assert hall.startswith("hall_lamp - ")
    assert kitchen.startswith("kitchen_lamp - ")
    assert seen == "hall_lamp is in view"
    assert outcome.startswith("hall_lamp is on: confirmed")


@pytest.fixture(params=["embedded", pytest.param("mosquitto_url", marks=pytest.mark.system)])
def broker(request: pytest.FixtureRequest) -> tuple[str, ...]:
    """The options of ``homebot run`` for a broker."""
    return () if request.param == "embedded" else ("--mqtt", request.getfixturevalue(request.param), "--act")


@WHOLE_HOUSE
async def test_two_robots_go_one_after_the_other_in_the_house_of_the_family_with_its_errands(
    broker: tuple[str, ...],
) -> None:
    """The program has at most 40 lines."""
    folder = EXAMPLES / "13_robot_way"
    assert len((folder / "robot_way.py").read_text().splitlines()) <= 40

    def run() -> str:
        until = ("robots/robot is in the kitchen", "robots/rosie is in the kitchen")
        with homebot_in(folder, "--house", "family", "--app", "robot_way.py", *broker, until=until) as homebot:
            return "".join(homebot.log)

    log = await to_thread.run_sync(run)
    first, second = sorted(("robot", "rosie"), key=lambda name: log.index(f"robots/{name} → text 'go kitchen'"))
    steps = (
        "kitchen_lamp → on",  # by this app, or by follow_me where somebody moved
        f"robots/{first} → text 'go kitchen'",
        f"robots/{first} is in the kitchen",
        f"kitchen_door#cover is no longer held open by robots/{first}",
        f"robots/{second} → text 'go kitchen'",
    )
    places = [log.index(step) for step in steps]
    assert places == sorted(places)


def test_every_example_is_in_the_list() -> None:
    """A reader finds it in the table."""
    table = (EXAMPLES / "README.md").read_text()
    for entry in EXAMPLES.iterdir():
        if entry.name[0].isdigit():
            assert f"`{entry.name}" in table


BARE = tuple(flag for name in ("asyncio", "timeout", "xdist", "cov", "anyio") for flag in ("-p", f"no:{name}"))
"""As in an environment with no plug-in of pytest but ours and Hypothesis's: their options are unknown then."""


@pytest.mark.virtual_time
@WHOLE_HOUSE
async def test_the_app_of_the_readme_commands_nothing_at_a_heartbeat(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each device repeats its state every two seconds; lamps are commanded when the window opens and closes."""
    monkeypatch.syspath_prepend(str(EXAMPLES / "02_window_light"))
    told = "home425/lights/"
    async with (
        virtual_house_of("window_light:WindowLight", world=thesis_world(), heartbeat="2s") as house,
        EventLog.of(house) as log,
    ):

        def commands() -> int:
            return sum(told in one and "/in " in one for one in str(log).splitlines())

        await house.run_for("5m")
        assert commands() == 0
        await house.press("firstlevel1", "open")
        await house.run_for("5m")
        assert commands() == 2
        assert [house.world.device(one).state() for one in ("philips165", "roomlights405")] == ["on", "on"]
        await house.press("firstlevel1", "close")
        await house.run_for("5m")
        assert commands() == 4


@pytest.mark.parametrize(
    ("folder", "flags"),
    [
        pytest.param("02_window_light", (), id="window light", marks=nightly),  # tests of a guide run it as well
        pytest.param("02_window_light", BARE, id="window light, no plug-in"),
        pytest.param("02_window_light", BARE[2:], id="window light, pytest-asyncio alone", marks=nightly),
        pytest.param("05_random_days", (), id="random days"),
        pytest.param("05_random_days", BARE, id="random days, no plug-in", marks=nightly),
        pytest.param("07_thesis_light_service", (), id="thesis"),
        pytest.param("07_thesis_light_service", BARE, id="thesis, no plug-in", marks=nightly),
        pytest.param("09_button", (), id="button"),
        pytest.param("13_robot_way", (), id="robot's way"),
        pytest.param("14_manual_override", (), id="manual override"),
        pytest.param("15_office", (), id="office"),
    ],
)
@WHOLE_HOUSE
def test_the_tests_of_an_example_pass_without_a_warning_whatever_is_installed(
    folder: str, flags: tuple[str, ...]
) -> None:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-W", "error", "--strict-config", *flags]
    done = subprocess.run(
        command, cwd=EXAMPLES / folder, capture_output=True, text=True, timeout=120, check=False, env=unmarked()
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()


def unmarked() -> dict[str, str]:
    """The environment without what coverage and pytest set for their own children."""
    return {name: value for name, value in os.environ.items() if not name.startswith(("COV_", "PYTEST_"))}
