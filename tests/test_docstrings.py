"""A docstring begins with what something is or does, not with a question."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import homebot

SOURCE = Path(homebot.__file__).parent
RIDDLE = re.compile(r"(What|Who|Whoever|Whom|Whose|Which|Whether|How|Where|When|Why|Whatever)\b")

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def documented() -> list[tuple[str, str]]:
    """The place of each docstring, and its text."""
    return [
        (f"{file.relative_to(SOURCE)}:{getattr(node, 'lineno', 1)}", text)
        for file in sorted(SOURCE.rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, Documented) and (text := ast.get_docstring(node))
    ]


def test_no_docstring_begins_with_a_question_word() -> None:
    found = documented()
    assert len(found) > 3000
    assert [place for place, text in found if RIDDLE.match(text)] == []


def test_the_first_paragraph_of_every_docstring_is_a_sentence_or_ends_in_a_colon() -> None:
    assert [place for place, text in documented() if text.partition("\n\n")[0][-1] not in ".:?!"] == []
