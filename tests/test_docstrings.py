"""A docstring begins with what something is or does, not with a question."""

import ast
import re

import pytest
from tests.source_trees import source_nodes, source_texts

pytestmark = pytest.mark.no_cover

RIDDLE = re.compile(r"(What|Who|Whoever|Whom|Whose|Which|Whether|How|Where|When|Why|Whatever)\b")


def documented() -> list[tuple[str, str]]:
    """The place of each docstring, and its text."""
    return [
        (f"{path}:{getattr(node, 'lineno', 1)}", text)
        for path, node in source_nodes()
        if (text := ast.get_docstring(node))
    ]


def test_no_docstring_begins_with_a_question_word() -> None:
    found = documented()
    assert len(found) > 3000
    assert [place for place, text in found if RIDDLE.match(text)] == []


PRONOUN = re.compile(r"\b(who|whom|whose|whoever|what|whatever|nobody|somebody|anybody)\b", re.IGNORECASE)


@pytest.mark.rooms("homeassistant")
def test_docstrings_and_comments_name_things_and_not_whatever_they_are() -> None:
    """At most two question words and indefinite pronouns in 1,000 words."""
    comments = [line.partition("# ")[2] for text in source_texts().values() for line in text.splitlines()]
    prose = [*(text for _, text in documented()), *comments]
    words = sum(len(text.split()) for text in prose)
    assert 1000 * sum(len(PRONOUN.findall(text)) for text in prose) / words <= 2


def test_the_first_paragraph_of_every_docstring_is_a_sentence_or_ends_in_a_colon() -> None:
    assert [place for place, text in documented() if text.partition("\n\n")[0][-1] not in ".:?!"] == []


def entries(text: str, section: str) -> list[str]:
    """The names that a section of a docstring explains."""
    lines = text.partition(f"\n{section}:\n")[2].partition("\n\n")[0].splitlines()
    found = [re.match(r"    \*{0,2}(\w+(?:, \w+)*): ", line) for line in lines]
    return [name for match in found if match for name in match[1].split(", ")]


def arguments(function: ast.FunctionDef | ast.AsyncFunctionDef) -> set[str]:
    every = function.args
    more = [one for one in (every.vararg, every.kwarg) if one is not None]
    return {one.arg for one in (*every.posonlyargs, *every.args, *every.kwonlyargs, *more)}


def members(class_: ast.ClassDef) -> set[str]:
    """The names that a class defines or sets."""
    found = {node.attr for node in ast.walk(class_) if isinstance(node, ast.Attribute)}
    for node in class_.body:
        match node:
            case ast.AnnAssign(target=ast.Name(id=name)) | ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                found.add(name)
            case ast.Assign(targets=targets):
                found |= {target.id for target in targets if isinstance(target, ast.Name)}
            case _:
                pass
    return found


def unknown_entries(node: ast.AST) -> list[str]:
    """The names in the docstring of a class or function that it does not have."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return sorted({*entries(ast.get_docstring(node) or "", "Args")} - arguments(node))
    if not isinstance(node, ast.ClassDef):
        return []
    text = ast.get_docstring(node) or ""
    attributes, taken = {*entries(text, "Attributes")}, {*entries(text, "Args")}
    if not attributes and not taken:
        return []
    known = members(node)
    inits = [one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"]
    return sorted((attributes - known) | (taken - (arguments(inits[0]) if inits else known)))


def test_the_arguments_and_attributes_that_a_docstring_explains_are_there() -> None:
    found = [
        (path, getattr(node, "name", ""), names) for path, node in source_nodes() if (names := unknown_entries(node))
    ]
    assert found == []


def test_an_entry_that_nothing_bears_is_found() -> None:
    text = "A lamp.\n\n    Attributes:\n        level: In percent.\n        word: No.\n    "
    code = f'class Lamp:\n    """{text}"""\n    level = 0\n'
    assert unknown_entries(ast.parse(code).body[0]) == ["word"]
