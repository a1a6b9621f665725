"""Simulated rooms with a sensor of 5 Hz; effects are shares of that of a lamp in view.

The sensor has white noise, and what it sees drifts; in three rooms of ten there is a cloud. Lamps are late, and fade;
those that are not in view reach the sensor as reflections.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, inf
from random import Random

from homebot.features.identify.belief import Seen
from homebot.features.identify.inquiry import STILL_LOOKS, Inquiry
from homebot.features.identify.sight import Noise

PERIOD = 0.2
SETTLES = 0.8
LOOK = 1.0
LIMIT = 60.0
DAYLIGHT = 5.0


@dataclass(frozen=True, slots=True)
class Rooms:
    """A kind of room; a room of it is drawn with a seed. The least effect may be unknown: 0."""

    count: int = 8
    noise: float = 0.25
    late: float = 0.4
    reflections: float = 0.2
    is_in_view: bool = True
    least: float = 0.45
    jump: float = 0.0
    twin: float = 0.0
    limit: float = inf
    step: float = 0.0
    effect: float = 1.0
    is_announced_twice: bool = False
    reports_commands: bool = False
    flicker: float = 0.0
    dwell: float = 0.0
    fade: float = 0.0


class Room:
    """One room."""

    def __init__(self, kind: Rooms, random: Random) -> None:
        self.kind = kind
        self.random = random
        self.target = random.randrange(kind.count) if kind.is_in_view else None
        self.effects = [random.uniform(0, kind.reflections) for _ in range(kind.count)]
        if self.target is not None:
            self.effects[self.target] = kind.effect
        if kind.twin and self.target is not None:
            self.effects[self.target - 1] = kind.twin
        self.fades = [random.uniform(0.05, 0.8) for _ in range(kind.count)]
        self.lates = [random.uniform(0, kind.late) for _ in range(kind.count)]
        self.cloud = (random.uniform(0, 40), random.uniform(-0.8, 0.8)) if random.random() < 0.3 else (1e9, 0.0)
        if kind.jump:  # another lamp, or the sun
            self.cloud = (random.uniform(0, 40), random.choice([-kind.jump, kind.jump]))
        self.now = self.base = 0.0
        self.told = self.before = self.shown = [random.random() < 0.5 for _ in range(kind.count)]
        if kind.is_announced_twice and self.target is not None:
            self.told[self.target - 1] = self.told[self.target]
        self.due = [0.0] * kind.count
        self.changed = [-60.0] * kind.count
        self.levels = [float(is_on) for is_on in self.told]
        self.flicker = 0.0
        self.disobeyed = set[int]()

    def set(self, code: Sequence[bool], fades_on: float) -> None:
        """Set the lamps, and wait until the last one has reported and faded."""
        self.before, last, self.shown, self.told = self.told, self.shown, list(code), list(code)
        if self.kind.is_announced_twice and self.target is not None:  # one relay does what came last
            pair = [self.target - 1, self.target]
            changed = [
                place for place in pair if place % self.kind.count not in self.disobeyed and code[place] != last[place]
            ]
            is_on = code[self.random.choice(changed)] if changed else self.before[self.target]
            self.told[pair[0]] = self.told[pair[1]] = is_on
            if not self.kind.reports_commands:
                self.disobeyed |= {place % self.kind.count for place in changed if code[place] != is_on}
                self.shown = self.told
        moved = [place for place, one in enumerate(self.told) if one != self.before[place]]
        self.due = [self.now + late for late in self.lates]
        for place, (old, new) in enumerate(zip(last, self.shown, strict=True)):
            self.changed[place] = self.due[place] if old != new else self.changed[place]
        self.pass_time(max((self.lates[one] for one in moved), default=0.0) + SETTLES + fades_on)

    def pass_time(self, seconds: float) -> list[float]:
        """Return what the sensor sees meanwhile."""
        values, end = [], self.now + seconds - 1e-9
        if self.kind.flicker and not self.kind.dwell:
            self.flicker = self.random.choice((0.0, self.kind.flicker))
        while self.now < end:
            self.now += PERIOD
            if self.kind.dwell and self.random.random() < PERIOD / self.kind.dwell:
                self.flicker = self.kind.flicker - self.flicker
            self.base += self.random.gauss(0, 0.02)
            for place, fade in enumerate(self.fades):
                is_on = (self.told if self.now >= self.due[place] else self.before)[place]
                missing = is_on - self.levels[place]
                evenly = PERIOD / self.kind.fade if self.kind.fade else 0.0
                self.levels[place] += (
                    max(-evenly, min(evenly, missing)) if evenly else missing * (1 - exp(-PERIOD / fade))
                )
            at, jump = self.cloud
            lamps = sum(effect * level for effect, level in zip(self.effects, self.levels, strict=True))
            base = DAYLIGHT + self.base + (jump if self.now > at else 0.0) + self.flicker
            value = min(base + lamps + self.random.gauss(0, self.kind.noise), self.kind.limit)
            values.append(round(value / self.kind.step) * self.kind.step if self.kind.step else value)
        return values


@dataclass(frozen=True, slots=True)
class Found:
    """The end of one identification: whether it is right, wrong with certainty, or neither, and the seconds."""

    is_right: bool
    is_wrong: bool
    seconds: float


def identify(kind: Rooms, seed: int) -> Found:
    """Identify the lamp in one room."""
    random = Random(seed)  # noqa: S311 - a simulation
    room = Room(kind, random)
    look = Looks(room)
    inquiry = Inquiry(kind.count, kind.least, 0.99, random)
    for _ in range(STILL_LOOKS):
        inquiry.add(look())
    for code in inquiry.codes():
        if code is not None:
            room.set(code, inquiry.fades_on)
        for place in room.disobeyed:
            inquiry.drop(place)
        inquiry.add(look(), look.noise.trouble)
        if room.now > LIMIT:
            break
    is_found = inquiry.found == room.target
    return Found(inquiry.is_sure and is_found, inquiry.is_sure and not is_found, room.now)


class Looks:
    """What looks at a room for a second."""

    def __init__(self, room: Room) -> None:
        self.noise = Noise()
        self._room = room
        self._last = 0.0

    def __call__(self) -> Seen:
        mean, variance = self.noise.of(self._room.pass_time(LOOK))
        passed, self._last = self._room.now - self._last, self._room.now
        ages = tuple(self._room.now - LOOK / 2 - at for at in self._room.changed)
        return Seen(tuple(map(float, self._room.shown)), mean, variance, passed, ages)
