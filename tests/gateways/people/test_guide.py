"""Everything that docs/people.md shows works."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.shell import Homebot, homebot_in

from homebot.cli.main import main
from homebot.routines.conditions import read_condition
from homebot.routines.triggers import read_trigger

pytestmark = [pytest.mark.slow, pytest.mark.rooms("espresense", "owntracks")]

GUIDE = (Path(__file__).parents[3] / "docs/people.md").read_text("utf-8")
COMMANDS = re.findall(r"^\$ (.*)$", GUIDE, re.MULTILINE)
TABLES = re.findall(r"```toml\n(.*?)```", GUIDE, re.DOTALL)
CONDITIONS, TRIGGERS = re.search(r"take (.*?) as conditions, and\s+(.*?) as triggers", GUIDE, re.DOTALL).groups()  # type: ignore[union-attr]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    path = tmp_path_factory.mktemp("home")
    quiet = "\n".join(TABLES).replace("192.168.1.23", "127.0.0.1")
    (path / "homebot.toml").write_text(f'{quiet}\n[home]\nzone = "UTC"\n')
    with homebot_in(path, until=("found household", "door_left_open")) as homebot:
        yield homebot


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(
    home: Homebot, command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(home.folder)
    monkeypatch.setenv("HOMEBOT_DOOR", home.door)
    program, *words = shlex.split(command)
    assert program == "homebot"
    assert main(words) == 0, capsys.readouterr()
    assert capsys.readouterr().out


def test_the_texts_of_the_guide_are_read() -> None:
    conditions, triggers = (re.findall(r"`([^`]+)`", one) for one in (CONDITIONS, TRIGGERS))
    assert (len(conditions), len(triggers)) == (4, 5)
    for text in conditions:
        read_condition(text)
    for text in triggers:
        read_trigger(text)
