"""Turns the roles of docstrings, such as ``:class:`Light` ``, into cross references of the site.

A name that the reference describes becomes a link, one that only the code has is shown as code. One that does not exist
stays a cross reference, and fails the strict build.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from griffe import (
    Alias,
    AliasResolutionError,
    Attribute,
    Class,
    ExprName,
    Extension,
    Function,
    GriffeLoader,
    Module,
    Object,
)

_ROLE = re.compile(r":(?:class|meth|func|data|mod|attr|exc|obj):`~?([^`]+)`")
_ENTRY = re.compile(r"^::: (\S+)$", re.MULTILINE)
_REFERENCE = Path(__file__).parent.parent / "reference"


class Roles(Extension):
    """Rewrites the docstrings of a package once it is loaded."""

    def on_package(self, *, pkg: Module, loader: GriffeLoader, **_: Any) -> None:
        """Rewrite the docstrings of *pkg* and all below."""
        loader.resolve_aliases(external=False)
        shown = {
            _canonical(pkg, entry) for page in _REFERENCE.glob("**/*.md") for entry in _ENTRY.findall(page.read_text())
        }
        self._rewrite(pkg, pkg, shown)

    def _rewrite(self, scope: Object, package: Module, shown: set[str]) -> None:
        if scope.docstring is not None:
            scope.docstring.value = _ROLE.sub(
                lambda match: _reference(match[1], scope, package, shown), scope.docstring.value
            )
        if isinstance(scope, Class):
            _annotate(scope)
        for member in scope.members.values():
            if not isinstance(member, Alias):
                self._rewrite(member, package, shown)


def _annotate(scope: Class) -> None:
    """Give an attribute the type of the argument that it is, so that the table of attributes shows it."""
    start = scope.members.get("__init__")
    if not isinstance(start, Function):
        return
    for member in scope.members.values():
        value = member.value if isinstance(member, Attribute) and member.annotation is None else None
        if isinstance(value, ExprName) and value.name in start.parameters:
            member.annotation = start.parameters[value.name].annotation


def _reference(name: str, scope: Object, package: Module, shown: set[str]) -> str:
    target = _found(name, scope, package)
    if target is None:
        return f"[`{name}`][{name}]"
    if target.is_attribute and not target.has_docstring and target.parent is not None:
        target = target.parent  # one that only the table of its class describes
    path = target.canonical_path
    is_shown = any(path == entry or path.startswith(f"{entry}.") for entry in shown)
    is_public = not any(part.startswith("_") for part in path.split("."))
    return f"[`{name}`][{path}]" if is_shown and is_public else f"`{name}`"


def _found(name: str, scope: Object, package: Module) -> Object | Alias | None:
    first, _, rest = name.partition(".")
    if first == package.name:
        return _member(package, rest) if rest else package
    place: Object | None = scope
    while place is not None:
        if (target := _member(place, name)) is not None:
            return target
        place = place.parent if isinstance(place.parent, Object) else None
    return None


def _member(place: Object | Alias, path: str) -> Object | Alias | None:
    target: Object | Alias = place
    for name in path.split("."):
        try:
            members = target.all_members
        except AliasResolutionError:
            return None
        if name not in members:
            return None
        target = members[name]
    return target


def _canonical(package: Module, entry: str) -> str:
    target = _found(entry, package, package)
    return entry if target is None else target.canonical_path
