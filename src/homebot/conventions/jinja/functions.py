"""All filters and functions of the language by name, and what only Home Assistant has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from homebot.conventions.jinja.arithmetic import ORDER
from homebot.conventions.jinja.errors import TemplateError
from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.lists import LIST_FILTERS, LIST_FUNCTIONS, attribute_of, values_of
from homebot.conventions.jinja.numbers import NUMBER_CONSTANTS, NUMBER_FILTERS, NUMBER_FUNCTIONS
from homebot.conventions.jinja.patterns import find_all, find_all_index, matches, replaces, searches
from homebot.conventions.jinja.texts import TEXT_FILTERS, TEXT_FUNCTIONS
from homebot.conventions.jinja.times import TIME_FILTERS, TIME_FUNCTIONS
from homebot.conventions.jinja.undefined import Undefined
from homebot.conventions.jinja.values import Namespace

__all__ = ["CONSTANTS", "FILTERS", "FUNCTIONS", "HOME_ASSISTANT"]


def _contains(_: Run, value: object, one: object) -> object:
    return ORDER["in"](one, value)


def _namespace(_: Run, **attributes: object) -> Namespace:
    return Namespace(attributes)


def _map(run: Run, value: object, *arguments: object, **named: object) -> object:
    values = values_of(run, value) if value else []
    run.spend(4 * len(values))
    if not arguments and "attribute" in named:
        default = named.get("default")
        found = [attribute_of(one, named["attribute"]) for one in values]
        return [default if default is not None and isinstance(one, Undefined) else one for one in found]
    mapped = FILTERS.get(str(arguments[0])) if arguments else None
    if mapped is None or mapped is _map:
        raise TemplateError("map is given no filter that it could apply")
    return [run.handle(mapped(run, run.handle(one), *arguments[1:], **named)) for one in values]


CONSTANTS: Final[dict[str, float]] = NUMBER_CONSTANTS
"""Meanings of these names where the template and its variables say nothing else."""

FILTERS: Final[dict[str, Callable[..., object]]] = {
    **LIST_FILTERS,
    **NUMBER_FILTERS,
    **TEXT_FILTERS,
    **TIME_FILTERS,
    "contains": _contains,
    "map": _map,
    "regex_findall": find_all,
    "regex_findall_index": find_all_index,
    "regex_match": matches,
    "regex_replace": replaces,
    "regex_search": searches,
}
"""By name; each takes the run and the value first."""

FUNCTIONS: Final[dict[str, Callable[..., object]]] = {
    **LIST_FUNCTIONS,
    **NUMBER_FUNCTIONS,
    **TEXT_FUNCTIONS,
    **TIME_FUNCTIONS,
    "namespace": _namespace,
}
"""By name; each takes the run first."""

HOME_ASSISTANT: Final = frozenset(
    {
        "area_devices",
        "area_entities",
        "area_id",
        "area_name",
        "areas",
        "closest",
        "config_entry_id",
        "device_attr",
        "device_entities",
        "device_id",
        "distance",
        "expand",
        "has_value",
        "integration_entities",
        "is_device_attr",
        "is_hidden_entity",
        "is_state",
        "is_state_attr",
        "relative_time",
        "state_attr",
        "state_translated",
        "states",
        "this",
        "time_since",
        "time_until",
        "today_at",
        "trigger",
    }
)
"""Names that only mean something inside Home Assistant."""
