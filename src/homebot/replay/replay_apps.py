"""Apps of a replay: those of the recording, or others in their place."""

import json
from collections.abc import Iterable, Sequence
from typing import Final

from homebot.apps import App
from homebot.config import Table
from homebot.errors import UsageError
from homebot.feature import feature_tables, plugin_tables
from homebot.names import snake_case
from homebot.plugins import installed_plugin, is_file, load_plugin, name_in_file
from homebot.recording.lines import RecordedApp

_APPS: Final = "homebot.apps"
_SHOWN: Final = 60
_MAX_SHOWN: Final = 3


def app_tables(recorded: Iterable[RecordedApp], wanted: Sequence[str], given: dict[str, Table]) -> dict[str, Table]:
    """Return the tables ``[apps.NAME]`` of a replay.

    Args:
        recorded: The apps of the recording; only installed plug-ins are loaded, because a recording must not run other
        code.
        wanted: The apps to run: plug-ins, ``module:Class``, or Python files; empty for those of the recording. An app
        with the class name of a recorded one replaces it, and gets its name and settings.
        given: Tables of a configuration, which take precedence over the recorded settings.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    moved = {row.was: row.plugin for row in feature_tables().values() if row.was}
    known = tuple([app.model_copy(update={"kind": moved.get(app.kind, app.kind)}) for app in recorded])
    if wanted:
        tables = _tables_of(wanted, known)
    else:
        own = plugin_tables()
        others = [app for app in known if app.kind not in own and installed_plugin(_APPS, app.kind) is None]
        if others:
            named = ", ".join(f"{app.name} ({app.kind[:_SHOWN]})" for app in others[:_MAX_SHOWN])
            raise UsageError(
                f"the recording names apps that are not installed, and a replay runs no code that only a recording "
                f"names: {named}; name each app to run, such as --app FILE.py"
            )
        tables = {app.name: _settings(app) | {"class": app.kind} for app in known}
    return {name: table | given.get(name, {}) | {"class": table["class"]} for name, table in tables.items()}


def _tables_of(wanted: Iterable[str], known: Iterable[RecordedApp]) -> dict[str, Table]:
    classes: list[type[object]] = [
        load_plugin(_APPS, name_in_file(text, App) if is_file(text) else text) for text in wanted
    ]
    kinds = {_kind_of(app_class) for app_class in classes}
    tables: dict[str, Table] = {}
    for app_class in classes:
        same = [app for app in known if app.kind == _kind_of(app_class)]
        tables |= _in_place(app_class, same or [app for app in known if app.kind not in kinds])
    return tables


def _kind_of(app: type[object]) -> str:
    return f"{app.__module__}:{app.__qualname__}"


def _in_place(app: type[object], recorded: Iterable[RecordedApp]) -> dict[str, Table]:
    """Return the tables of *app* in place of *recorded* ones with its class name; if there are none, its own."""
    same = [recorded_app for recorded_app in recorded if recorded_app.kind.rpartition(":")[2] == app.__qualname__]
    if len(kinds := sorted({recorded_app.kind for recorded_app in same})) > 1:
        named = " or ".join(kind[:_SHOWN] for kind in kinds[:_MAX_SHOWN])
        raise UsageError(f"{_kind_of(app)} may replace {named}: give its file the name of the one that it replaces")
    if same:
        return {recorded_app.name: _settings(recorded_app) | {"class": _kind_of(app)} for recorded_app in same}
    return {snake_case(app.__name__): {"class": _kind_of(app)}}


def _settings(app: RecordedApp) -> Table:
    return recorded_table(app.settings, f"table [apps.{app.name}]")


def recorded_table(text: str, what: str) -> Table:
    """Return the table in *text*, a JSON object.

    Raises:
        UsageError: It is not an object; the recording is damaged.
    """
    try:
        return as_table(json.loads(text), what)
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the {what} in the recording is not JSON") from exc


def as_table(found: object, what: str) -> Table:
    """Return *found* as a table; errors as for :func:`recorded_table`."""
    if not isinstance(found, dict):
        raise UsageError(f"the {what} in the recording is not a table")
    return {**found}
