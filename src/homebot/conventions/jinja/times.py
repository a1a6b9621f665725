"""Filters and functions about time. The clock and the time zone are those of the caller, or these fail."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Final

from homebot.conventions.jinja.errors import TemplateError
from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.formatting import strftime_format
from homebot.conventions.jinja.numbers import MISSING
from homebot.conventions.jinja.undefined import Undefined
from homebot.conventions.jinja.values import real, text

__all__ = ["TIME_FILTERS", "TIME_FUNCTIONS"]


def _now(run: Run) -> datetime:
    if run.now is None:
        raise TemplateError("the template asks for the time, which is not known here")
    return run.now


def _utc_now(run: Run) -> datetime:
    return _now(run).astimezone(UTC)


def _local(run: Run, value: datetime) -> datetime:
    zone = _now(run).tzinfo
    return value.replace(tzinfo=zone) if value.tzinfo is None else value.astimezone(zone)


def _from_timestamp(value: object) -> datetime:
    if isinstance(value, str):
        raise TypeError("a timestamp is a number")
    return datetime.fromtimestamp(real(value), UTC)


def _timestamp_custom(
    run: Run, value: object, date_format: object = "%Y-%m-%d %H:%M:%S", local: object = True, default: object = MISSING
) -> object:
    try:
        moment = _from_timestamp(value)
    except (ValueError, TypeError, OverflowError, OSError):
        return _or_default(default, "timestamp_custom")
    return (_local(run, moment) if local else moment).strftime(strftime_format(text(date_format)))


def _timestamp_local(run: Run, value: object, default: object = MISSING) -> object:
    try:
        moment = _from_timestamp(value)
    except (ValueError, TypeError, OverflowError, OSError):
        return _or_default(default, "timestamp_local")
    return _local(run, moment).isoformat()


def _timestamp_utc(_: Run, value: object, default: object = MISSING) -> object:
    try:
        return _from_timestamp(value).isoformat()
    except (ValueError, TypeError, OverflowError, OSError):
        return _or_default(default, "timestamp_utc")


def _as_datetime(_: Run, value: object, default: object = MISSING) -> object:
    if isinstance(value, datetime):
        return value
    try:
        return datetime.fromtimestamp(real(value), UTC)
    except (ValueError, TypeError, OverflowError, OSError):
        pass
    if not isinstance(value, str):
        return _or_default(default, "as_datetime")
    try:
        return datetime.fromisoformat(value)
    except ValueError:
        return None if default is MISSING else default


def _as_timestamp(run: Run, value: object, default: object = MISSING) -> object:
    if isinstance(value, Undefined):
        value.fail()
    try:
        moment = value if isinstance(value, datetime) else datetime.fromisoformat(text(value))
        return (_local(run, moment) if moment.tzinfo is None else moment).timestamp()
    except ValueError:
        return _or_default(default, "as_timestamp")


def _as_local(run: Run, value: object) -> datetime:
    if not isinstance(value, datetime):
        raise TypeError(f"a {type(value).__name__} is no time")
    return _local(run, value)


def _timedelta(_: Run, **parts: float) -> timedelta:
    return timedelta(**parts)


def _or_default(default: object, filter_: str) -> object:
    if default is MISSING:
        raise TemplateError(f"{filter_} is given what is no time, and no default")
    return default


TIME_FUNCTIONS: Final[dict[str, Callable[..., object]]] = {
    "as_datetime": _as_datetime,
    "as_local": _as_local,
    "as_timestamp": _as_timestamp,
    "now": _now,
    "timedelta": _timedelta,
    "utcnow": _utc_now,
}
"""By name; each takes the run first."""

TIME_FILTERS: Final[dict[str, Callable[..., object]]] = {
    "as_datetime": _as_datetime,
    "as_local": _as_local,
    "as_timestamp": _as_timestamp,
    "timestamp_custom": _timestamp_custom,
    "timestamp_local": _timestamp_local,
    "timestamp_utc": _timestamp_utc,
}
"""By name; each takes the run and the value first."""
