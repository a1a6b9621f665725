"""Everything that docs/people.md shows works."""

import re
from collections.abc import Iterator

import pytest
from tests.guide import blocks_in, commands_in, guide
from tests.shell import Homebot, homebot_in

from homebot.words.conditions import read_condition
from homebot.words.triggers import read_trigger

pytestmark = [pytest.mark.slow, pytest.mark.rooms("espresense", "owntracks")]

GUIDE = guide("people")
COMMANDS = commands_in(GUIDE)
TABLES = blocks_in(GUIDE, "toml")
CONDITIONS, TRIGGERS = re.search(r"take (.*?) as conditions, and\s+(.*?) as triggers", GUIDE, re.DOTALL).groups()  # type: ignore[union-attr]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    path = tmp_path_factory.mktemp("home")
    quiet = "\n".join(TABLES).replace("192.168.1.23", "127.0.0.1")
    (path / "homebot.toml").write_text(f'{quiet}\n[home]\nzone = "UTC"\n')
    with homebot_in(path, until=("found household", "door_left_open")) as homebot:
        yield homebot


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(home: Homebot, command: str) -> None:
    done = home.run(command)
    assert (done.returncode, done.stdout != "") == (0, True), done


def test_the_texts_of_the_guide_are_read() -> None:
    conditions, triggers = (re.findall(r"`([^`]+)`", one) for one in (CONDITIONS, TRIGGERS))
    assert (len(conditions), len(triggers)) == (5, 6)
    for text in conditions:
        read_condition(text)
    for text in triggers:
        read_trigger(text)
