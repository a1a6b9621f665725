"""Text form of a day: its tables as TOML, its times as in a timetable."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Final

from homebot.errors import UsageError

try:
    import tomli_w
except ModuleNotFoundError as exc:
    raise ImportError("days of a house need tomli-w: pip install 'homebot[testing]'") from exc

__all__ = ["LONGEST", "read_time", "write_duration", "write_tables", "write_time"]

LONGEST: Final = 7 * 86_400.0
"""Seconds: no time in a day is later than a week after its midnight."""

_TIME: Final = re.compile(r"(\d{1,3}):([0-5]\d)(?::([0-5]\d)(?:\.(\d{1,6}))?)?", re.ASCII)


def write_time(seconds: float) -> str:
    """Return the time so many seconds after midnight: ``08:00``, ``08:00:05.250``, and ``25:30`` on the next day."""
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    text = f"{minutes // 60:02}:{minutes % 60:02}"
    if milliseconds:
        text += f":{milliseconds // 1000:02}"
    return f"{text}.{milliseconds % 1000:03}" if milliseconds % 1000 else text


def read_time(text: str) -> float:
    """Return the seconds after midnight that :func:`write_time` wrote; rounded to milliseconds.

    Raises:
        UsageError: It is no such time.
    """
    parts = _TIME.fullmatch(text)
    if parts is None:
        raise UsageError(f"{text!r} is no time; write it like 08:00 or 08:00:05.250")
    hours, minutes, seconds, fraction = parts.groups(default="0")
    whole = (int(hours) * 60 + int(minutes)) * 60 + int(seconds)
    return (whole * 1000 + round(int(fraction.ljust(6, "0")) / 1000)) / 1000


def write_duration(seconds: float) -> str:
    """Return so many seconds as :func:`homebot.units.parse_duration` reads them: ``8h``, ``1h30m``, ``0s``."""
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    parts = {"h": minutes // 60, "m": minutes % 60, "s": milliseconds // 1000, "ms": milliseconds % 1000}
    return "".join(f"{number}{unit}" for unit, number in parts.items() if number) or "0s"


def write_tables(tables: Mapping[str, object]) -> str:
    """Return *tables* as TOML; a list of tables becomes ``[[name]]``, behind the others."""
    lists = {name: value for name, value in tables.items() if _is_list_of_tables(value)}
    blocks = [tomli_w.dumps({name: value for name, value in tables.items() if name not in lists})]
    for name, value in lists.items():
        blocks += [f"[[{name}]]\n{tomli_w.dumps(table)}" for table in _tables(value)]
    return "\n".join(block for block in blocks if block)


def _tables(value: object) -> Iterable[Mapping[str, object]]:
    return [table for table in value if isinstance(table, Mapping)] if isinstance(value, list | tuple) else []


def _is_list_of_tables(value: object) -> bool:
    return isinstance(value, list | tuple) and bool(value) and len(list(_tables(value))) == len(value)
