"""The code of homebot as text and as trees of its syntax, each read once."""

import ast
import gc
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import homebot
from homebot.cli.main import gc_paused

SOURCE = Path(homebot.__file__).parent

Definition = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


@cache
def source_texts() -> dict[str, str]:
    """Return the text of every file, by its path below ``src/homebot``."""
    return {
        file.relative_to(SOURCE).as_posix(): file.read_text(encoding="utf-8") for file in sorted(SOURCE.rglob("*.py"))
    }


@cache
def source_tree(path: str) -> ast.Module:
    """Return the tree of one file; all of them are a million nodes."""
    return ast.parse(source_texts()[path])


@cache
def source_trees() -> dict[str, ast.Module]:
    """Return the tree of every file, by its path below ``src/homebot``."""
    gc.collect()  # what is garbage now may have something to warn of
    with gc_paused():
        return {path: source_tree(path) for path in source_texts()}


@cache
def source_nodes() -> list[tuple[str, Definition]]:
    """Return every module, class and function, each with the path of its file."""
    return [(path, node) for path, tree in source_trees().items() for node in definitions(tree)]


def definitions(node: ast.AST) -> Iterator[Definition]:
    """Yield *node* and what is defined in it, at any depth; expressions, which define nothing, are not looked into."""
    if isinstance(node, Definition):
        yield node
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        for child in getattr(node, field, ()):
            yield from definitions(child)
