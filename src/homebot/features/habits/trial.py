"""The trial of habits: a week in which they are only watched, before they are proposed. Pure, and in slices.

A search finds, among all that it tries, habits that look better than they are, and some that people are giving up. The
days of the trial were not used to find them.
"""

from collections.abc import Iterator
from typing import Final

from homebot.features.habits.days import DAY, Days
from homebot.features.habits.habit import FoundHabit, TriedHabit
from homebot.features.habits.search import find_habits, occasions_of

TRIAL_DAYS: Final = 7
_MIN_SHARE: Final = 0.65
"""The share of the occasions of the trial, and of those to expect."""


def try_habits(days: Days) -> Iterator[TriedHabit | FoundHabit | None]:
    """Yield habits after a trial that they stood, those still on trial, and None after each slice of work."""
    if not days.events:
        return
    begin = days.events[-1].at - TRIAL_DAYS * DAY
    tried: set[str] = set()
    for habit in find_habits(days.until(begin)):
        yield None
        if habit is None:
            continue
        tried.add(habit.do)
        trial = TriedHabit(habit, tuple(occasion for occasion in occasions_of(days, habit) if occasion.at >= begin))
        if trial.done >= max(1, _MIN_SHARE * len(trial.trial)) and trial.precision >= _MIN_SHARE:
            yield trial
    for habit in find_habits(days):
        yield None if habit is None or habit.do in tried else habit
