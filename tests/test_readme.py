"""Every command that the README shows is run here, and every program in it is the one in ``examples``."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.guide import commands_in
from tests.shell import Homebot, homebot_in, run
from tests.whole_house import WHOLE_HOUSE

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
WINDOW_LIGHT = ROOT / "examples" / "02_window_light"

COMMANDS = commands_in(README)

IN_A_SECOND_TERMINAL = [command for command in COMMANDS if command.startswith((".venv/bin/homebot", "homebot do"))]
ON_YOUR_OWN_BROKER = [command for command in COMMANDS if "--mqtt" in command]
RUN_ELSEWHERE_IN_THIS_FILE = [
    'make run ARGS="--for 15"',
    "make test",
    "homebot run --app window_light.py --for 3",
]


@pytest.fixture(scope="module")
def homebot() -> Iterator[Homebot]:
    """The house of ``make run``."""
    with homebot_in(WINDOW_LIGHT, until=("found shellydimmer",)) as run:
        yield run


@pytest.fixture(scope="module")
def small() -> Iterator[Homebot]:
    """The small house."""
    with homebot_in(WINDOW_LIGHT, "--house", "thesis", until=("lights/roomlights405 → off",)) as run:
        yield run


def test_no_command_is_forgotten() -> None:
    """A new one in the README has to be run here as well."""
    assert sorted(COMMANDS) == sorted(IN_A_SECOND_TERMINAL + ON_YOUR_OWN_BROKER + RUN_ELSEWHERE_IN_THIS_FILE)


@WHOLE_HOUSE
def test_make_run_shows_the_house_being_discovered_and_acted_on() -> None:
    """Where there is no terminal it is the log; the view that the README shows is tested with the command line."""
    done = run('make run ARGS="--for 12"')
    assert done.returncode == 0
    assert "family is running" in done.stderr
    assert "found kitchen_lamp on mqtt" in done.stderr
    assert "_lamp → on, by follow_me: confirmed" in done.stderr


def test_make_test_exists() -> None:
    """Running it from inside itself would not end."""
    assert "pytest" in run("make -n test").stdout


@WHOLE_HOUSE
@pytest.mark.parametrize("command", IN_A_SECOND_TERMINAL)
def test_a_second_terminal_sees_the_running_house(command: str, homebot: Homebot, small: Homebot) -> None:
    """Each command prints something and succeeds; but one of the family's lamps lies, which is a problem."""
    done = run(command.replace(".venv/bin/", ""), door=(homebot if command.startswith(".venv") else small).door)

    assert done.stderr == ""
    assert done.returncode == ("problems found" in done.stdout and "doctor" in command)
    assert done.stdout


@pytest.mark.parametrize("command", ON_YOUR_OWN_BROKER)
def test_your_own_broker_is_discovered_and_acted_on_only_when_told(command: str, small: Homebot) -> None:
    """The running house's broker plays yours."""
    broker = re.search(r"mqtt://\S+?:\d+", "".join(small.log))
    assert broker is not None
    done = run(command.replace("mqtt://127.0.0.1:1883", broker[0]))

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
