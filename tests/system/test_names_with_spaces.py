"""Names with spaces, in quotation marks, are read wherever a name is written; and a fresh log has short lines."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from tests.shell import Homebot, homebot_in, run

from homebot.devices.query.terms import leaves
from homebot.words.triggers import PersonMoves, read_trigger

pytestmark = [pytest.mark.slow, pytest.mark.rooms("thesis")]

CONFIG = """
[home]
name = "home425"
[gateways.mqtt]
root = "home425"
[apps.follow_me]
rooms = ["Room 165"]
act = ['light in "Room 165"']
[[groups]]
name = "Far lamps"
members = 'lights in "Room 165"'
[[groups]]
name = "Both lamps"
members = 'group="Far lamps" or light in "Room 405"'
[[scenes]]
name = "Far off"
values = { 'light in "Room 165"' = "off", '"roomlights405"' = "off" }
[control.presence_guard]
commands = ['close light in "Room 165"']
[[control.quiet_hours]]
start = "02:00"
end = "02:01"
commands = ['use light in "Room 165"']
[[control.interlocks]]
commands = ['turn on light in "Room 165"']
while = 'unlocked lock in "Room 405"'
where = "home"
"""
ROUTINE = """
name = "Far away"
when = ['light in "Room 165" on for 5m', 'no light in "Room 165" on for 9m', 'robot arrives in "Room 165"']
if = ['not light in "Room 405" on', 'no light in "Room 405" on or light in "Room 165" on']
do = [
    'lights in "Room 165" off', 'robot go to "Room 165"', 'scene "Far off"',
    'wait until light in "Room 165" off, at most 5s',
]
"""
COMMANDS = {
    "homebot config check": "is valid",
    "homebot find 'light in \"Room 165\"'": "lights/philips165",
    "homebot find 'light near robot and in \"Room 405\"'": "lights/roomlights405",
    "homebot do 'light in \"Room 165\"' on": "philips165 in home425: confirmed",
    'homebot do \'light in "Room 165" or light in "Room 405"\' off': "2 of 2",
    "homebot do '\"Far lamps\"' on": "philips165 in home425: confirmed",
    "homebot do 'lights with group=\"Both lamps\"' on": "2 of 2",
    "homebot do 'scene \"Far off\"' on": "succeeded",
    "homebot scene show '\"Far off\"'": "philips165: off",
    "homebot routine new far.toml": "added Far away",
    "homebot routine show 'Far away'": "robot go to",
    "homebot achieve '\"Room 405\" lit' --dry-run": "turn on roomlights405",
    'homebot achieve \'scene "Far off", light in "Room 165" on\' --dry-run': "not all at once",
    'homebot achieve \'"Far lamps" on, robot in "Room 165"\' --dry-run': "robot drives to Room 165",
}


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    folder = tmp_path_factory.mktemp("home")
    (folder / "homebot.toml").write_text(CONFIG)
    (folder / "far.toml").write_text(ROUTINE)
    until = ("roomlights405 on mqtt", "philips165 on mqtt", "the robot is in Room 405")
    with homebot_in(folder, "--house", "thesis", until=until) as homebot:
        yield homebot


def test_a_name_in_quotation_marks_is_read(home: Homebot) -> None:
    """A simulated house has its rooms with ``[[groups]]`` too. Queries, triggers, conditions and policies have them."""
    for command, answer in COMMANDS.items():
        done = home.run(command)
        assert answer in done.stdout + done.stderr, command
        for wrong in ("no device", "there is no", "nothing in the house"):
            assert wrong not in done.stdout + done.stderr, command


def test_a_person_in_quotation_marks_is_the_person() -> None:
    quoted, plain = read_trigger('"Anna Maria" arrives'), read_trigger("Anna Maria arrives")
    assert isinstance(quoted, PersonMoves)
    assert isinstance(plain, PersonMoves)
    assert replace(quoted, text=plain.text, query=plain.query) == plain
    assert {*leaves(plain.query)} < {*leaves(quoted.query)}  # or of somebody whose name has the marks


@pytest.mark.parametrize("house", ["family", "thesis"])
def test_a_line_of_a_fresh_log_has_fewer_than_500_letters(tmp_path: Path, house: str) -> None:
    done = run(f"homebot run --house {house} --for 20", cwd=tmp_path)
    lines = done.stderr.splitlines()
    assert done.returncode == 0
    assert len(lines) > 5
    assert [line for line in lines if len(line) >= 500] == []
