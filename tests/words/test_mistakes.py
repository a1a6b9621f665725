"""Mistakes in the texts of routines are told in the language of the text, or of the house."""

import errno
import json
import os
import re
from collections.abc import Callable, Mapping
from functools import cache, partial
from itertools import chain
from pathlib import Path

import pytest
from tests.call_counts import calls
from tests.web.test_languages import PYTHON
from tests.web.told_messages import mistakes_told_in

from homebot.errors import ConfigError, UsageError
from homebot.support.toml_file import parse_toml
from homebot.words import mistakes
from homebot.words.conditions import read_condition
from homebot.words.mistakes import COLUMNS, FIELD, MistakeTable, mistake_in
from homebot.words.own_language import OWN_LANGUAGES, TextKind, language_of
from homebot.words.phrases import MEANT_STEPS
from homebot.words.steps import read_step
from homebot.words.tokens import MAX_QUERY
from homebot.words.triggers import read_trigger

FOLDER = Path(mistakes.__file__).parent / "languages"
TABLE: dict[str, list[str]] = json.loads((FOLDER / "mistakes.json").read_text("utf-8"))
REASONS: dict[str, list[str]] = json.loads((FOLDER.parents[1] / "web/source/reasons.json").read_text("utf-8"))
MISTAKES: dict[str, list[tuple[TextKind, str, str]]] = json.loads(
    Path(__file__).with_name("mistakes_in_languages.json").read_text("utf-8")
)
"""What people of each language write wrongly, and the answer."""

READERS: Mapping[TextKind, Callable[[str], object]] = {
    "trigger": read_trigger,
    "condition": read_condition,
    "step": read_step,
}
WORDS = (
    *("calculations", "commands", "comparisons", "conditions", "days", "exact_queries", "message_values", "people"),
    *("queries", "steps", "times", "tokens", "triggers", "wishes"),
)
ROUTINES = ("checks", "effects", "program", "settings", "tables", "text")
HOUSE = ("command_words/targets", "discovery/search/unknown_words", "robots/drive", "units")
GOALS = ("achieve_server", "achievement", "house_snapshot", "meanings", "problem_builder")
MODULES = (
    *(f"words/{one}" for one in WORDS),
    *(f"features/routines/{one}" for one in ROUTINES),
    *(f"features/goals/{one}" for one in GOALS),
    *HOUSE,
)
NO_TOML = (
    *(
        "when",
        "when = A",
        'when = "A',
        'when = "A\n"',
        "when = ['A'",
        "when = ['A'] x",
        "a = { b = 1",
        "? = 1",
        "a.? = 1",
        "a = ",
        "\a",
    ),
    *(
        "a = 1\na = 2",
        "[a]\n[a]",
        "[a\n",
        "[[a\n",
        "[a]\nb.c = 1\n[a.b]",
        "a = { b = 1, b = 2 }",
        "a = { b = 1 }\n[a.c]",
    ),
    *(
        "a = [1]\n[[a]]",
        "[a.b]\n[a]\nb.c = 1",
        r'a = "\d"',
        r'a = "\u00x"',
        r'a = "\ud800"',
        "a = 2026-02-31",
        "# \a\n",
    ),
    *("a = 'A", "a = '''A", 'a = """A', "a.b = 1\n[a]\nc = 1", "a = 'A\n'"),
)
"""Texts with each mistake that tomllib knows."""

SENTENCES = ("trigger", "condition", "step", "steps", "wish")
QUOTED = re.compile(r"(?<!\w)'([^{}]+? .+?)'(?!\w)")


def blank(form: str) -> str:
    return " ".join(("•", *(f"{{{one}}}" for one in FIELD.findall(form) if one.rstrip("2") not in SENTENCES)))


BLANK = MistakeTable({form: [blank(form)] * len(COLUMNS) for form in TABLE})
"""The table in which a translation is a sign and the values that are no sentences."""


def english_in(message: str) -> str:
    """Return what of *message* stays English, but values in braces and the keys of routines."""
    said = BLANK.said(message, "de")
    return " ".join(re.findall(r"[a-z]{2,}", re.sub(r"\{[^{}]*\}|\b(?:do|if|when|name)[:=]", "", said)))


@cache
def mistakes_of_toml() -> list[str]:
    def mistake_of(text: str) -> str:
        with pytest.raises(ConfigError) as caught:
            parse_toml(text, "the text")
        return str(caught.value)

    return [mistake_of(text) for text in NO_TOML]


@cache
def told_in(module: str) -> set[str]:
    return mistakes_told_in(f"{module}.py")


def test_the_columns_are_the_languages_of_texts() -> None:
    assert sorted(COLUMNS) == sorted(OWN_LANGUAGES)


@pytest.mark.parametrize("english", TABLE)
def test_a_row_has_five_translations_with_the_same_fields(english: str) -> None:
    fields = {one for one in FIELD.findall(english) if not one.startswith("example")}
    for language, own in zip(COLUMNS, TABLE[english], strict=True):
        values = json.loads((FOLDER / f"{language}.json").read_text("utf-8"))["value"].values()
        examples = {word for value in values for word in value.split(" / ")} if "{example" in english else set()
        assert set(FIELD.findall(own)) - examples == fields, own


def test_a_row_that_the_page_has_too_says_the_same() -> None:
    assert {english: own for english, own in TABLE.items() if REASONS.get(english, own) != own} == {}


@pytest.mark.parametrize("module", MODULES)
def test_each_message_of_the_source_has_a_row(module: str) -> None:
    told = told_in(module)
    assert told, "the module says nothing"
    assert {message: left for message in told if (left := english_in(message) and english_in(f"0 {message}"))} == {}


def test_a_row_is_of_a_message_that_homebot_gives() -> None:
    """Those of pydantic are provoked in ``tests/features/routines/test_mistakes.py``."""
    of_others = (*mistakes_of_toml(), *map(os.strerror, (errno.ENOENT, errno.EACCES)))
    told = "\n".join((*chain.from_iterable(map(told_in, MODULES)), *of_others, PYTHON))
    of_pydantic = [english for english in TABLE if english.startswith("input should") or " should have " in english]
    rows = TABLE.keys() - REASONS.keys() - {*of_pydantic}
    pieces = {one.strip(" ,;:()'%") for english in rows for one in re.split(r"\{\w+\}|; |, got|\bno (?=r|s)", english)}
    assert {one for one in pieces if one not in told} == set()


def test_each_mistake_of_toml_has_a_row() -> None:
    assert [message for message in mistakes_of_toml() if english_in(message)] == []


def test_the_advice_for_known_mistakes_has_rows() -> None:
    assert [one for _, one, _ in MEANT_STEPS if english_in(f"'0': {one} 'x on', 'wait 5m' and 'undo'")] == []


def test_a_message_without_a_row_is_noticed() -> None:
    assert english_in("'x': the moon is full") == "the moon is full"
    assert english_in("'x': the longest wait must be longer than the shortest") == ""


@pytest.mark.parametrize("english", [one for one in TABLE if QUOTED.search(one)])
def test_an_example_is_one_in_each_language(english: str) -> None:
    def reads(text: str) -> list[TextKind]:
        return [kind for kind, read in READERS.items() if is_read(read, text)]

    if not all(map(reads, QUOTED.findall(english))):
        return
    for language, own in zip(COLUMNS, TABLE[english], strict=True):
        for text in QUOTED.findall(own):
            assert reads(text), (language, text)


def is_read(read: Callable[[str], object], text: str) -> bool:
    try:
        read(text)
    except UsageError:
        return False
    return True


def test_most_examples_are_in_the_language() -> None:
    for at, language in enumerate(COLUMNS):
        texts = [text for own in TABLE.values() for text in QUOTED.findall(own[at])]
        assert sum(language_of(text) == language for text in texts) > len(texts) / 2


@pytest.mark.parametrize(
    ("kind", "text", "answer"), [tuple(one) for language in OWN_LANGUAGES for one in MISTAKES[language]]
)
def test_a_mistake_is_answered_in_the_language_of_the_text(kind: TextKind, text: str, answer: str) -> None:
    with pytest.raises(UsageError) as caught:
        READERS[kind](text)
    assert str(caught.value) == answer


def test_an_english_text_is_answered_as_the_house_speaks() -> None:
    with pytest.raises(UsageError) as caught:
        read_step("hall lamp onn")
    said = mistake_in("de", f"the text:4: routines.test.do.0: {caught.value}")
    assert said == (
        "the text:4: routines.test.do.0: 'hall lamp onn' ist kein Schritt: es endet nicht mit einem Befehl; "
        "meintest du on?"
    )


def test_a_hint_is_told_in_the_language_of_the_text_that_it_quotes() -> None:
    hint = "'éteins la lampe': no device fits 'la lampe'; did you mean hall lamp or desk lamp?"
    said = "'éteins la lampe': aucun appareil ne correspond à 'la lampe' ; vouliez-vous dire hall lamp ou desk lamp ?"
    assert mistake_in("de", hint) == said
    assert mistake_in("en", hint) == said


@pytest.mark.parametrize("language", OWN_LANGUAGES)
def test_a_message_that_is_in_a_language_stays_as_it_is(language: str) -> None:
    """Some are told by the reader of a text, and once more where they leave."""
    answers = [answer for rows in MISTAKES.values() for _, _, answer in rows]
    assert [mistake_in(language, answer) for answer in answers] == answers


def test_each_step_of_a_circle_is_told() -> None:
    circle = "it would start itself: 'a on' of A starts B; 'b on' of B starts A"
    assert mistake_in("de", circle) == "sie würde sich selbst starten: 'a on' von A startet B; 'b on' von B startet A"


def test_a_refusal_of_a_step_is_told_with_its_reason() -> None:
    reason = (
        "Door needs a right that names it (it has the tag always_ask), and /a has none; `x --act 'id=\"d\"'` gives one"
    )
    assert mistake_in("nl", f"'öffne Door' is refused: {reason}") == (
        "'öffne Door' wird abgelehnt: Door braucht ein Recht, das es nennt (es trägt das Kennzeichen always_ask), und "
        "/a hat keines; `x --act 'id=\"d\"'` gibt eines"
    )


def test_what_has_no_row_stays_as_it_is() -> None:
    assert mistake_in("it", "Anna: nothing; of the kind") == "Anna: nothing; of the kind"
    assert mistake_in("en", "'x on': a bracket is not closed") == "'x on': a bracket is not closed"
    assert mistake_in("tlh", "a bracket is not closed") == "a bracket is not closed"


@pytest.mark.parametrize("piece", ["'", "' ", "a: ", "a; ", "'a': ", "' and '", " of ", "\\'"])
def test_a_message_costs_as_much_as_it_is_long(piece: str) -> None:
    mistake_in("de", "")
    short, long = (calls(partial(mistake_in, "de", piece * size)) for size in (500, 2000))
    assert long < 5 * short + MAX_QUERY
