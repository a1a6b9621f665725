"""A day in a house as plain data: the house and its events; saved as one TOML file and lived again.

::

    [day]
    start = "06:30"
    length = "2h"

    [rooms.hall]                    # the house, as docs/house.md says
    doors = ["outside"]

    [devices.lamp]
    kind = "lamp"
    room = "hall"

    [[happenings]]
    at = "07:00"
    what = "press"
    device = "lamp"
    command = "on"
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from pydantic import BaseModel, ConfigDict, Field

from homebot.config import Table, parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.house.description import parse_world
from homebot.house.event_log import WorldLog
from homebot.house.rooms import DAY
from homebot.house.world import World
from homebot.support.toml_file import parse_toml, read_toml
from homebot.testing.day_event import LONGEST, DayEvent, read_time, write_duration, write_tables, write_time
from homebot.units import parse_duration

if TYPE_CHECKING:
    from homebot.testing.virtual_house import VirtualHouse

__all__ = ["Day"]

HAPPENINGS = "happenings"
HEAD = "day"


@dataclass(frozen=True, repr=False)
class Day:
    """A house and its events on one day.

    Attributes:
        house: The tables that describe it, as :func:`homebot.house.description.parse_world` takes them; not to
            be changed.
        happenings: The events, in time order; of two at one time the first given comes first.
        start: Start in seconds after midnight, below 24 hours. Earlier events of the house itself happen too.
        length: Seconds until it ends; at most a week after the midnight.

    Raises:
        ConfigError: The house cannot be built, or something happens outside the day or to a device that is not there.
    """

    house: Mapping[str, object]
    happenings: Sequence[DayEvent] = ()
    start: float = 0.0
    length: float = DAY
    source: str = field(default="day", compare=False, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "house", copy.deepcopy(dict(self.house)))
        object.__setattr__(self, "start", round(float(self.start), 3))
        object.__setattr__(self, "length", round(float(self.length), 3))
        self._check()
        object.__setattr__(self, HAPPENINGS, tuple(sorted(self.happenings, key=lambda happening: happening.at)))

    @property
    def end(self) -> float:
        """Seconds after midnight when it ends."""
        return round(self.start + self.length, 3)

    @classmethod
    def load(cls, path: str | Path) -> Day:
        """Return the day that was saved in *path*; where the file describes a house alone, nothing happens in it.

        Raises:
            ConfigError: The file cannot be read or is no TOML, or a key or value is wrong; names file, key and reason.
        """
        return cls._from_tables(read_toml(Path(path), any_text=True), str(path))

    @classmethod
    def parse(cls, text: str, source: str = "day") -> Day:
        """Return the day that *text* spells; errors name *source*.

        Raises:
            ConfigError: As :meth:`load`.
        """
        return cls._from_tables(parse_toml(text, source, any_text=True), source)

    def save(self, path: str | Path) -> None:
        """Write it to *path*; :meth:`load` returns the same day. Directories on the way are made.

        Raises:
            UsageError: The file cannot be written.
        """
        path = Path(path)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(str(self), encoding="utf-8", newline="\n")
        except OSError as exc:
            raise UsageError(f"{path} cannot be written: {exc.strerror or exc}") from exc

    def __str__(self) -> str:
        """Return its file, letter for letter."""
        head = {"start": write_time(self.start), "length": write_duration(self.length)}
        happenings = [happening.table() for happening in self.happenings]
        return write_tables({HEAD: head, **self.house} | ({HAPPENINGS: happenings} if happenings else {}))

    def __repr__(self) -> str:
        """Return Python that makes it again, which can be copied into ``@example``."""
        text = str(self)
        return f"Day.parse({text!r})" if "\\" in text or '"""' in text else f'Day.parse("""\n{text}""")'

    def _repr_pretty_(self, printer: _Printer, cycle: bool) -> None:  # noqa: FBT001 - IPython's protocol
        """Show it like that in a failing example of Hypothesis too."""
        del cycle
        printer.text(repr(self))

    def world(self, *, seed: int | None = None) -> World:
        """Return its house, fresh, at midnight; *seed* is in place of the house's own."""
        return parse_world(self.house, self.source, seed=seed)

    def play(self, world: World | None = None) -> WorldLog:
        """Play the day without a wire, in a few milliseconds.

        Events on the wire (``cut``, ``pull``, ``restart``) change nothing here.

        Args:
            world: The house to live it in; without it a fresh one of its own.

        Returns:
            All that happened in the house since midnight; byte for byte the same each time.

        Raises:
            UsageError: A device is not in *world*.
        """
        world = self.world() if world is None else world
        for event in self.happenings:
            if event.what == "tell":
                world.command(event.device, event.command, event.at)
            elif event.what == "press":
                world.press(event.device, event.command, event.at)
        world.run_until(self.end)
        return world.event_log

    async def live(self, house: VirtualHouse, *, root: str = "home425") -> tuple[DayEvent, ...]:
        """Play the day on the wire, in virtual time.

        Args:
            house: A house with this day's :meth:`world`, on its first day and not later than the start.

        Returns:
            Events without effect: a command while the broker was away, a cut of a link that was down.

        Raises:
            UsageError: It is too late in the house for this day, or a device is not in it.
        """
        from homebot.testing.day_live import live  # noqa: PLC0415 - a day that is played needs no wire

        return await live(self, house, root=root)

    @classmethod
    def _from_tables(cls, tables: Table, source: str) -> Day:
        house = {name: table for name, table in tables.items() if name not in {HEAD, HAPPENINGS}}
        own = parse_settings(_Own, {name: tables[name] for name in (HEAD, HAPPENINGS) if name in tables}, source, "")
        head = parse_settings(_Head, own.day, source, HEAD)
        happenings = [
            DayEvent.parse(table, source, f"{HAPPENINGS}.{number}") for number, table in enumerate(own.happenings)
        ]
        try:
            start, length = read_time(head.start), parse_duration(head.length)
        except UsageError as exc:
            raise ConfigError(source, HEAD, str(exc)) from exc
        return cls(house, happenings, start, length, source=source)

    def _check(self) -> None:
        if not 0.0 <= self.start < DAY:
            raise ConfigError(self.source, f"{HEAD}.start", f"must be from 00:00 to 23:59, got {self.start} s")
        if not 0.0 < self.length <= LONGEST - self.start:
            raise ConfigError(
                self.source, f"{HEAD}.length", f"must be above 0 and less than a week, got {self.length} s"
            )
        if both := {HEAD, HAPPENINGS} & set(self.house):
            raise ConfigError(self.source, min(both), "is not a table of a house")
        devices = self.world().devices
        for number, event in enumerate(self.happenings):
            key = f"{HAPPENINGS}.{number}"
            if not self.start <= event.at <= self.end:
                day = f"{write_time(self.start)} to {write_time(self.end)}"
                raise ConfigError(self.source, f"{key}.at", f"{write_time(event.at)} is not in the day, {day}")
            if event.device and event.device not in devices:
                raise ConfigError(self.source, f"{key}.device", f"there is no device {event.device!r}")


class _Printer(Protocol):
    def text(self, text: str, /) -> None: ...


class _Own(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    day: Table = Field(default_factory=dict)
    happenings: list[Table] = Field(default_factory=list)


class _Head(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    start: str = "00:00"
    length: str | float = "24h"
