"""All filters and functions by name, those of time, and the names of Home Assistant alone. Pure.

The time and its zone are those of :data:`homebot.clock.home_time`; without it, functions that need the time fail, and
``timestamp_local`` names the same moment in UTC.
"""

import re
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Final

from homebot.clock import home_time
from homebot.integrations.homeassistant.formats.jinja.evaluation import Run
from homebot.integrations.homeassistant.formats.jinja.lists import (
    CHECKS,
    LIST_FILTERS,
    LIST_FUNCTIONS,
    attribute_of,
    values_of,
)
from homebot.integrations.homeassistant.formats.jinja.numbers import MISSING, NUMBER_FILTERS, NUMBER_FUNCTIONS
from homebot.integrations.homeassistant.formats.jinja.texts import (
    TEXT_FILTERS,
    TEXT_FUNCTIONS,
    find_all,
    find_all_index,
    matches,
    replaces,
    searches,
    strftime_format,
)
from homebot.integrations.homeassistant.formats.jinja.values import Namespace, TemplateError, Undefined, real, text


def _now(*_: object) -> datetime:
    now = home_time.get()
    if now is None:
        raise TemplateError("the template uses the current time, which is not available here")
    return now()


def _as_local(_: Run, value: object) -> datetime:
    if not isinstance(value, datetime):
        raise TypeError(f"as_local is given a {type(value).__name__}")
    zone = _now().tzinfo
    return value.replace(tzinfo=zone) if value.tzinfo is None else value.astimezone(zone)


def _from_timestamp(value: object) -> datetime:
    if isinstance(value, str):
        raise TypeError("a timestamp must be a number")
    return datetime.fromtimestamp(real(value), UTC)


def _or_default(default: object, name: str, convert: Callable[[], object]) -> object:
    """Return the converted time, or the *default* for a value that is none."""
    try:
        return convert()
    except (ValueError, TypeError, OverflowError, OSError, re.error):
        if default is MISSING:
            raise TemplateError(f"{name} is given a value that is not a time, and no default") from None
        return default


def _timestamp_custom(
    _: Run, value: object, date_format: object = "%Y-%m-%d %H:%M:%S", local: object = True, default: object = MISSING
) -> object:
    moment = _or_default(default, "timestamp_custom", lambda: _from_timestamp(value))
    if not isinstance(moment, datetime):
        return moment
    return (_as_local(_, moment) if local else moment).strftime(strftime_format(text(date_format)))


def _timestamp_utc(_: Run, value: object, default: object = MISSING) -> object:
    return _or_default(default, "timestamp_utc", lambda: _from_timestamp(value).isoformat())


def _timestamp_local(run: Run, value: object, default: object = MISSING) -> object:
    moment = _or_default(default, "timestamp_local", lambda: _from_timestamp(value))
    if not isinstance(moment, datetime):
        return moment
    return (moment if home_time.get() is None else _as_local(run, moment)).isoformat()


def _relative_time(run: Run, value: object) -> object:
    """Return the age of a time in its largest unit, as Home Assistant: ``3 hours``."""
    if not isinstance(value, datetime):
        return value
    seconds = (_now() - _as_local(run, value)).total_seconds()
    if seconds < 0:
        return value
    length, unit = next((unit_known for unit_known in _UNITS if seconds >= unit_known[0]), _UNITS[-1])
    count = round(seconds / length)
    return f"{count} {unit}{'' if count == 1 else 's'}"


_UNITS = ((31_536_000, "year"), (2_592_000, "month"), (86_400, "day"), (3_600, "hour"), (60, "minute"), (1, "second"))


def _as_datetime(_: Run, value: object, default: object = MISSING) -> object:
    if isinstance(value, datetime):
        return value
    try:
        return datetime.fromtimestamp(real(value), UTC)
    except (ValueError, TypeError, OverflowError, OSError):
        if not isinstance(value, str):
            return _or_default(default, "as_datetime", lambda: _from_timestamp(value))
    return _or_default(None if default is MISSING else default, "as_datetime", lambda: datetime.fromisoformat(value))


def _strptime(run: Run, value: object, date_format: object, default: object = MISSING) -> object:
    layout = strftime_format(text(date_format))
    run.spend(_LAYOUT_STEPS)
    return _or_default(default, "strptime", lambda: datetime.strptime(_short(value), layout))  # noqa: DTZ007 - without a zone, as in Home Assistant


def _short(value: object) -> str:
    if not isinstance(value, str) or len(value) > _MAX_TIME_CHARACTERS:
        raise TypeError("a time must be a short text")
    return value


_MAX_TIME_CHARACTERS = 255
_LAYOUT_STEPS = 200
"""Steps for what a layout takes to be compiled."""


def _as_timestamp(_: Run, value: object, default: object = MISSING) -> object:
    if isinstance(value, Undefined):
        value.fail()
    if isinstance(value, datetime):
        return _timestamp(value)
    return _or_default(default, "as_timestamp", lambda: _timestamp(datetime.fromisoformat(text(value))))


def _timestamp(moment: datetime) -> float:
    return (moment if moment.tzinfo is not None else moment.replace(tzinfo=_now().tzinfo)).timestamp()


_TIME_FUNCTIONS: Final[dict[str, Callable[..., object]]] = {
    "as_datetime": _as_datetime,
    "as_timestamp": _as_timestamp,
    "strptime": _strptime,
    "timedelta": lambda _, **parts: timedelta(**parts),
    "as_local": _as_local,
    "now": _now,
    "relative_time": _relative_time,
    "utcnow": lambda _: _now().astimezone(UTC),
}
"""By name; each takes the run first."""


def _map(run: Run, value: object, *arguments: object, **named: object) -> object:
    values = values_of(run, value) if value else []
    run.spend(4 * len(values))
    if not arguments and "attribute" in named:
        default = named.get("default")
        attributes = [attribute_of(element, named["attribute"]) for element in values]
        return [
            default if default is not None and isinstance(attribute, Undefined) else attribute
            for attribute in attributes
        ]
    mapped = FILTERS.get(str(arguments[0])) if arguments else None
    if mapped is None or mapped is _map:
        raise TemplateError("map is given no filter that it could apply")
    flat: list[object] = []
    for item in values:
        run.spend_on_search((item, *arguments[1:], *named.values()))
        flat.append(run.handle(mapped(run, run.handle(item), *arguments[1:], **named)))
    return flat


FILTERS: Final[dict[str, Callable[..., object]]] = {
    **LIST_FILTERS,
    **NUMBER_FILTERS,
    **TEXT_FILTERS,
    **{name: _TIME_FUNCTIONS[name] for name in ("as_datetime", "as_local", "as_timestamp", "relative_time")},
    "timestamp_custom": _timestamp_custom,
    "timestamp_local": _timestamp_local,
    "timestamp_utc": _timestamp_utc,
    "contains": CHECKS["contains"],
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
    **_TIME_FUNCTIONS,
    "namespace": lambda _, **attributes: Namespace(attributes),
}
"""By name; each takes the run first."""

_HOME_ASSISTANT = """
area_devices area_entities area_id area_name areas closest config_entry_id device_attr device_entities device_id
distance expand has_value integration_entities is_device_attr is_hidden_entity is_state is_state_attr
state_attr state_translated states time_since time_until today_at trigger
"""
HOME_ASSISTANT: Final = frozenset(_HOME_ASSISTANT.split())
"""Names that only mean something inside Home Assistant.

``this`` is not among them: it is undefined, so that a message with which a template asks for ``this.state``, the last
value, changes nothing.
"""
