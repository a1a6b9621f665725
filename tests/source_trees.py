"""The code of homebot as trees of its syntax, parsed once."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import homebot

__all__ = ["SOURCE", "source_nodes", "source_trees"]

SOURCE = Path(homebot.__file__).parent


@cache
def source_trees() -> dict[str, ast.Module]:
    """Return the tree of every file, by its path below ``src/homebot``."""
    return {
        file.relative_to(SOURCE).as_posix(): ast.parse(file.read_text(encoding="utf-8"))
        for file in sorted(SOURCE.rglob("*.py"))
    }


@cache
def source_nodes() -> list[tuple[str, ast.AST]]:
    """Return every module, class and function, each with the path of its file."""
    documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    return [
        (path, node) for path, tree in source_trees().items() for node in ast.walk(tree) if isinstance(node, documented)
    ]
