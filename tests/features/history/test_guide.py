"""Every command of the guide runs, in the house of a reader."""

from collections.abc import Iterator

import pytest
from tests.guide import commands_in, guide
from tests.patience import PATIENCE
from tests.shell import homebot_in, run
from tests.system.attack_probe import until
from tests.whole_house import WHOLE_HOUSE

from homebot.features.history.command import plot_lines

pytestmark = pytest.mark.slow

GUIDE = guide("history")
COMMANDS = commands_in(GUIDE)


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with homebot_in(tmp_path_factory.mktemp("house"), "--ephemeral", until=("is running",)) as homebot:
        until(lambda: homebot.run(COMMANDS[0]).stderr == "" or None, PATIENCE)  # it begins after the start
        yield homebot.door


@WHOLE_HOUSE
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(door: str, command: str) -> None:
    """A young history may have little; a command waits for its begin."""
    done = run(command, door=door)
    assert done.stderr == ""
    assert done.stdout


@WHOLE_HOUSE
def test_a_young_history_has_more_than_one_row(door: str) -> None:
    """Rows were cut for the whole time asked for: of the first evening there was one, with the mean."""
    done = run("homebot history desk_meter --since 30d", door=door)
    assert "VALUE" in done.stdout


@WHOLE_HOUSE
def test_a_history_is_never_that_of_a_similar_device(door: str) -> None:
    """The beginning of its name was enough."""
    done = run("homebot history 'desk mete'", door=door)
    assert (done.returncode, done.stdout) == (1, "")
    assert "no device has the word 'mete'; similar: " in done.stderr


def test_a_plot_shows_the_largest_value_on_top_and_a_pause_blank() -> None:
    lines = plot_lines([0.0, 10.0, 90.0], [1.0, 5.0, 1.0], 0.0, 100.0, 31, 4)
    assert lines[0] == "        5 │  █"
    assert lines[3] == "        1 │▁ █               ▁"
