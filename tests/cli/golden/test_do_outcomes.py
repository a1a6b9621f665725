"""What ``homebot do`` prints of each outcome, letter by letter, and its exit code; see test_golden.py."""

import pytest
from tests.cli.conftest import Homebot
from tests.cli.golden.test_golden import check
from tests.cli.test_do import Service, answer
from tests.devices.test_outcomes import EXAMPLES

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

Text = pytest.CaptureFixture[str]

CASES: tuple[tuple[Outcome, str, int], ...] = (
    (Confirmed(0.412, Evidence.REPORTED, command_id="a-1"), "confirmed after 0.41 s (reported)", 0),
    (AlreadySo(command_id="a-2"), "it was so already", 0),
    (Contradicted("on_off: on", command_id="a-3"), "contradicted: on_off: on", 1),
    (Reverted(6.0, command_id="a-4"), "changed back after 6 s, by hand or by itself", 1),
    (NoAnswer(9.0, command_id="a-5"), "no answer within 9 s", 1),
    (Superseded("a-9", command_id="a-6"), "superseded by command a-9{names_issuer}", 1),
    (
        Refused("presence_guard", "somebody is in the hall", command_id="a-7"),
        "refused (presence_guard): somebody is in the hall",
        1,
    ),
    (Gone(command_id="a-8"), "the device was removed", 1),
    (Reverted(6.0, "person", command_id="a-4"), "changed back after 6 s, by hand", 1),
)
"""Outcomes, their words, and the exit code."""

CONFIRMED, ALREADY_SO, REFUSED = CASES[0][0], CASES[1][0], CASES[6][0]
HELD = Refused("lease", "held open by robot for 8 s more", command_id="a-10")
WITNESSED = Confirmed(1.5, Evidence.WITNESSED, "Hall lux", command_id="a-11")
UNSENT = NoAnswer(0.0, "the gateway mqtt has no connection", command_id="a-12")


@pytest.mark.parametrize(("outcome", "text", "code"), CASES, ids=[one.kind for one, _, _ in CASES])
def test_each_outcome_in_words_and_as_an_exit_code(
    homebot: Homebot, capsys: Text, outcome: Outcome, text: str, code: int
) -> None:
    """Nothing but a device that is as it was told to be is a success."""
    assert Service(homebot, answer(outcome)).run("Lamp 0", "off") == code
    assert capsys.readouterr() == (f"Lamp 0 in Café: {with_remedy(text, 0)}\n", "")


def with_remedy(text: str, number: int) -> str:
    return text.format(names_issuer=f"; `homebot why 'Lamp {number}'` names its issuer")


@pytest.mark.parametrize("outcome", EXAMPLES, ids=[one.kind for one in EXAMPLES])
def test_an_outcome_is_printed_as_its_class_says(homebot: Homebot, capsys: Text, outcome: Outcome) -> None:
    """Also one that has no row above."""
    assert Service(homebot, answer(outcome)).run("Lamp 0", "off") == (0 if outcome.succeeded else 1)
    printed = capsys.readouterr()
    assert printed.out.startswith(f"Lamp 0 in Café: {outcome.text}")
    assert printed.err == ""


def test_a_command_to_devices_with_each_outcome_ends_with_the_worst(homebot: Homebot, capsys: Text) -> None:
    assert Service(homebot, answer(*(one for one, _, _ in CASES))).run("lamp", "off") == 1
    lines = [f"Lamp {number}: {with_remedy(text, number)}" for number, (_, text, _) in enumerate(CASES)]
    done = sum(not code for _, _, code in CASES)
    lines.append(f"{done} of {len(CASES)} in Café succeeded; worst outcome: gone")
    assert capsys.readouterr().out.splitlines() == lines


@pytest.mark.parametrize(
    ("name", "outcomes", "code"),
    [
        ("do_others", (HELD, WITNESSED, UNSENT), 1),
        ("do_obeyed", (ALREADY_SO, CONFIRMED, WITNESSED), 0),
    ],
)
def test_several_devices_end_with_the_worst_outcome(
    homebot: Homebot, capsys: Text, name: str, outcomes: tuple[Outcome, ...], code: int
) -> None:
    assert Service(homebot, answer(*outcomes)).run("lamp", "off") == code
    check(name, capsys.readouterr().out)


def test_json_has_the_fields_of_the_answer(homebot: Homebot, capsys: Text) -> None:
    assert Service(homebot, answer(CONFIRMED, REFUSED)).run("lamp", "off", "--json") == 1
    check("do_json", capsys.readouterr().out)


def test_json_says_why_nothing_was_commanded(homebot: Homebot, capsys: Text) -> None:
    service = Service(homebot, answer(message="no device fits 'lmap'; `homebot find` shows what does"))
    assert service.run("lmap", "off", "--json") == 1
    check("do_json_nothing", capsys.readouterr().out)
