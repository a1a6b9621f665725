"""Modules import each other one way, inside their packages and for type checkers too."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest
from tests.source_trees import source_trees

pytestmark = pytest.mark.no_cover

PARTS = {
    ("homebot.devices.handles.handle_query", "homebot.devices.handles.handle"),
    ("homebot.graph.graph", "homebot.graph.node"),
    ("homebot.testing.day", "homebot.testing.day_live"),
    ("homebot.testing.house", "homebot.testing.event_log"),
}
"""Objects and parts that name each other; this import is for type checkers, or in the function that needs it."""


def imports(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield what a module imports at its top, also for type checkers: perhaps a module, else a name of the second."""
    for child in ast.iter_child_nodes(node):
        match child:
            case ast.Import(names=names):
                yield from ((one.name, "") for one in names)
            case ast.ImportFrom(module=str(module), names=names):
                yield from ((f"{module}.{one.name}", module) for one in names)
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.Lambda():
                pass
            case _:
                yield from imports(child)


def import_graph() -> dict[str, set[str]]:
    """Return the modules that each module imports."""
    trees = {
        f"homebot/{path}".removesuffix(".py").removesuffix("/__init__").replace("/", "."): tree
        for path, tree in source_trees().items()
    }
    return {
        module: {name if name in trees else package for name, package in imports(tree)} & trees.keys() - {module}
        for module, tree in trees.items()
    }


def in_circles(graph: dict[str, set[str]]) -> set[str]:
    """Return the modules that import themselves by way of others."""

    def reached(module: str) -> set[str]:
        found: set[str] = set()
        waiting = [module]
        while waiting:
            further = graph[waiting.pop()] - found
            found |= further
            waiting += further
        return found

    return {module for module in graph if module in reached(module)}


def test_no_module_is_in_a_circle() -> None:
    graph = import_graph()
    for module, part in PARTS:
        graph[module].discard(part)
    assert in_circles(graph) == set()


def test_a_circle_is_found() -> None:
    assert in_circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == {"a", "b", "c"}
