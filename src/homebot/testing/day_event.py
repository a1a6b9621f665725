"""One thing that happens in a day."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field

from homebot.config import parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.testing.day_text import LONGEST, read_time, write_duration, write_time
from homebot.units import parse_duration

__all__ = ["HAPPENINGS", "DayEvent", "What"]

ValueT = TypeVar("ValueT")

What = Literal["press", "tell", "cut", "pull", "restart"]

HAPPENINGS: Final[tuple[What, ...]] = get_args(What)
"""All that can happen, the simplest first."""

_TAKES: Final[Mapping[What, frozenset[str]]] = {
    "press": frozenset({"device", "command"}),
    "tell": frozenset({"device", "command"}),
    "cut": frozenset({"device"}),
    "pull": frozenset({"device", "lasts"}),
    "restart": frozenset({"lasts", "forget"}),
}


@dataclass(frozen=True, slots=True)
class DayEvent:
    """One thing that happens to a house.

    Attributes:
        at: Seconds since the midnight before the day, 0 to a week; rounded to milliseconds.
        what: Hands ``press`` a switch of a device; somebody on the wire tells (``tell``) it a command; its link is
            ``cut``, after which it dials again; its cable is pulled (``pull``): nothing is carried, and nobody is told;
            or the broker goes and comes back (``restart``).
        device: Which device; not for ``restart``.
        command: What hands or the wire want; for ``press`` and ``tell`` alone.
        lasts: Seconds until the cable is plugged in or the broker is back; for ``pull`` and ``restart`` alone.
        forget: Whether the broker comes back without its sessions and retained messages; for ``restart`` alone.

    Raises:
        UsageError: A value is out of its range, is missing, or is one that this does not take.
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
            raise UsageError(f"the command {self.command!r} is no text that can be sent")

    def table(self) -> dict[str, object]:
        """Return it as a table of the file."""
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
        """Return what *table* says.

        Raises:
            ConfigError: A key is unknown or a value wrong; names *source*, *key* and reason.
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
    if not 0.0 <= seconds <= LONGEST:
        raise UsageError(f"{name} must be from 0 to {LONGEST:.0f} seconds, got {seconds}")
    return round(float(seconds), 3)


def _read(read: Callable[[ValueT], float], value: ValueT, source: str, key: str) -> float:
    try:
        return read(value)
    except UsageError as exc:
        raise ConfigError(source, key, str(exc)) from exc
