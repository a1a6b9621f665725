"""What ``homebot do`` prints of each outcome, letter by letter, and its exit code; see test_golden.py."""

from __future__ import annotations

from typing import TYPE_CHECKING, get_args

import pytest
from tests.cli.golden.test_golden import check
from tests.cli.test_do import Service, answer

from homebot.devices.command_messages import CommandResult
from homebot.devices.outcomes import (
    AlreadySo,
    Confirmed,
    Contradicted,
    Evidence,
    Gone,
    NoAnswer,
    Outcome,
    Refused,
    Reverted,
    Superseded,
)

if TYPE_CHECKING:
    from tests.cli.conftest import Homebot

Text = pytest.CaptureFixture[str]

OUTCOMES: dict[str, Outcome] = {
    "confirmed": Confirmed(0.412, Evidence.REPORTED, command_id="a-1"),
    "already_so": AlreadySo(command_id="a-2"),
    "contradicted": Contradicted("on_off: on", command_id="a-3"),
    "reverted": Reverted(6.0, command_id="a-4"),
    "no_answer": NoAnswer(9.0, command_id="a-5"),
    "superseded": Superseded("a-9", command_id="a-6"),
    "refused": Refused("presence_guard", "somebody is in the hall", command_id="a-7"),
    "gone": Gone(command_id="a-8"),
}
HELD = Refused("lease", "held open by robot for 8 s more", command_id="a-10")
WITNESSED = Confirmed(1.5, Evidence.WITNESSED, "Hall lux", command_id="a-11")
UNSENT = NoAnswer(0.0, "the gateway mqtt has no connection", command_id="a-12")


@pytest.mark.parametrize("name", OUTCOMES)
def test_each_outcome_in_words_and_as_an_exit_code(homebot: Homebot, capsys: Text, name: str) -> None:
    """Nothing but a device that is as it was told to be is a success."""
    code = Service(homebot, answer(OUTCOMES[name])).run("Lamp 0", "off")
    assert code == (0 if name in {"confirmed", "already_so"} else 1)
    out, err = capsys.readouterr()
    assert err == ""
    check(f"do_{name}", out)


def test_there_is_one_for_each_outcome() -> None:
    assert set(OUTCOMES) == set(get_args(CommandResult.model_fields["outcome"].annotation))


@pytest.mark.parametrize(
    ("name", "outcomes", "code"),
    [
        ("do_all", tuple(OUTCOMES.values()), 1),
        ("do_others", (HELD, WITNESSED, UNSENT), 1),
        ("do_obeyed", (OUTCOMES["already_so"], OUTCOMES["confirmed"], WITNESSED), 0),
    ],
)
def test_several_devices_end_with_the_worst_outcome(
    homebot: Homebot, capsys: Text, name: str, outcomes: tuple[Outcome, ...], code: int
) -> None:
    assert Service(homebot, answer(*outcomes)).run("lamp", "off") == code
    check(name, capsys.readouterr().out)


def test_json_has_the_fields_of_the_answer(homebot: Homebot, capsys: Text) -> None:
    assert Service(homebot, answer(OUTCOMES["confirmed"], OUTCOMES["refused"])).run("lamp", "off", "--json") == 1
    check("do_json", capsys.readouterr().out)


def test_json_says_why_nothing_was_commanded(homebot: Homebot, capsys: Text) -> None:
    service = Service(homebot, answer(message="no device fits 'lmap'; `homebot find` shows what does"))
    assert service.run("lmap", "off", "--json") == 1
    check("do_json_nothing", capsys.readouterr().out)
