"""Apps of a replay: those of the recording, or others in their place."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Final

from homebot.apps import App
from homebot.config import Table
from homebot.errors import PluginError, UsageError
from homebot.file_access import why_not_trusted
from homebot.plugins import load_plugin
from homebot.recording.lines import RecordedApp

__all__ = ["app_tables"]

_APPS: Final = "homebot.apps"
_FILE: Final = re.compile(r"(?P<file>.+\.py)(?::(?P<kind>\w+))?")


def app_tables(recorded: Iterable[RecordedApp], wanted: Sequence[str], given: dict[str, Table]) -> dict[str, Table]:
    """Return the tables ``[apps.NAME]`` of a replay.

    Args:
        recorded: The apps of the recording.
        wanted: The apps to run: plug-ins, ``module:Class``, or Python files; empty for those of the recording. One
            whose class has the name of a recorded one takes its place, with its name and settings.
        given: Tables of a configuration, which win over the settings in the recording.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    known = tuple(recorded)
    if not wanted:
        tables = {one.name: _settings(one) | {"class": one.kind} for one in known}
    else:
        tables = {}
        for text in wanted:
            tables |= _in_place(_found(text), known)
    return {name: table | given.get(name, {}) | {"class": table["class"]} for name, table in tables.items()}


def _in_place(kind: type[object], recorded: Iterable[RecordedApp]) -> dict[str, Table]:
    """Return the tables of an app of the class *kind* for each recorded app of a class of that name; else its own."""
    wanted = f"{kind.__module__}:{kind.__qualname__}"
    same = [one for one in recorded if one.kind.rpartition(":")[2] == kind.__qualname__]
    if same:
        return {one.name: _settings(one) | {"class": wanted} for one in same}
    return {re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", kind.__name__).lower(): {"class": wanted}}


def _settings(app: RecordedApp) -> Table:
    try:
        found = json.loads(app.settings)
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the settings of {app.name} in the recording are no JSON") from exc
    if not isinstance(found, dict):
        raise UsageError(f"the settings of {app.name} in the recording are no table")
    return {**found}


def _found(text: str) -> type[object]:
    """Return the class that *text* names."""
    if (match := _FILE.fullmatch(text)) is None:
        plugin: type[object] = load_plugin(_APPS, text)
        return plugin
    module = _module(Path(match["file"]))
    kinds = {name: kind for name, kind in vars(module).items() if _is_app(kind, module)}
    if match["kind"] is not None:
        kinds = {name: kind for name, kind in kinds.items() if name == match["kind"]}
    if len(kinds) != 1:
        names = ", ".join(kinds) or "none"
        raise PluginError(text, f"must be one app, FILE.py or FILE.py:CLASS; the file has: {names}")
    found: type[object] = next(iter(kinds.values()))
    return found


def _is_app(kind: object, module: ModuleType) -> bool:
    return isinstance(kind, type) and issubclass(kind, App) and kind.__module__ == module.__name__


def _module(file: Path) -> ModuleType:
    """Run *file* as a module of its own, beside one of the same name that is installed."""
    if problem := why_not_trusted(file):
        raise PluginError(str(file), f"is not loaded: {problem}")
    name = f"replayed_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None or not name.isidentifier():
        raise PluginError(str(file), "is no file of Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as exc:
        del sys.modules[name]
        raise PluginError(str(file), f"cannot be loaded: {type(exc).__name__}: {exc}") from exc
    return module
