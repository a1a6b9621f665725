"""What is promised of a habit comes, also where people do it seldom, or give it up."""

import os
import subprocess
import sys
from dataclasses import dataclass, replace
from random import Random

import pytest
from tests.features.habits.family import HABITS, Family, Planted, days_of
from tests.sizes import size

from homebot.features.habits.days import DAY
from homebot.features.habits.habit import TriedHabit
from homebot.features.habits.search import occasions_of
from homebot.features.habits.trial import try_habits

HOLIDAYS, GUESTS = range(9, 12), range(16, 18)
KNOWN, LATER = 28, 21
"""Days until a habit is proposed, and after that."""

FAMILIES = {"one share": 0.05, "own shares": 0.05, "fading": 0.1}
"""How far the promise may be off: nobody knows which habit is given up next."""


class LiveFamily(Family):
    """A family whose members do each habit with a share of their own, and give up some of them within months."""

    def __init__(self, seed: int, kind: str) -> None:
        random = Random(seed)  # noqa: S311 - a simulation
        shares = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
        own = tuple(replace(habit, share=random.choice(shares)) for habit in HABITS)
        super().__init__(seed, HABITS if kind == "one share" else own, holidays=HOLIDAYS, guests=GUESTS)
        given_up = (habit for habit in self.habits if random.random() < 0.5)
        self.given_up = {habit.do: random.randint(0, 30) for habit in given_up} if kind == "fading" else {}

    def _does(self, habit: Planted, day: int, at: float) -> bool:
        weeks = max(0, day - self.given_up.get(habit.do, day)) / 75
        return super()._does(replace(habit, share=habit.share * (1 - weeks)), day, at)


@dataclass(slots=True)
class Came:
    promised: float = 0.0
    occasions: int = 0
    done: int = 0
    kept: int = 0
    strong: int = 0


def came_of(kind: str) -> Came:
    """Return the promises of many families, and what came of them."""
    sums = Came()
    for seed in range(size(8, 40)):
        family = LiveFamily(seed, kind)
        events = family.days(KNOWN + LATER).events
        later = days_of([one for one in events if one.at >= KNOWN * DAY], HOLIDAYS)
        known = days_of([one for one in events if one.at < KNOWN * DAY], HOLIDAYS)
        habits = [habit for habit in try_habits(known) if isinstance(habit, TriedHabit)]
        strong = {habit.do for habit in family.habits if habit.share >= 0.8 and habit.do not in family.given_up}
        sums.strong += len(strong)
        sums.kept += len(strong & {habit.found.do for habit in habits})
        for habit in habits:
            occasions = occasions_of(later, habit.found) if habit.found.do in later.by_text else ()
            sums.promised += habit.precision * len(occasions)
            sums.occasions += len(occasions)
            sums.done += sum(occasion.done_at is not None for occasion in occasions)
    return sums


@pytest.mark.parametrize(("kind", "off"), FAMILIES.items())
def test_what_is_promised_comes(kind: str, off: float) -> None:
    sums = came_of(kind)
    assert sums.occasions > 100
    assert sums.promised / sums.occasions == pytest.approx(sums.done / sums.occasions, abs=off)
    assert sums.kept >= 0.75 * sums.strong


def test_a_habit_of_this_week_is_watched() -> None:
    days = days_of(Family(1).days(12).events)
    kinds = [type(habit).__name__ for habit in try_habits(days) if habit is not None]
    assert "FoundHabit" in kinds


def test_habits_do_not_depend_on_the_hash_of_texts() -> None:
    code = (
        "from tests.features.habits.family import Family\n"
        "from homebot.features.habits.trial import try_habits\n"
        "print([habit for habit in try_habits(Family(3).days(28)) if habit])"
    )
    run = [sys.executable, "-c", code]
    answers = {
        subprocess.run(run, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, check=True).stdout
        for seed in ("1", "2", "3")
    }
    assert len(answers) == 1
