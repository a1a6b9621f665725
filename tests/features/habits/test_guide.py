"""What docs/habits.md shows works, also in a house without habits."""

from collections.abc import Iterator

import pytest
from tests.guide import commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("habits")
COMMANDS = commands_in(GUIDE)


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    """The house of a reader, whose people touch no switch."""
    until = ("found hall_lamp", "is running")
    with homebot_in(tmp_path_factory.mktemp("house"), "--ephemeral", until=until) as homebot:
        while "has not begun yet" in homebot.run("homebot suggest").stderr:  # the history begins later
            pass
        yield homebot


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(home: Homebot, command: str) -> None:
    done = home.run(command)
    if "accept" in command or "reject" in command:
        assert (done.returncode, done.stderr) == (1, "homebot: there is nothing to propose\n")
    else:
        assert done.returncode == 0, done
        assert done.stdout.startswith("there is no routine" if "routine" in command else "nothing to propose: ")


def test_nothing_is_an_empty_list(home: Homebot) -> None:
    assert home.run("homebot suggest --json").stdout == "[]\n"
