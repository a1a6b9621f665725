"""Messages that are made unchecked are given all their fields: one that is left out has no default, it is missing."""

import ast
import re
from collections.abc import Iterable, Iterator

from tests.source_trees import definitions, source_texts, source_tree


def test_every_message_of_checked_values_is_given_all_its_fields() -> None:
    made = [
        (path, node, name)
        for path, text in source_texts().items()
        if ".of_checked" in text
        for node, name in _made(source_tree(path))
    ]
    fields = _fields_of({name for _, _, name in made})
    known = [
        (path, node, name)
        for path, node, name in made
        if name in fields and all(one.arg is not None for one in node.keywords)
    ]

    assert len(known) >= 15
    assert [
        (path, node.lineno, name) for path, node, name in known if {one.arg for one in node.keywords} != fields[name]
    ] == []


def test_only_the_hot_road_makes_messages_unchecked() -> None:
    """Gateways, the directory and raw delivery; elsewhere the constructor or ``model_copy`` is fast enough."""
    users = [path for path, text in source_texts().items() if re.search(r"\.(of|with)_checked\b", text)]
    assert len(users) <= 8, users


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


def _made(tree: ast.Module) -> Iterator[tuple[ast.Call, str]]:
    """Yield the calls of ``of_checked``, also by a name that a module has for it, each with the name of the class."""
    names = dict(_named(tree))
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        if name := _class_of(node.func):
            yield node, name
        elif isinstance(node.func, ast.Name) and node.func.id in names:
            yield node, names[node.func.id]


def _named(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names that a module has for the ``of_checked`` of a class, each with the name of the class."""
    for node in tree.body:
        if not isinstance(node, ast.Assign):
            continue
        (target,) = node.targets
        pairs: Iterable[tuple[ast.expr, ast.expr]] = [(target, node.value)]
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            pairs = zip(target.elts, node.value.elts, strict=True)
        for name, value in pairs:
            if isinstance(name, ast.Name) and (made := _class_of(value)):
                yield name.id, made


def _class_of(node: ast.expr) -> str:
    """Return the name of the class whose ``of_checked`` is *node*; empty for everything else."""
    if isinstance(node, ast.Attribute) and node.attr == "of_checked" and isinstance(node.value, ast.Name):
        return node.value.id
    return ""
