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
    assert "1 of 2 automations are carried over, 0 with a note; 1 refused; look at each" in err
    assert "\x1b" not in out + err


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("- {alias: A, use_blueprint: {path: a.yaml}}", "A: the blueprint 'a.yaml': give its file"),
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


def test_a_blueprint_and_values_of_other_files_are_read_from_beside_the_file(
    homebot: Homebot, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "secrets.yaml").write_text("hour: '13:00'\n")
    (tmp_path / "words.yaml").write_text("{message: Lunch}\n")
    (tmp_path / "blueprint.yaml").write_text(
        "blueprint: {input: {time: {}, words: {default: Tea}}}\n"
        "trigger: {platform: time, at: !input time}\n"
        "action: {service: notify.notify, data: {message: !input words}}\n"
    )
    (tmp_path / "outside.yaml").write_text("at: '14:00'\n")
    text = """
- {alias: A, trigger: {platform: time, at: !secret hour}, action: {service: notify.notify, data: !include words.yaml}}
- {alias: B, use_blueprint: {path: mine/tea.yaml, input: {time: '16:00'}}}
- {alias: C, trigger: !include ../outside.yaml, action: {service: notify.notify, data: {message: Lunch}}}
"""
    path = tmp_path / "house" / "automations.yaml"
    path.parent.mkdir()
    for name in ("secrets.yaml", "words.yaml"):
        (tmp_path / name).rename(path.parent / name)
    path.write_text(text)
    blueprint = str(tmp_path / "blueprint.yaml")
    assert main(["--door", homebot.door, "routine", "import", str(path), "--blueprint", blueprint]) == 0
    out, err = capsys.readouterr()
    assert 'name = "A"\nwhen = ["13:00"]\ndo = ["notify Lunch"]' in out
    assert 'name = "B"\nwhen = ["16:00"]\ndo = ["notify Tea"]' in out
    assert "line 4, C" in err
    assert "2 of 3 automations" in err
