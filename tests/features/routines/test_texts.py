"""Routines are read as ``homebot.words`` reads their texts, in each language."""

from itertools import chain

import pytest
from pydantic import ValidationError
from tests.words.test_conditions import TOGETHER

from homebot.features.routines.gallery import gallery
from homebot.features.routines.program import Branch, program_of, step_text
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.text import read_settings
from homebot.words.own_language import OWN_LANGUAGES, TextKind, to_english


@pytest.mark.parametrize(("texts", "hint"), [(texts, hint) for texts, hint in TOGETHER if hint])
def test_conditions_that_never_hold_together_are_told_wherever_they_stand(texts: list[str], hint: str) -> None:
    with pytest.raises(ValidationError, match=f"never hold together; {hint}"):
        RoutineSettings.model_validate({"name": "A", "when": ["22:00"], "if": texts, "do": ["hall lamp off"]})
    for key in ("if", "while", "until"):
        block = {key: texts, "do": ["wait 1m"]}
        with pytest.raises(ValidationError, match=f"never hold together; {hint}"):
            RoutineSettings.model_validate({"name": "A", "when": ["22:00"], "do": [block]})


def test_no_text_of_a_ready_made_routine_is_taken_for_another_language() -> None:
    texts: list[tuple[TextKind, str]] = []
    for one in gallery().values():
        table = read_settings(one.filled({key: "hall lamp" for key in one.inputs if not one.inputs[key].default}), "it")
        texts += chain((("trigger", text) for text in table.when), (("condition", text) for text in table.conditions))
        texts += (("step", step) for step in table.do if isinstance(step, str))
    assert len(texts) > 80
    assert [text for kind, text in texts if to_english(text, kind) not in {None, text}] == []


@pytest.mark.parametrize(
    ("language", "devices", "step", "shown"),
    [
        ("de", "alle Lampen im Bad", "schalte sie ein", "nacheinander, alle Lampen im Bad: schalte sie ein"),
        (
            "fr",
            "toutes les lampes dans Bad",
            "allume elle",
            "l'un après l'autre, toutes les lampes dans Bad : allume elle",
        ),
        ("it", "tutte le luci in Bad", "accendi questa", "uno dopo l'altro, tutte le luci in Bad: accendi questa"),
        ("es", "todas las luces en Bad", "enciende esta", "uno tras otro, todas las luces en Bad: enciende esta"),
        ("nl", "alle lampen in Bad", "zet deze aan", "een voor een, alle lampen in Bad: zet deze aan"),
    ],
)
def test_a_loop_over_devices_is_read_and_shown_in_each_language(
    language: str, devices: str, step: str, shown: str
) -> None:
    block = {"for_each": devices, "do": [step]}
    routine = RoutineSettings.model_validate({"name": "A", "when": ["7:00"], "do": [block, "undo"]})
    english = {"for_each": "lights in Bad", "do": ["it on"]}
    same = RoutineSettings.model_validate({"name": "A", "when": ["7:00"], "do": [english, "undo"]})
    assert step_text(routine.do[0], language) == shown
    written = RoutineSettings.model_validate({"name": "A", "when": ["7:00"], "do": [shown, "undo"]})
    assert written == routine
    assert [line.step for line in program_of(routine.do)] == [line.step for line in program_of(same.do)]


@pytest.mark.parametrize("language", ["en", *OWN_LANGUAGES])
@pytest.mark.parametrize(
    "block",
    [
        {"if": ["Flur on", "between 22:00 and 6:30"], "do": ["Flur off", "wait 5m"], "else": ["stop"]},
        {"if": ["sun is down"], "do": ["Flur on"]},
        {"repeat": 3, "do": ["Flur toggle", "wait 1m"]},
        {"while": ["Flur on", "nobody is home"], "do": ["wait 1m"]},
        {"until": ["Flur off"], "do": ["wait 1m", "notify 22:00: now"]},
    ],
)
def test_a_choice_or_loop_is_read_as_it_is_shown(block: dict[str, object], language: str) -> None:
    routine = RoutineSettings.model_validate({"name": "A", "when": ["7:00"], "do": [block, "undo"]})
    shown = step_text(routine.do[0], "" if language == "en" else language)
    again = RoutineSettings.model_validate({"name": "A", "when": ["7:00"], "do": [shown, "undo"]})
    assert again.do[0] != shown
    assert meanings(again) == meanings(routine)


@pytest.mark.parametrize(
    ("loop", "english"),
    [
        ("three times: Flur toggle; wait 1m", "3 times: Flur toggle; wait 1m"),
        ("dreimal: schalte Flur um; warte 1 Minute", "3 times: Flur toggle; wait 1m"),
        ("3 Mal: schalte Flur um; warte 1 Minute", "3 times: Flur toggle; wait 1m"),
        ("trois fois : bascule Flur; attends 1 minute", "3 times: Flur toggle; wait 1m"),
        ("repite doce veces: alterna Flur", "12 times: Flur toggle"),
        ("drie keer: wissel Flur; wacht 1 minuut", "3 times: Flur toggle; wait 1m"),
        ("tweemaal: wissel Flur", "2 times: Flur toggle"),
        ("ripeti tre volte: commuta Flur; aspetta 1 minuto", "3 times: Flur toggle; wait 1m"),
        ("finché non Flur è accesa: aspetta 1 minuto", "repeat until Flur on: wait 1m"),
        ("finché Flur non è accesa: aspetta 1 minuto", "repeat while not Flur on: wait 1m"),
        ("bis Flur an ist: warte 1 Minute", "repeat until Flur on: wait 1m"),
    ],
)
def test_a_loop_is_read_as_people_write_it(loop: str, english: str) -> None:
    routines = [
        RoutineSettings.model_validate({"name": "A", "when": ["7:00"], "do": [one, "undo"]}) for one in (loop, english)
    ]
    assert meanings(routines[0]) == meanings(routines[1])


def meanings(routine: RoutineSettings) -> list[object]:
    """Return the program of *routine* without the texts of its conditions."""
    steps = (line.step for line in program_of(routine.do))
    return [[meant for _, meant in step.conditions] if isinstance(step, Branch) else step for step in steps]
