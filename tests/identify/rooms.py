"""Simulated rooms with a sensor of 5 Hz; effects are shares of that of a lamp in view.

The sensor has white noise, and what it sees drifts; in three rooms of ten there is a cloud. Lamps are late, and fade;
those that are not in view reach the sensor as reflections.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, inf
from random import Random

from homebot.identify.belief import Seen, begun, is_brightening, is_brighter
from homebot.identify.codes import next_code
from homebot.identify.conclusion import Conclusion
from homebot.identify.sight import Noise

PERIOD = 0.2
SETTLES = 0.8
LOOK = 1.0
MOST_SLOTS = 24
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
    flicker: float = 0.0


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
        self.told = self.before = self.shown = [False] * kind.count
        self.due = [0.0] * kind.count
        self.levels = [0.0] * kind.count
        self.fades_on = 0.0
        self.disobeyed = set[int]()

    def set(self, code: Sequence[bool]) -> None:
        """Set the lamps, and wait until the last one has reported and faded."""
        self.before, last, self.shown, self.told = self.told, self.shown, list(code), list(code)
        if self.kind.is_announced_twice and self.target is not None:  # one relay does what came last
            pair = [self.target - 1, self.target]
            new = [one for one in pair if one % self.kind.count not in self.disobeyed and code[one] != last[one]]
            is_on = code[self.random.choice(new)] if new else self.before[self.target]
            self.disobeyed |= {one % self.kind.count for one in new if code[one] != is_on}
            self.told[pair[0]] = self.told[pair[1]] = is_on
            self.shown = self.told
        changed = [place for place, one in enumerate(self.told) if one != self.before[place]]
        self.due = [self.now + late for late in self.lates]
        self.pass_time(max((self.lates[one] for one in changed), default=0.0) + SETTLES + self.fades_on)

    def pass_time(self, seconds: float) -> list[float]:
        """Return what the sensor sees meanwhile."""
        values, end = [], self.now + seconds - 1e-9
        self.flicker = self.random.choice((0.0, self.kind.flicker)) if self.kind.flicker else 0.0
        while self.now < end:
            self.now += PERIOD
            self.base += self.random.gauss(0, 0.02)
            for place, fade in enumerate(self.fades):
                is_on = (self.told if self.now >= self.due[place] else self.before)[place]
                self.levels[place] += (is_on - self.levels[place]) * (1 - exp(-PERIOD / fade))
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
    room.set([False] * kind.count)
    first = look()
    room.set([True] * kind.count)
    bright = [look()]
    while is_brightening(bright):
        bright.append(look())
    if is_brighter(bright):
        room.fades_on = LOOK * (len(bright) - 1)
        bright = bright[-1:]
    belief, conclusion = begun(first, bright[0], kind.least), Conclusion(0.99)
    for seen in bright[1:]:
        belief.add(seen)
    for _ in range(MOST_SLOTS):
        room.set(next_code(belief, random))
        for place in room.disobeyed:
            belief.drop(place)
        belief.add(look())
        if conclusion.add(belief, look.noise.trouble):
            return Found(conclusion.found == room.target, conclusion.found != room.target, room.now)
    return Found(is_right=False, is_wrong=False, seconds=room.now)


class Looks:
    """What looks at a room for a second."""

    def __init__(self, room: Room) -> None:
        self.noise = Noise()
        self._room = room
        self._last = 0.0

    def __call__(self) -> Seen:
        mean, variance = self.noise.of(self._room.pass_time(LOOK))
        passed, self._last = self._room.now - self._last, self._room.now
        return Seen(tuple(map(float, self._room.shown)), mean, variance, passed)
