"""Every command that the README shows is run here, and every program in it is the one in ``examples``."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from tests.ports import reserve_door

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
WINDOW_LIGHT = ROOT / "examples" / "02_window_light"

COMMANDS = re.findall(r"^\$ (.*)$", README, re.MULTILINE)

IN_A_SECOND_TERMINAL = [command for command in COMMANDS if command.startswith((".venv/bin/homebot", "homebot do"))]
ON_YOUR_OWN_BROKER = [command for command in COMMANDS if "--mqtt" in command]
RUN_ELSEWHERE_IN_THIS_FILE = [
    'make run ARGS="--for 3"',
    "make test",
    "homebot run --app window_light.py --for 3",
]


@dataclass
class Homebot:
    """A homebot that runs in a process of its own.

    Attributes:
        tables: What the commands that list devices printed before any other command was given.
    """

    door: str
    broker: str
    log: list[str]
    tables: str


def environment(door: str) -> dict[str, str]:
    """As in a shell with the project's .venv activated."""
    return {**os.environ, "HOMEBOT_DOOR": door, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}


def run(command: str, *, door: str = "", cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        shlex.split(command),
        cwd=cwd,
        env=environment(door or reserve_door()),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture(scope="module")
def homebot() -> Iterator[Homebot]:
    """``homebot run`` until the tests are through; it must end well on SIGTERM."""
    door = reserve_door()
    process = subprocess.Popen(
        ["homebot", "run"], env=environment(door), stderr=subprocess.PIPE, text=True, cwd=WINDOW_LIGHT
    )
    assert process.stderr is not None
    log = []
    for line in process.stderr:
        log.append(line)
        if "lights/roomlights405 → off" in line:
            break
    broker = re.search(r"mqtt://\S+?:\d+", "".join(log))
    assert broker is not None
    listed = [run(command, door=door).stdout for command in ("homebot devices", "homebot find 'off lights'")]
    yield Homebot(door, broker[0], log, "".join(listed))
    process.send_signal(signal.SIGTERM)
    _, rest = process.communicate(timeout=120)
    assert process.returncode == 0
    assert "Traceback" not in rest


def test_no_command_is_forgotten() -> None:
    """A new one in the README has to be run here as well."""
    assert sorted(COMMANDS) == sorted(IN_A_SECOND_TERMINAL + ON_YOUR_OWN_BROKER + RUN_ELSEWHERE_IN_THIS_FILE)


def test_make_run_shows_the_house_being_discovered_and_acted_on() -> None:
    """The lines are those that the README shows, but for the time and what a busy machine changes in their order."""
    done = run('make run ARGS="--for 8"')

    assert done.returncode == 0
    for shown in re.findall(r"^\d\d:\d\d:\d\d  (\S+ +.*)$", README, re.MULTILINE):
        varying = r"127\.0\.0\.1:\d+( \(port 1883 was taken\))?|(?<=after )(less than )?[\d.]+(?= s)"
        assert re.sub(varying, "", shown) in re.sub(varying, "", done.stderr)


def test_make_test_exists() -> None:
    """Running it from inside itself would not end."""
    assert "pytest" in run("make -n test").stdout


def test_the_devices_shown_are_the_devices_found(homebot: Homebot) -> None:
    """The tables of the README, but for the time; taken before a command of another test opens the window."""
    shown = re.findall(r"^(?:lights|windows)/.*fresh", README, re.MULTILINE)
    assert len(shown) == 3
    for line in shown:
        assert line in homebot.tables


@pytest.mark.parametrize("command", IN_A_SECOND_TERMINAL)
def test_a_second_terminal_sees_the_running_house(command: str, homebot: Homebot) -> None:
    """Each command prints something and succeeds."""
    done = run(command.replace(".venv/bin/", ""), door=homebot.door)

    assert done.stderr == ""
    assert done.returncode == 0
    assert done.stdout


@pytest.mark.parametrize("command", ON_YOUR_OWN_BROKER)
def test_your_own_broker_is_discovered_and_acted_on_only_when_told(command: str, homebot: Homebot) -> None:
    """The running house's broker plays yours."""
    done = run(command.replace("mqtt://127.0.0.1:1883", homebot.broker))

    assert done.returncode == 0
    assert "found lights/roomlights405" in done.stderr
    assert ("(observing only)" in done.stderr) == ("--act" not in command)


def test_the_app_of_the_readme_runs_in_the_simulated_house() -> None:
    """From its folder, instead of the light service."""
    done = run("homebot run --app window_light.py --for 3", cwd=WINDOW_LIGHT)
    assert done.returncode == 0
    assert "found windows/firstlevel1" in done.stderr


def test_the_program_shown_is_that_of_the_example() -> None:
    assert f"```python\n{(WINDOW_LIGHT / 'window_light.py').read_text()}```" in README


def test_the_configuration_shown_passes_its_check(tmp_path: Path) -> None:
    """With the password where the test may write it."""
    found = re.search(r"```toml\n(.*?)```", README, re.DOTALL)
    assert found is not None
    password = tmp_path / "password"
    password.touch(mode=0o600)
    password.write_text("secret\n")
    (tmp_path / "homebot.toml").write_text(found[1].replace("/etc/homebot/password", str(password)))
    done = run("homebot config check --config homebot.toml", cwd=tmp_path)
    assert done.stdout.startswith("homebot.toml is valid: home villa")
    assert done.returncode == 0
