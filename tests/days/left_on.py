"""Prints how well apps turn off lamps that burn for nobody: ``python -m tests.days.left_on --days 3``.

The family home, whose people leave every lamp on. They move all the time, or sit still: then they move for 20 s when
they come in, and again after so many seconds. Only rooms with a sensor count, as no app knows of others;
with radars, only theirs.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any, Final, Literal, NamedTuple, TypeAlias

from homebot.apps.lights_out import LightsOutSettings
from homebot.control.policies.presence_guard import PresenceGuardSettings
from homebot.house import World
from homebot.house.description import parse_world
from homebot.house.devices import SimulatedLamp
from homebot.house.event_log import Event, WorldLog
from homebot.house.faults import unwrap
from homebot.house.rooms import DAY
from homebot.house.sensors import MotionSensor, PresenceSensor
from homebot.log import configure_logging
from homebot.testing import VirtualTimeLoop, virtual_house_of

HOUSE: Final = Path(__file__).parents[2] / "examples" / "houses" / "family.toml"
STILL: Final = (0.0, 1200.0, 1500.0, 3000.0)
"""Seconds for which the people of each family sit still."""

SEATS: Final = ("bath", "kitchen", "living")
"""The rooms in which people sit; some families have radars there, in place of motion sensors or beside them."""

LONG: Final = 1800.0
"""Seconds without anybody awake after which a lamp should have been turned off."""

_OFF: Final = frozenset({"off", "0"})
_HEADINGS: Final = ("people", "app and guard", "offs", "precision", "left on", "recall", "delay", "hours burnt")


@dataclass
class Absence:
    """A time in which nobody was awake in the room of a lamp that was on when it began.

    Attributes:
        began: Seconds since the first midnight.
        ended: The same; infinite if it lasted to the end.
        off_at: The time at which an app turned the lamp off; infinite for never.
    """

    began: float
    ended: float = float("inf")
    off_at: float = float("inf")


@dataclass
class Score:
    """Counts of one or more days.

    Attributes:
        right: Off commands to lamps that were on, with nobody awake in the room.
        wrong: The same with somebody awake.
        delays: Seconds until an app turned the lamp off, for each long absence in which one did.
        missed: Long absences in which no app did.
        burnt: Seconds for which lamps burnt for nobody.
    """

    right: int = 0
    wrong: int = 0
    delays: list[float] = field(default_factory=list)
    missed: int = 0
    burnt: float = 0.0

    @property
    def precision(self) -> float:
        """Share of the off commands that hit nobody; 1 without any."""
        return self.right / (self.right + self.wrong) if self.right + self.wrong else 1.0

    @property
    def recall(self) -> float:
        """Share of the long absences in which an app turned the lamp off; 1 without any."""
        return len(self.delays) / (len(self.delays) + self.missed) if self.delays or self.missed else 1.0

    def add(self, other: Score) -> None:
        """Add the counts of *other* days."""
        self.right += other.right
        self.wrong += other.wrong
        self.delays += other.delays
        self.missed += other.missed
        self.burnt += other.burnt


class LampWatch(WorldLog):
    """Log of a house that keeps when each lamp burns for nobody.

    Args:
        world: The house, before its first day.
    """

    def __init__(self, world: World) -> None:
        super().__init__()
        self._world = world
        sensors = [one for one in world.devices.values() if isinstance(unwrap(one.device), MotionSensor)]
        radars = [one for one in sensors if isinstance(unwrap(one.device), PresenceSensor)]
        seen = {one.room for one in radars or sensors}
        self._lamps = {
            name: (placed.room, real)
            for name, placed in world.devices.items()
            if isinstance(real := unwrap(placed.device), SimulatedLamp) and placed.room in seen
        }
        self._was_on = dict.fromkeys(self._lamps, False)
        self._open: dict[str, Absence] = {}
        self._burns_since: dict[str, float] = {}
        self._absences: list[Absence] = []
        self.score = Score()

    def add(self, event: Event) -> None:
        """Write *event* down, and look at all lamps."""
        super().add(event)
        if event.verb == "told" and event.what in _OFF and self._was_on.get(event.who):
            self._count_off(event)
        for name, (room, lamp) in self._lamps.items():
            self._look(name, room, event.at, is_on=lamp.state() not in _OFF)

    def finish(self, at: float) -> Score:
        """Return the score of the days until *at*."""
        for absence in self._absences:
            lasted = min(absence.ended, at) - absence.began
            if lasted >= LONG and absence.off_at <= min(absence.ended, at):
                self.score.delays.append(absence.off_at - absence.began)
            elif lasted >= LONG:
                self.score.missed += 1
        self.score.burnt += sum(at - since for since in self._burns_since.values())
        return self.score

    def _count_off(self, event: Event) -> None:
        room, _ = self._lamps[event.who]
        if self._world.awake_in(room):
            self.score.wrong += 1
            return
        self.score.right += 1
        if (absence := self._open.get(event.who)) is not None:
            absence.off_at = min(absence.off_at, event.at)

    def _look(self, name: str, room: str, now: float, *, is_on: bool) -> None:
        awake = bool(self._world.awake_in(room))
        if awake and (absence := self._open.pop(name, None)) is not None:
            absence.ended = now
        if is_on and not awake and name not in self._open:
            self._open[name] = Absence(now)
            self._absences.append(self._open[name])
        if is_on and not awake:
            self._burns_since.setdefault(name, now)
        elif (since := self._burns_since.pop(name, None)) is not None:
            self.score.burnt += now - since
        self._was_on[name] = is_on


class Family(NamedTuple):
    """A family of forgetful people.

    Attributes:
        still: Seconds for which they sit still.
        sensors: Those of the rooms where they sit. With presence sensors, only these rooms count.
    """

    still: float
    sensors: Sensors = "motion"

    def __str__(self) -> str:
        return f"still {self.still:,.0f} s{_SENSORS[self.sensors]}"


Sensors: TypeAlias = Literal["motion", "presence", "both"]
_SENSORS: Final[dict[Sensors, str]] = {"motion": "", "presence": ", radars", "both": ", radars beside PIR"}


def house_of(people: Family, seed: int) -> dict[str, Any]:
    """Return the tables of the home of *people*."""
    tables = tomllib.loads(HOUSE.read_text("utf-8"))
    tables["house"] |= {"seed": seed, "forgetful": True, "dialect": "homeassistant"}  # it announces rooms
    del tables["devices"]["robot"]  # it announces no room
    tables["errands"] = [errand for errand in tables["errands"] if errand["device"] != "robot"]
    for person in tables["people"].values():
        person["day"] = [habit | ({} if habit.get("asleep") else {"still": people.still}) for habit in person["day"]]
    for room in SEATS if people.sensors != "motion" else ():
        name = f"{room}_radar" if people.sensors == "both" else f"{room}_motion"
        tables["devices"][name] = {"kind": "presence", "room": room}
    return tables


def lived(tables: dict[str, Any], config: dict[str, Any], days: float = 1.0) -> Score:
    """Live so many days of a house with the apps and policies of *config*; return the score."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(_lived(tables, config, days))


async def _lived(tables: dict[str, Any], config: dict[str, Any], days: float) -> Score:
    world = parse_world(tables, "family.toml")
    watch = LampWatch(world)
    world.event_log = watch
    async with virtual_house_of(world=world, config=config) as house:
        await house.run_for(days * DAY)
    return watch.finish(days * DAY)


class Trial(NamedTuple):
    """Settings that are compared.

    Attributes:
        quiet_after: That of the app ``lights_out``.
        absent_after: That of the presence guard; 0 for no guard.
    """

    quiet_after: float
    absent_after: float

    @property
    def config(self) -> dict[str, Any]:
        """The configuration."""
        guard = {"presence_guard": {"absent_after": self.absent_after}} if self.absent_after else {}
        apps = {"lights_out": {"quiet_after": self.quiet_after}}
        return {"gateways": {"mqtt": {}}, "apps": apps, "control": guard}

    def __str__(self) -> str:
        guard = f"guard {self.absent_after / 60:g} min" if self.absent_after else "no guard"
        return f"lights_out {self.quiet_after / 60:g} min, {guard}"


DEFAULTS: Final = Trial(LightsOutSettings().quiet_after, PresenceGuardSettings().absent_after.motion)

TRIALS: Final = (
    *(Trial(quiet_after, 0.0) for quiet_after in (300.0, 600.0, 900.0, 1200.0, 1800.0)),
    *(Trial(60.0, absent_after) for absent_after in (300.0, 600.0, 1200.0)),
    DEFAULTS,
)
"""The app by itself, the guard by an app that would turn lamps off after a minute, and the defaults of both."""


FAMILIES: Final = tuple(Family(still, sensors) for sensors in _SENSORS for still in STILL)


def scored(
    days: int, trials: tuple[Trial, ...] = TRIALS, families: tuple[Family, ...] = FAMILIES
) -> Iterator[tuple[Family, Trial, Score]]:
    """Yield the score of each family and trial, over so many days with different random numbers."""
    for people in families:
        for trial in trials:
            score = Score()
            for seed in range(1, days + 1):
                score.add(lived(house_of(people, seed), trial.config))
            yield people, trial, score


def row(people: Family, trial: Trial, score: Score) -> tuple[str, ...]:
    """Return a row of the table."""
    delay = f"{median(score.delays) / 60:.0f} min" if score.delays else "-"
    return (
        str(people),
        str(trial),
        f"{score.right + score.wrong:,}",
        f"{score.precision:.1%}",
        f"{len(score.delays) + score.missed:,}",
        f"{score.recall:.1%}",
        delay,
        f"{score.burnt / 3600:.1f}",
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--days", type=int, default=3)
    parser.add_argument("--defaults", action="store_true", help="only the defaults")
    options = parser.parse_args()
    configure_logging(level="error")
    print("| " + " | ".join(_HEADINGS) + " |")
    print("|" + "---|" * len(_HEADINGS))
    for found in scored(options.days, (DEFAULTS,) if options.defaults else TRIALS):
        print("| " + " | ".join(row(*found)) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
