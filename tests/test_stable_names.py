"""The list of stable names: each is there, and whoever follows the guides imports no other."""

import ast
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import TypeVar

import pytest

ROOT = Path(__file__).parent.parent
LIST = (ROOT / "docs" / "reference" / "stable.md").read_text("utf-8")
ROWS: dict[str, str] = dict(re.findall(r"^\| `(homebot[\w.]*)` \| (.*?) \|", LIST, re.MULTILINE))
READ = [
    path
    for pattern in (
        "*.md",
        "docs/*.md",
        "docs/reference/*.md",
        "examples/**/*.md",
        "examples/**/*.py",
        "src/homebot/cli/templates/**/*.template",
        "tests/packages/homebot-*/**/*.py",
    )
    for path in ROOT.glob(pattern)
]
"""What people copy from."""

_IMPORT = re.compile(
    r"^ *from (homebot(?:\.[\w.]+)?) import (\([^)]*\)|[^\n#]+)|^ *import (homebot(?:\.[\w.]+)?)\b", re.MULTILINE
)


def public_names(module: str) -> set[str]:
    """The names of ``__all__`` of a package; else those that the module defines, or imports as themselves."""
    home = import_module(module)
    if hasattr(home, "__all__"):
        return set(home.__all__)
    file = home.__file__
    assert file is not None
    found: set[str] = set()
    for node in ast.parse(Path(file).read_text("utf-8")).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)}
        elif isinstance(node, ast.ImportFrom):
            found |= {one.name for one in node.names if one.asname == one.name}
    return {name for name in found if not name.startswith("_") and not isinstance(getattr(home, name), TypeVar)}


def stable_names(module: str) -> set[str]:
    row = ROWS[module]
    return public_names(module) if row == "all" else set(re.findall(r"`(\w+)`", row))


def imported(text: str) -> Iterator[tuple[str, str]]:
    """Yield the module and the name of each import; the name is empty if the whole module is imported."""
    for module, names, whole in _IMPORT.findall(text):
        if whole:
            yield whole, ""
        for name in re.findall(r"(\w+)(?: as \w+)?", names):
            yield module, name


@pytest.mark.parametrize("module", ROWS)
def test_every_stable_name_is_in_its_module(module: str) -> None:
    home, names = import_module(module), stable_names(module)
    assert names
    assert names <= public_names(module)
    assert [name for name in sorted(names) if not hasattr(home, name)] == []


def test_guides_examples_and_new_projects_import_only_stable_names() -> None:
    found = [(path, *one) for path in READ for one in imported(path.read_text("utf-8"))]
    assert len(found) > 100
    other = [
        (str(path.relative_to(ROOT)), module, name)
        for path, module, name in found
        if module not in ROWS or (name and name not in stable_names(module))
    ]
    assert other == []


def test_an_import_is_seen_however_it_is_written() -> None:
    text = "from homebot.a import (\n    B,\n    c as d,\n)\n    from homebot import E  # a comment\nimport homebot.f\n"
    assert list(imported(text)) == [("homebot.a", "B"), ("homebot.a", "c"), ("homebot", "E"), ("homebot.f", "")]
