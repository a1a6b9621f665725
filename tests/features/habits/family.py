"""Recorded days of a simulated family: motion, doors, lamps that people switch without any rule, and planted habits."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, pi
from random import Random

from homebot.features.habits.days import DAY, Days, Happening

ROOMS = ("hall", "kitchen", "living", "bedroom", "bath", "nursery", "office", "cellar", "attic", "garage")
LAMPS = tuple(f"{room} {kind}" for room in ROOMS for kind in ("lamp", "desk light", "strip"))


@dataclass(frozen=True, slots=True)
class Planted:
    """One habit: after *when* (or at an hour of the day), people mostly do *do*."""

    when: str
    do: str
    share: float = 0.92
    dark: bool | None = None
    workdays: bool | None = None
    late: float = 40.0

    @property
    def hour(self) -> float | None:
        return float(self.when) if self.when.replace(".", "").isdigit() else None


HABITS = (
    Planted("hall motion occupied", "hall lamp on", dark=True),
    Planted("kitchen door open", "pantry light on"),
    Planted("tv on", "living lamp off", dark=True),
    Planted("6.75", "coffee machine on", workdays=True),
    Planted("22.75", "bedroom blind closed"),
    Planted("hall button single pressed", "office lamp on", late=5),
    Planted("Anna arrives", "kitchen lamp on", workdays=True),
    Planted("everybody has left", "heating eco", late=120),
    Planted("bath window open", "bath radiator off", late=100),
    Planted("washer done", "washer plug off", late=600),
    Planted("sunset", "garden lamp on", late=300),
    Planted("nursery door closed", "nursery lamp off", dark=True),
)


def sun_is_down(at: float) -> bool:
    hour = at % DAY / 3600
    return not 8 <= hour < sunset_hour(at)


def sunset_hour(at: float) -> float:
    return 17.5 + 1.0 * cos(2 * pi * (at // DAY) / 60)


def is_workday(at: float) -> bool:
    return (at // DAY) % 7 < 5


class Family:
    """Days of the family.

    Args:
        habits: Those that are planted; one is changed by :attr:`changed` on a day.
        holidays: Days on which nothing happens.
        guests: Days on which three times as much happens, and habits are forgotten more often.
        bustle: How many times as much happens on all days.
    """

    def __init__(
        self,
        seed: int,
        habits: tuple[Planted, ...] = HABITS,
        holidays: range = range(0),
        guests: range = range(0),
        bustle: int = 1,
    ) -> None:
        self.random = Random(seed)  # noqa: S311 - a simulation
        self.habits = habits
        self.holidays = holidays
        self.guests = guests
        self.bustle = bustle
        self.changed: tuple[int, Planted, Planted] | None = None
        self.values: dict[str, str] = {}
        self.events: list[Happening] = []

    def days(self, count: int) -> Days:
        for day in range(count):
            self._live(day)
        self.events.sort(key=lambda one: one.at)
        return days_of(self.events, self.holidays)

    def _live(self, day: int) -> None:
        plan = list(self._background(day))
        plan += [event for habit in self._habits(day) if (event := self._timed(day, habit)) is not None]
        plan.sort()
        for at, text, by_person in plan:
            self._happen(day, at, text, by_person=by_person)

    def _habits(self, day: int) -> list[Planted]:
        habits = list(self.habits)
        if self.changed is not None and day >= self.changed[0]:
            habits[habits.index(self.changed[1])] = self.changed[2]
        return habits

    def _background(self, day: int) -> Iterator[tuple[float, str, bool]]:
        """Yield what happens without a rule: mostly between 6:30 and 23:30."""
        random, midnight = self.random, day * DAY
        if day in self.holidays:
            return

        def times(most: int) -> list[float]:
            most *= self.bustle * (3 if day in self.guests else 1)
            return [midnight + random.uniform(6.5, 23.5) * 3600 for _ in range(random.randint(0, most))]

        yield from self._devices(times)
        for hour in (random.uniform(8, 9), random.uniform(13, 15)):
            yield midnight + hour * 3600, "everybody has left", False
        for hour in (random.uniform(11, 12), random.uniform(16.5, 19)):
            yield midnight + hour * 3600, "Anna arrives", False
        if self.habits:
            yield from self._rhythm(midnight)

    def _devices(self, times: Callable[[int], list[float]]) -> Iterator[tuple[float, str, bool]]:
        random = self.random
        for room in ROOMS:
            for at in times(30):
                yield at, f"{room} motion occupied", False
                yield at + random.uniform(30, 300), f"{room} motion clear", False
            for at in times(8):
                yield at, f"{room} door open", False
                yield at + random.uniform(5, 900), f"{room} door closed", False
            for at in times(3):
                yield at, f"{room} window open", False
                yield at + random.uniform(300, 3000), f"{room} window closed", False
        for lamp in LAMPS:
            for at in times(2):
                yield at, f"{lamp} {random.choice(('on', 'off'))}", True
        for thing, values in {"tv": ("on", "off"), "washer": ("running", "done")}.items():
            for at in times(3):
                yield at, f"{thing} {values[0]}", True
                yield at + random.uniform(1800, 7000), f"{thing} {values[1]}", False
        for at in times(4):
            yield at, "hall button single pressed", False

    def _rhythm(self, midnight: float) -> Iterator[tuple[float, str, bool]]:
        """Yield what people do about once a day, at other times, so that the habits have something to do."""
        random = self.random
        for text in ("bedroom blind open", "garden lamp off", "coffee machine off", "heating comfort"):
            yield midnight + random.uniform(9.5, 11) * 3600, text, True
        for text, hour in {"kitchen lamp off": 13, "living lamp on": 17, "nursery lamp on": 18, "tv on": 20}.items():
            yield midnight + (hour + random.uniform(0, 3)) * 3600, text, True
        for text in ("pantry light off", "bath radiator on", "washer plug on", "office lamp off", "hall lamp off"):
            for _ in range(3):
                yield midnight + random.uniform(6.5, 23.5) * 3600, text, True

    def _timed(self, day: int, habit: Planted) -> tuple[float, str, bool] | None:
        midnight = day * DAY
        if habit.when == "sunset":
            at = midnight + sunset_hour(midnight) * 3600 + self.random.gauss(0, habit.late)
        elif habit.hour is None:
            return None
        else:
            at = midnight + habit.hour * 3600 + self.random.gauss(0, 400)
        return (at, habit.do, True) if self._does(habit, day, at) else None

    def _does(self, habit: Planted, day: int, at: float) -> bool:
        return (
            day not in self.holidays
            and (habit.dark is None or habit.dark == sun_is_down(at))
            and (habit.workdays is None or habit.workdays == is_workday(at))
            and self.random.random() < habit.share - 0.1 * (day in self.guests)
        )

    def _happen(self, day: int, at: float, text: str, *, by_person: bool) -> None:
        place, _, value = text.rpartition(" ")
        is_press = value in {"pressed", "arrives", "left"}
        if self.values.get(place) == value and not is_press:
            return
        self.values[place] = value
        self.events.append(Happening(at, place, "value", text, text if by_person else "", is_press))
        for habit in self._habits(day):
            if habit.when == text and self._does(habit, day, at):
                self._happen(day, at + self.random.uniform(0.2, 1) * habit.late, habit.do, by_person=True)


def days_of(events: list[Happening], holidays: range = range(0)) -> Days:
    return Days(
        events,
        lambda at: at // DAY * DAY,
        {
            "sun is down": sun_is_down,
            "sun is up": lambda at: not sun_is_down(at),
            "on weekdays": is_workday,
            "on weekends": lambda at: not is_workday(at),
            "somebody is home": lambda at: at // DAY not in holidays,
        },
        {"sunset": lambda midnight: midnight + sunset_hour(midnight) * 3600},
    )
