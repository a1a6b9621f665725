"""Mistakes in the texts of routines are told in the language of the text, or of the house."""

import json
from pathlib import Path

import pytest

from homebot.errors import UsageError
from homebot.words import mistakes, own_language
from homebot.words.mistakes import COLUMNS, mistake_in
from homebot.words.steps import read_step

TABLE: dict[str, list[str]] = json.loads(
    (Path(mistakes.__file__).parent / "languages" / "mistakes.json").read_text("utf-8")
)


def test_the_columns_are_the_languages_of_texts() -> None:
    assert sorted(COLUMNS) == sorted(own_language.OWN_LANGUAGES)


@pytest.mark.parametrize("english", TABLE)
def test_a_row_has_five_translations_with_the_same_fields(english: str) -> None:
    fields = sorted(mistakes.FIELD.findall(english))
    assert [sorted(mistakes.FIELD.findall(own)) for own in TABLE[english]] == [fields] * len(COLUMNS)


def test_an_english_text_is_answered_as_the_house_speaks() -> None:
    with pytest.raises(UsageError) as caught:
        read_step("hall lamp onn")
    said = mistake_in("de", f"the text:4: routines.test.do.0: {caught.value}")
    assert said == (
        "the text:4: routines.test.do.0: 'hall lamp onn' ist kein Schritt: es endet nicht mit einem Befehl; "
        "meintest du on?"
    )
