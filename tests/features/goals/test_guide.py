"""What docs/goals.md shows works."""

from collections.abc import Iterator

import pytest
from tests.guide import commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("goals")
COMMANDS = commands_in(GUIDE)
HOUSE = """
[house]
dialect = "homeassistant"
pace = 10.0
[rooms.hall]
size = [4.0, 3.0]
doors = ["kitchen"]
[rooms.kitchen]
x = 4.0
size = [4.0, 3.0]
[devices.hall_lamp]
kind = "lamp"
room = "hall"
[devices.kitchen_lamp]
kind = "lamp"
room = "kitchen"
"""


@pytest.fixture(scope="module")
def family(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    """The house of a reader, with its errands."""
    until = ("found kitchen_lamp", "found hall_lamp", "is running", "the robot is in")
    with homebot_in(tmp_path_factory.mktemp("family"), "--ephemeral", until=until) as homebot:
        yield homebot


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    folder = tmp_path_factory.mktemp("house")
    (folder / "homebot.toml").write_text("[gateways.mqtt]\n")  # no light_service: it turns off what a goal has lit
    until = ("found hall_lamp", "found kitchen_lamp", "is running", "the robot is in hall")
    with homebot_in(folder, house=HOUSE, until=until) as homebot:
        yield homebot


def test_the_guide_shows_commands() -> None:
    assert len(COMMANDS) == 3


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(family: Homebot, command: str) -> None:
    done = family.run(command)
    assert done.returncode == 0, done


def test_a_step_is_in_the_journal_with_its_goal(home: Homebot) -> None:
    home.run("homebot achieve 'kitchen dark'")
    done = home.run("homebot achieve 'kitchen lit'")
    assert done.stdout.startswith("1. turn on kitchen_lamp\n1. turn on kitchen_lamp: confirmed")
    assert "the goal 'kitchen lit' needs it" in home.run("homebot why kitchen_lamp").stdout


def test_a_room_that_is_not_there_is_an_error_with_the_nearest_name(home: Homebot) -> None:
    done = home.run("homebot achieve 'kichen lit'")
    assert (done.returncode, done.stdout) == (1, "there is no room 'kichen'; did you mean kitchen?\n")
