"""The event of a day, and the text form of a day: tables as TOML, times as in a timetable."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field

from homebot.config import parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.units import parse_duration

try:
    import tomli_w
except ModuleNotFoundError as exc:
    raise ImportError("days of a house need tomli-w: pip install 'homebot[testing]'") from exc

MAX_DAY_S: Final = 7 * 86_400.0
"""Latest time in a day, in seconds: a week after its midnight."""

_TIME: Final = re.compile(r"(\d{1,3}):([0-5]\d)(?::([0-5]\d)(?:\.(\d{1,6}))?)?", re.ASCII)


def write_time(seconds: float) -> str:
    """Return the time so many seconds after midnight: ``08:00``, ``08:00:05.250``, or ``25:30`` on the next day."""
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    text = f"{minutes // 60:02}:{minutes % 60:02}"
    if milliseconds:
        text += f":{milliseconds // 1000:02}"
    return f"{text}.{milliseconds % 1000:03}" if milliseconds % 1000 else text


def read_time(text: str) -> float:
    """Parse a time of :func:`write_time`; return seconds after midnight, rounded to milliseconds.

    Raises:
        UsageError: It is invalid.
    """
    parts = _TIME.fullmatch(text)
    if parts is None:
        raise UsageError(f"{text!r} is not a time of day; write it like 08:00 or 08:00:05.250")
    hours, minutes, seconds, fraction = parts.groups(default="0")
    whole = (int(hours) * 60 + int(minutes)) * 60 + int(seconds)
    return (whole * 1000 + round(int(fraction.ljust(6, "0")) / 1000)) / 1000


def write_duration(seconds: float) -> str:
    """Return so many seconds in the form of :func:`homebot.units.parse_duration`: ``8h``, ``1h30m``, ``0s``."""
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    parts = {"h": minutes // 60, "m": minutes % 60, "s": milliseconds // 1000, "ms": milliseconds % 1000}
    return "".join(f"{number}{unit}" for unit, number in parts.items() if number) or "0s"


def write_tables(tables: Mapping[str, object]) -> str:
    """Return *tables* as TOML; lists of tables, ``[[name]]``, come last."""
    lists = {name: value for name, value in tables.items() if _is_list_of_tables(value)}
    blocks = [tomli_w.dumps({name: value for name, value in tables.items() if name not in lists})]
    for name, value in lists.items():
        blocks += [f"[[{name}]]\n{tomli_w.dumps(table)}" for table in _tables(value)]
    return "\n".join(block for block in blocks if block)


def _tables(value: object) -> Iterable[Mapping[str, object]]:
    return [table for table in value if isinstance(table, Mapping)] if isinstance(value, list | tuple) else []


def _is_list_of_tables(value: object) -> bool:
    return isinstance(value, list | tuple) and bool(value) and len(list(_tables(value))) == len(value)


ValueT = TypeVar("ValueT")

What = Literal["press", "tell", "cut", "pull", "restart"]

HAPPENINGS: Final[tuple[What, ...]] = get_args(What)
"""All kinds of events, simplest first."""

_TAKES: Final[Mapping[What, frozenset[str]]] = {
    "press": frozenset({"device", "command"}),
    "tell": frozenset({"device", "command"}),
    "cut": frozenset({"device"}),
    "pull": frozenset({"device", "lasts"}),
    "restart": frozenset({"lasts", "forget"}),
}


@dataclass(frozen=True, slots=True)
class DayEvent:
    """An event in a house.

    Attributes:
        at: Seconds since the midnight before the day, 0 to a week; rounded to milliseconds.
        what: A device is operated by hand (``press``) or gets a command over the network (``tell``); its link is
            ``cut``, after which it reconnects; its cable is pulled (``pull``), so that all traffic stops without either
            side being informed; or the broker restarts (``restart``).
        device: The device; not for ``restart``.
        command: The command, by hand or over the network; only for ``press`` and ``tell``.
        lasts: Seconds until the cable is plugged in or the broker is back; only for ``pull`` and ``restart``.
        forget: Whether the broker loses its sessions and retained messages; only for ``restart``.

    Raises:
        UsageError: A value is out of range, missing, or not allowed for this kind of event.
    """

    at: float
    what: What
    device: str = ""
    command: str = ""
    lasts: float = 0.0
    forget: bool = False

    def __post_init__(self) -> None:
        if self.what not in _TAKES:
            raise UsageError(f"what must be one of {', '.join(HAPPENINGS)}, got {self.what!r}")
        object.__setattr__(self, "at", _within(self.at, "at"))
        object.__setattr__(self, "lasts", _within(self.lasts, "lasts"))
        takes = _TAKES[self.what]
        for name in ("device", "command", "lasts", "forget"):
            if getattr(self, name) and name not in takes:
                raise UsageError(f"{name} is not for {self.what}, which takes {', '.join(sorted(takes))}")
        if "device" in takes and not self.device:
            raise UsageError(f"{self.what} needs a device")
        if any("\ud800" <= letter <= "\udfff" for letter in self.command):
            raise UsageError(f"the command {self.command!r} is not text that can be sent")

    def table(self) -> dict[str, object]:
        """Return it as a table for the file."""
        takes = _TAKES[self.what]
        table: dict[str, object] = {"at": write_time(self.at), "what": self.what}
        table |= {name: getattr(self, name) for name in ("device", "command") if name in takes}
        if self.lasts:
            table["lasts"] = write_duration(self.lasts)
        if self.forget:
            table["forget"] = True
        return table

    @classmethod
    def parse(cls, table: Mapping[str, object], source: str, key: str) -> DayEvent:
        """Return the event in *table*.

        Raises:
            ConfigError: A key is unknown or a value is invalid; the message names *source*, *key* and the reason.
        """
        values = parse_settings(_DayEventTable, table, source, key)
        at = _read(read_time, values.at, source, f"{key}.at")
        lasts = _read(parse_duration, values.lasts, source, f"{key}.lasts")
        try:
            return cls(at, values.what, values.device, values.command, lasts, values.forget)
        except UsageError as exc:
            raise ConfigError(source, key, str(exc)) from exc


class _DayEventTable(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    at: str
    what: What
    device: str = ""
    command: str = ""
    lasts: str | float = Field(default=0.0, union_mode="left_to_right")
    forget: bool = False


def _within(seconds: float, name: str) -> float:
    if not 0.0 <= seconds <= MAX_DAY_S:
        raise UsageError(f"{name} must be from 0 to {MAX_DAY_S:.0f} seconds, got {seconds}")
    return round(float(seconds), 3)


def _read(read: Callable[[ValueT], float], value: ValueT, source: str, key: str) -> float:
    try:
        return read(value)
    except UsageError as exc:
        raise ConfigError(source, key, str(exc)) from exc
