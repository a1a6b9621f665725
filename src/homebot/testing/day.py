"""A day in a house as plain data, the house and its events, which can be saved as TOML and replayed.

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
from homebot.testing.day_event import MAX_DAY_S, DayEvent, read_time, write_duration, write_tables, write_time
from homebot.units import parse_duration

if TYPE_CHECKING:
    from homebot.testing.virtual_house import VirtualHouse

HAPPENINGS = "happenings"
HEAD = "day"


@dataclass(frozen=True, repr=False)
class Day:
    """A house and its events on one day.

    Attributes:
        house: The tables that describe it, for :func:`homebot.house.description.parse_world`; not to be modified.
        happenings: The events in order of time; simultaneous ones in the given order.
        start: Start in seconds after midnight, below 24 hours. Earlier events of the house itself also happen.
        length: Duration in seconds; it ends within a week after the midnight.

    Raises:
        ConfigError: The house is invalid, or an event is outside the day or of an unknown device.
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
        """Its end, in seconds after midnight."""
        return round(self.start + self.length, 3)

    @classmethod
    def load(cls, path: str | Path) -> Day:
        """Return the day saved in *path*; without events if the file only describes a house.

        Raises:
            ConfigError: The file cannot be read or is no TOML, or a key or value is wrong; names file, key and reason.
        """
        return cls._from_tables(read_toml(Path(path), any_text=True), str(path))

    @classmethod
    def parse(cls, text: str, source: str = "day") -> Day:
        """Parse a day from *text*; errors name *source*.

        Raises:
            ConfigError: As :meth:`load`.
        """
        return cls._from_tables(parse_toml(text, source, any_text=True), source)

    def save(self, path: str | Path) -> None:
        """Save it to *path* for :meth:`load`, creating directories as needed.

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
        """Return the text of its file."""
        head = {"start": write_time(self.start), "length": write_duration(self.length)}
        happenings = [happening.table() for happening in self.happenings]
        return write_tables({HEAD: head, **self.house} | ({HAPPENINGS: happenings} if happenings else {}))

    def __repr__(self) -> str:
        """Return a Python expression that creates it, for ``@example``."""
        text = str(self)
        return f"Day.parse({text!r})" if "\\" in text or '"""' in text else f'Day.parse("""\n{text}""")'

    def _repr_pretty_(self, printer: _Printer, cycle: bool) -> None:  # noqa: FBT001 - IPython's protocol
        """Show that expression in failing examples of Hypothesis too."""
        del cycle
        printer.text(repr(self))

    def world(self, *, seed: int | None = None) -> World:
        """Return its house at midnight; *seed* overrides the house's own."""
        return parse_world(self.house, self.source, seed=seed)

    def play(self, world: World | None = None) -> WorldLog:
        """Play the day without a network, in a few milliseconds.

        Events on the network (``cut``, ``pull``, ``restart``) have no effect.

        Args:
            world: The house to use; by default a new one.

        Returns:
            All events in the house since midnight; identical each time.

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
        """Play the day on the network, in virtual time.

        Args:
            house: A house with this day's :meth:`world`, on its first day and not after the start.

        Returns:
            Events without effect: a command while the broker was away, a cut of a link that was down.

        Raises:
            UsageError: The house is past the start of this day, or lacks a device.
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
        if not 0.0 < self.length <= MAX_DAY_S - self.start:
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
