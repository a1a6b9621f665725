"""Messages that are made unchecked are given all their fields: one that is left out has no default, it is missing."""

from __future__ import annotations

import ast
import re

from tests.source_trees import definitions, source_texts, source_tree


def test_every_message_of_checked_values_is_given_all_its_fields() -> None:
    made = [
        (path, node)
        for path, text in source_texts().items()
        if ".of_checked(" in text
        for node in ast.walk(source_tree(path))
        if isinstance(node, ast.Call) and _made(node)
    ]
    fields = _fields_of({_made(node) for _, node in made})
    known = [
        (path, node)
        for path, node in made
        if _made(node) in fields and all(one.arg is not None for one in node.keywords)
    ]

    assert len(known) > 20
    assert [
        (path, node.lineno, _made(node))
        for path, node in known
        if {one.arg for one in node.keywords} != fields[_made(node)]
    ] == []


def _fields_of(names: set[str]) -> dict[str, set[str | None]]:
    """Return the fields of each class of *names* that homebot has."""
    is_defined = re.compile(rf"^class ({'|'.join(names)})\b", re.MULTILINE)
    return {
        node.name: _fields(node)
        for path, text in source_texts().items()
        if is_defined.search(text)
        for node in definitions(source_tree(path))
        if isinstance(node, ast.ClassDef) and node.name in names
    }


def _fields(node: ast.ClassDef) -> set[str | None]:
    return {
        one.target.id
        for one in node.body
        if isinstance(one, ast.AnnAssign)
        and isinstance(one.target, ast.Name)
        and "ClassVar" not in ast.unparse(one.annotation)
    }


def _made(node: ast.Call) -> str:
    """Return the name of the class whose ``of_checked`` is called; empty for every other call."""
    called = node.func
    if isinstance(called, ast.Attribute) and called.attr == "of_checked" and isinstance(called.value, ast.Name):
        return called.value.id
    return ""
