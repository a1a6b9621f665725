"""Plug-ins: classes found by entry-point name, or written out as ``module:Class``."""

from __future__ import annotations

import importlib
import sys
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from homebot.errors import PluginError

__all__ = ["load_plugin", "plugin_names"]


@lru_cache(maxsize=64)
def _entry_points(group: str) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=group))


def plugin_names(group: str) -> tuple[str, ...]:
    """Return the names that the entry-point group *group* offers, sorted."""
    return tuple(sorted({point.name for point in _entry_points(group)}))


def load_plugin(group: str, name: str) -> type[Any]:
    """Return the class that *name* means.

    Args:
        group: The entry-point group, for example ``homebot.apps``.
        name: A name in that group, or ``module:Class``; such a module is also looked for in the working directory.

    Raises:
        PluginError: There is no such plug-in, importing it fails, or it is no class.
    """
    found = _load_class(name) if ":" in name else _load_entry_point(group, name)
    if not isinstance(found, type):
        raise PluginError(name, f"is {found!r}, not a class")
    return found


def _load_entry_point(group: str, name: str) -> object:
    for point in _entry_points(group):
        if point.name == name:
            try:
                return point.load()
            except Exception as exc:
                raise PluginError(name, f"cannot be loaded: {_in_words(exc)}") from exc
    known = ", ".join(plugin_names(group)) or "none"
    raise PluginError(name, f"is not installed (installed: {known}); a class of your own is written module:Class")


def _load_class(path: str) -> object:
    module_name, _, class_name = path.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(module_name)
    except Exception as exc:
        raise PluginError(path, f"the module {module_name!r} cannot be imported: {_in_words(exc)}") from exc
    try:
        return getattr(module, class_name)
    except AttributeError:
        raise PluginError(path, f"the module {module_name!r} has no {class_name!r}") from None


def _in_words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
