"""Installed conventions of a gateway, and the checks of their tables."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError, to_json

from homebot.conventions.convention import Convention, SlicedConvention, TextConvention
from homebot.errors import PluginError
from homebot.plugins import load_plugin, own_plugin_names, plugin_names
from homebot.support.key_roles import note_table
from homebot.support.names import unknown_key

GROUP = "homebot.mqtt_conventions"

_MEMBERS = ("Settings", "name", "filters", "birth_messages", "read_message")


def default_conventions() -> tuple[str, ...]:
    """Return homebot's own conventions; those of other packages are used if the configuration names them."""
    return own_plugin_names(GROUP)


def any_announcing(names: Iterable[str]) -> bool:
    """Return whether one of the loadable conventions *names* has announcements."""
    return any(not issubclass(kind, TextConvention) for _, kind in _loadable(names))


def find_conventions(
    names: Iterable[str], tables: Mapping[str, object], root: str, home: str = ""
) -> tuple[Convention, ...]:
    """Load and create the conventions *names*, in the order in which their announcements are to be asked for.

    Those with lists of all devices come first: a list takes seconds to read, in which nothing is announced. Were it
    last, all devices would be described before it, and again with it.

    Args:
        names: Entry-point names, or ``module:Class``.
        tables: Their settings, by name; see :func:`check_tables`.
        root: The home of the gateway, the default for tables with a ``root``.
        home: The name of the home, the default for tables with a ``home``.

    Raises:
        PluginError: One cannot be found or loaded.
        ValidationError: A table is wrong.
    """
    conventions: list[Convention] = []
    for name in dict.fromkeys(names):
        kind = _load(name)
        table = tables.get(_table_name(name, kind), {})
        if isinstance(table, dict):
            known = {key: value for key, value in (("root", root), ("home", home)) if key in kind.Settings.model_fields}
            table = {**known, **table}
        settings = _check(kind.Settings, table)
        try:
            conventions.append(kind(settings))
        except Exception as exc:
            raise PluginError(name, f"cannot be created: {type(exc).__name__}: {exc}") from exc
    return tuple(sorted(conventions, key=lambda convention: not isinstance(convention, SlicedConvention)))


def check_tables(names: tuple[str, ...], tables: Mapping[str, object]) -> list[InitErrorDetails]:
    """Return the errors of *tables*, which must belong to the conventions *names*.

    A convention that cannot be loaded is skipped: :func:`find_conventions` reports it.
    """
    models: dict[str, type[BaseModel]] = {}
    for name, kind in _loadable(names):
        models[_table_name(name, kind)] = kind.Settings
    problems: list[InitErrorDetails] = []
    for key, table in tables.items():
        if key not in models:
            words = f"is a convention that `conventions` does not name: {', '.join(names) or 'none'}"
            kind_of_error = PydanticCustomError("value_error", "{words}", {"words": words})
            is_convention = key in plugin_names(GROUP)
            problems.append(
                InitErrorDetails(type=kind_of_error if is_convention else "extra_forbidden", loc=(key,), input=table)
            )
            continue
        note_table(key, models[key], table)
        try:
            _check(models[key], table)
        except ValidationError as exc:
            problems += [_problem(key, models[key], error) for error in exc.errors(include_url=False)]
    return problems


def _loadable(names: Iterable[str]) -> Iterator[tuple[str, type[Any]]]:
    for name in names:
        try:
            yield name, _load(name)
        except PluginError:
            continue


def _load(name: str) -> type[Any]:
    kind = load_plugin(GROUP, name)
    if missing := [member for member in _MEMBERS if not hasattr(kind, member)]:
        raise PluginError(name, f"is no convention: it has no {', no '.join(missing)}")
    return kind


def _table_name(name: str, kind: type[Convention]) -> str:
    return kind.name if ":" in name else name


def _check(model: type[BaseModel], table: object) -> BaseModel:
    return model.model_validate_json(to_json(table), strict=True)


def _problem(key: str, model: type[BaseModel], error: Mapping[str, object]) -> InitErrorDetails:
    """Return a problem in the form of ``[gateways.NAME]``: key, error and value."""
    loc = error["loc"]
    words = str(error["msg"]).removeprefix("Value error, ")
    words = f"{words[:1].lower()}{words[1:]}"
    if error["type"] == "extra_forbidden":
        words = unknown_key(str(loc[-1]) if isinstance(loc, tuple) else "", model.model_fields)
    kind = PydanticCustomError("value_error", "{words}", {"words": words})
    return InitErrorDetails(type=kind, loc=(key, *(loc if isinstance(loc, tuple) else ())), input=error["input"])
