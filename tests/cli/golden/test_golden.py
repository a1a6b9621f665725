"""What the commands about devices print, letter by letter.

The expected texts lie beside this file; to write them anew, run with ``HOMEBOT_WRITE_GOLDEN=1`` and read what changed.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from homebot.cli import main

if TYPE_CHECKING:
    from tests.cli.conftest import Homebot
    from tests.cli.golden.conftest import StillHouse

HERE = Path(__file__).parent
Text = pytest.CaptureFixture[str]


def check(name: str, printed: str) -> None:
    file = HERE / f"{name}.txt"
    if os.environ.get("HOMEBOT_WRITE_GOLDEN"):
        file.write_text(printed)
    assert printed == file.read_text()


@pytest.mark.parametrize(
    ("name", "arguments", "code"),
    [
        ("devices", ["devices"], 0),
        ("devices_json", ["devices", "--json"], 0),
        ("find", ["find", "light", "and", "dimmable", "in", "kitchen"], 0),
        ("find_why", ["find", "--why", "in attic or light"], 0),
        ("find_limited", ["find", "--limit", "1", "not stale"], 0),
        ("find_nothing", ["find", "robot"], 1),
        ("show", ["show", "kitchen-lamp"], 0),
        ("show_by_name", ["show", "ATTIC"], 0),
        ("show_without_parts", ["show", "windows/bath"], 0),
        ("doctor", ["doctor"], 1),
        ("doctor_counts", ["doctor", "--counts"], 1),
    ],
)
def test_commands_print_what_they_should(
    still_homebot: Homebot, capsys: Text, name: str, arguments: list[str], code: int
) -> None:
    assert main(["--door", still_homebot.door, *arguments]) == code
    out, err = capsys.readouterr()
    assert err == ""
    check(name, out)


def test_where_nothing_is_wrong_the_doctor_says_so(still: StillHouse, still_homebot: Homebot, capsys: Text) -> None:
    still.is_well = True
    assert main(["--door", still_homebot.door, "doctor"]) == 0
    check("doctor_all_well", capsys.readouterr().out)


def test_results_are_json_on_request(still_homebot: Homebot, capsys: Text) -> None:
    assert main(["--door", still_homebot.door, "find", "--json", "light"]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["id"], found["reasons"][0], found["states"][0]["value"]) == ("kitchen-lamp", "it is number 1", True)
    assert main(["--door", still_homebot.door, "show", "--json", "attic"]) == 0
    assert json.loads(capsys.readouterr().out)["reachable"]["why"] == "its last will says offline"


def test_a_query_that_is_not_understood_is_explained(still_homebot: Homebot, capsys: Text) -> None:
    assert main(["--door", still_homebot.door, "find", "level >"]) == 1
    assert capsys.readouterr().err.startswith("homebot: ")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("Kitchn lamp", "homebot: there is no device Kitchn lamp; did you mean Kitchen lamp"),
        ("zzzzzz", "homebot: there is no device zzzzzz; `homebot devices` shows what there is\n"),
    ],
)
def test_an_unknown_device_is_told_with_similar_ones(
    still_homebot: Homebot, capsys: Text, name: str, problem: str
) -> None:
    assert main(["--door", still_homebot.door, "show", name]) == 1
    assert capsys.readouterr().err.startswith(problem)


def test_forget_deletes_nothing_from_the_broker_unless_asked_to(
    still: StillHouse, still_homebot: Homebot, capsys: Text
) -> None:
    assert main(["--door", still_homebot.door, "forget", "kitchen lamp"]) == 0
    check("forget", capsys.readouterr().out)
    assert (still.forgotten, still.published) == (["kitchen-lamp"], [])


def test_forget_with_purge_empties_the_announcements(still: StillHouse, still_homebot: Homebot, capsys: Text) -> None:
    assert main(["--door", still_homebot.door, "forget", "kitchen-lamp", "--purge"]) == 0
    check("forget_purge", capsys.readouterr().out)
    assert still.published == [("homeassistant/light/0x00158d0001abcdef/light/config", "", True)]


def test_forget_that_fails_says_why(still_homebot: Homebot, capsys: Text) -> None:
    assert main(["--door", still_homebot.door, "forget", "attic"]) == 1
    assert capsys.readouterr().err == "homebot: it went a moment ago\n"


def test_purge_does_nothing_by_halves(still: StillHouse, homebot_with: object, capsys: Text) -> None:
    """A gateway that only observes deletes nothing, so nothing is forgotten either."""
    assert callable(homebot_with)
    still.acts = False
    homebot: Homebot = homebot_with(still.node, None)
    assert main(["--door", homebot.door, "forget", "kitchen-lamp", "--purge"]) == 1
    assert "publishing through mqtt was refused: the gateway only observes" in capsys.readouterr().err
    assert (still.forgotten, still.published) == ([], [])
