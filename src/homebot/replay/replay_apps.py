"""Apps of a replay: those of the recording, or others in their place."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from typing import Final

from homebot.apps import App
from homebot.config import Table
from homebot.errors import UsageError
from homebot.plugins import is_file, load_plugin, name_in_file
from homebot.recording.lines import RecordedApp

__all__ = ["app_tables"]

_APPS: Final = "homebot.apps"


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
    found: type[object] = load_plugin(_APPS, name_in_file(text, App) if is_file(text) else text)
    return found
