"""``homebot routine import`` prints routines to its output, and to the error output all that it leaves out."""

from pathlib import Path

import pytest
from tests.cli.conftest import Homebot

from homebot.cli import main

pytestmark = pytest.mark.rooms("homeassistant")

NOTIFY = """
- alias: "No\\u202eon"
  trigger: {platform: time, at: '12:00'}
  action: {service: notify.notify, data: {message: Lunch}}
- alias: "Lamp\\e[31m"
  trigger: {platform: time, at: '12:00'}
  action: {service: light.turn_on, entity_id: light.lamp}
"""


def imported(homebot: Homebot, tmp_path: Path, text: str) -> int:
    path = tmp_path / "automations.yaml"
    path.write_text(text)
    return main(["--door", homebot.door, "routine", "import", str(path)])


def test_what_is_carried_over_is_printed_apart_from_what_is_not(
    homebot: Homebot, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert imported(homebot, tmp_path, NOTIFY) == 0
    out, err = capsys.readouterr()
    assert out.endswith('[[routines]]\nname = "No\\U0000202eon"\nwhen = ["12:00"]\ndo = ["notify Lunch"]\n')
    assert "line 7, Lamp" in err
    assert "light.lamp is nothing that homebot knows" in err
    assert "1 of 2 automations are carried over; look at each" in err
    assert "\x1b" not in out + err


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("- {alias: A, use_blueprint: {path: a.yaml}}", "A: automation: `use_blueprint` has no counterpart"),
        ("light: []", "has no automations"),
        ("- a: [", "cannot be read: line 1"),
        ("- &a {}\n- *a", "line 1, automation in line 1: it would do nothing"),
        ("- &a [" + ", ".join("x" * 999) + "]\n- &b [" + ", ".join(["*a"] * 999) + "]\n- [*b, *b]", "repeat too much"),
        ("- &a [*a]", "cannot be read"),
        ("#" * 1_000_001, "it has 1,000,001 characters; divide it"),
    ],
)
def test_a_file_of_which_nothing_is_carried_over_is_an_error(
    homebot: Homebot, tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, problem: str
) -> None:
    assert imported(homebot, tmp_path, text) > 0
    out, err = capsys.readouterr()
    assert (out.strip(), problem in err) == ("", True), err


def test_a_button_that_nothing_is_cannot_be_bound(homebot: Homebot, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--door", homebot.door, "bind", "light", "single", "lamp", "toggle"]) > 0
    assert "no button fits 'light'; `homebot find buttons` shows" in capsys.readouterr().err
