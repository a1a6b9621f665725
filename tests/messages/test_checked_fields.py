"""Messages that are made unchecked are given all their fields: one that is left out has no default, it is missing."""

from __future__ import annotations

import ast

from tests.source_trees import source_trees


def test_every_message_of_checked_values_is_given_all_its_fields() -> None:
    nodes = [(path, node) for path, tree in source_trees().items() for node in ast.walk(tree)]
    fields = {node.name: _fields(node) for _, node in nodes if isinstance(node, ast.ClassDef)}
    made = [(path, node) for path, node in nodes if isinstance(node, ast.Call) and _made(node) in fields]
    known = [(path, node) for path, node in made if all(one.arg is not None for one in node.keywords)]

    assert len(known) > 20
    assert [
        (path, node.lineno, _made(node))
        for path, node in known
        if {one.arg for one in node.keywords} != fields[_made(node)]
    ] == []


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
