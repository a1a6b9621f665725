"""The gallery in each language."""

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from homebot.features.routines import gallery as gallery_module
from homebot.features.routines.gallery import GalleryRoutine, gallery, listed
from homebot.words.mistakes import COLUMNS
from homebot.words.own_language import TextKind, reading_of

TEXTS: dict[str, list[str]] = json.loads(
    (Path(gallery_module.__file__).parent / "ready_made/texts.json").read_text("utf-8")
)
KINDS: dict[str, TextKind] = {"when": "trigger", "if": "condition", "while": "condition", "do": "step"}
SAME = re.compile(r"\ball (?=lights)|\bto (?=\d+ [%°])")
"""Words that a text may have, or not."""


def filled(routine: GalleryRoutine, language: str) -> str:
    return routine.filled({key: f"'{key} 1'" for key, one in routine.inputs.items() if one.find}, language)


def texts_in(value: object, key: str = "") -> Iterator[tuple[str, str]]:
    match value:
        case str():
            yield key, value
        case list():
            for one in value:
                yield from texts_in(one, key)
        case dict():
            for inner, one in value.items():
                yield from texts_in(one, inner)


def test_what_no_grammar_reads_has_a_row_and_each_row_is_used() -> None:
    said = {one.about for one in gallery().values()}
    said |= {key.replace("_", " ") for one in gallery().values() for key in one.inputs}
    texts = {(key, text) for one in gallery().values() for key, text in texts_in(one.routine)}
    said |= {text for key, text in texts if key == "name" or text.startswith("notify ")}
    defaults = {own.default for one in gallery().values() for own in one.inputs.values()}
    worded = {text for text in defaults if re.search(r"\d[mh]\b| on |^on ", text)}
    assert TEXTS.keys() == said | worded


def test_a_row_has_each_language_with_the_same_fields() -> None:
    for english, own in TEXTS.items():
        assert [sorted(re.findall(r"<\w+>|{\w+}", one)) for one in own] == [
            sorted(re.findall(r"<\w+>|{\w+}", english))
        ] * len(COLUMNS), english


def test_the_gallery_is_listed_in_the_language() -> None:
    light = next(one for one in listed("de") if one.name == "night_light")
    assert light.about == "Ein schwaches Licht für den Weg in der Nacht."
    assert [one.label for one in light.inputs] == ["Bewegungsmelder", "Lampe", "beginnt um", "endet um", "Helligkeit"]
    assert [one.key for one in light.inputs] == ["motion", "lamp", "begins", "ends", "brightness"]


@pytest.mark.parametrize("language", COLUMNS)
def test_a_ready_made_routine_is_written_in_each_language_and_means_the_same(language: str) -> None:
    for name, one in gallery().items():
        own, english = ([*texts_in(tomllib.loads(filled(one, said)))] for said in (language, ""))
        for (key, text), (_, meant) in zip(own, english, strict=True):
            if (kind := KINDS.get(key)) is None:
                continue
            read = reading_of(text, kind)
            assert read[0] == language, (name, text)
            assert meant.startswith("notify ") or read[1] == SAME.sub("", meant), (name, text)


def test_what_a_person_says_may_be_in_the_language_too() -> None:
    routine = gallery()["garage_left_open"]
    text = routine.filled({"garage": "Garagentor", "after": "20 Minuten"}, "de")
    assert 'when = ["Garagentor ist seit 20 Minuten offen"]' in text
