"""Modules import each other one way, inside their packages, inside functions and for type checkers too."""

import pytest
from tests.import_graph import import_graph

pytestmark = pytest.mark.no_cover

PARTS = {
    ("homebot.devices.handles.handle_query", "homebot.devices.handles.handle"),
    ("homebot.graph.graph", "homebot.graph.node"),
    ("homebot.testing.day", "homebot.testing.day_live"),
    ("homebot.testing.house", "homebot.testing.event_log"),
}
"""Objects and parts that name each other; this import is for type checkers, or in the function that needs it."""


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
    parts = {module: {part} for module, part in PARTS}
    graph = {module: set(imported) - parts.get(module, set()) for module, imported in import_graph().items()}
    assert in_circles(graph) == set()


def test_a_circle_is_found() -> None:
    assert in_circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == {"a", "b", "c"}
