"""Any templates with any values: a text, or a TemplateError."""

from __future__ import annotations

import random
from contextlib import suppress

from tests.fuzz.conftest import Fuzz, Mutator, rows_of

from homebot.conventions.jinja import TemplateError, compile_template
from homebot.conventions.jinja.functions import FILTERS, FUNCTIONS
from homebot.conventions.jinja.lists import CHECKS

PIECES = (
    "{{ ",
    " }}",
    "{% ",
    " %}",
    "-",
    "if ",
    "else ",
    "elif ",
    "endif ",
    "for ",
    "in ",
    "endfor ",
    "set ",
    "value_json",
    "value",
    ".",
    "|",
    "[",
    "]",
    "(",
    ")",
    "{",
    "}",
    ":",
    ",",
    "'",
    "+",
    "*",
    "**",
    "/",
    "%",
    "~",
    "==",
    "<",
    "is ",
    "not ",
    "and ",
    "a",
    "1",
    "2.5",
    "9" * 30,
    "none ",
    "loop.index",
    "range(3)",
    "\n",
    "\\",
    "\ud800",
    "é",
    "1e9",
    "_",
    "*a",
    *(f"| {name}" for name in FILTERS),
    *(f"is {name} " for name in CHECKS),
    *(f"{name}(" for name in FUNCTIONS),
)


def sources() -> list[str]:
    """The templates of real announcements."""
    texts = [text for row in rows_of("homeassistant") for _, text in row["messages"]]
    return sorted({text.split('"')[1] for line in texts for text in line.split("template") if text.count('"') > 1})


def test_any_template_gives_a_text_or_says_why_not(fuzz: Fuzz) -> None:
    real = [one for one in sources() if "{" in one] or ["{{ value_json.a | float(0) * 2 }}"]

    def case(rng: random.Random) -> None:
        mutate = Mutator(rng)
        if rng.random() < 0.5:
            source = "".join(rng.choice(PIECES) for _ in range(rng.randrange(1, 25)))
        else:
            source = mutate.damaged_text(rng.choice(real))
        variables = {name: mutate.value() for name in ("value_json", "value", "a", "b")}
        with suppress(TemplateError):
            assert isinstance(compile_template(source).render(variables), str)
        with suppress(TemplateError):
            assert isinstance(compile_template(source).render_value(mutate.word()), str)

    fuzz.run("templates", case)
