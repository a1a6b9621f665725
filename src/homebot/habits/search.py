"""The search for habits in recorded days. Pure, and in slices: it yields after each that may take a few milliseconds.

For each step that people did on several days, everything that happened shortly before is a possible trigger, and so
are the time of day and the sun. The occasions of a trigger are those at which a routine would have acted; at most two
conditions narrow them. A deed as likely at the same time on other days is no habit: motion precedes everything.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from statistics import median
from typing import Final

from homebot.habits.days import DAY, Days, Happenings
from homebot.habits.habit import FoundHabit, Occasion, sure_share

__all__ = ["find_habits", "occasions_after"]

_WITHIN: Final = (60.0, 300.0, 900.0)
"""Seconds within which people act after a trigger."""

_TOLERANCE: Final = 1200.0
"""Seconds before and after a time of day within which people act."""

_ROUND: Final = 300.0
"""Times of day are whole multiples of it."""

_LEAST_DAYS: Final = 5
_LEAST_OF_DAYS: Final = 0.4
"""The share of days on which it is done at a time of day: it may be so already on the others."""

_LEAST_PRECISION: Final = 0.75
_LEAST_SURE: Final = 0.5
_LEAST_RECENT: Final = 0.5
_ABOVE_CHANCE: Final = 0.35
_RECENT: Final = 7
_FOLDS: Final = 3
_SIMPLER: Final = 0.02
_MOST_TRIGGERS: Final = 20
_MOST_TIMES: Final = 3
_MOST_PER_STEP: Final = 3
_SHIFTS: Final = (-2, -1, 1, 2)
_EARLIER_OR_LATER: Final = (-3 / 24, -1.5 / 24, 1.5 / 24, 3 / 24)


def find_habits(days: Days) -> Iterator[FoundHabit | None]:
    """Yield habits, and None after each slice of work."""
    changed: list[str] = []
    for text, done in days.by_text.items():
        found = 0
        for habit in _habits_of(days, done):
            found += habit is not None
            yield habit
        if not found:
            changed.append(text)
    recent = days.recent(len(days.midnights) // 2)
    for text in changed:
        if text in recent.by_text:
            yield from _habits_of(recent, recent.by_text[text])


def occasions_after(days: Days, habit: FoundHabit) -> tuple[Occasion, ...]:
    """Return the occasions of a habit that has an event as its trigger, in other days."""
    tried = _tried(days, days.by_text[habit.do], days.by_text[habit.when].times, habit.within)
    return tuple(one.occasion for one in tried if one.held.issuperset(habit.conditions))


@dataclass(frozen=True, slots=True)
class _Tried:
    """One moment of a trigger: the number of its day, the deed that followed, and the conditions that held."""

    occasion: Occasion
    day: int
    held: frozenset[str]


@dataclass(frozen=True, slots=True)
class _Rule:
    when: str
    tried: tuple[_Tried, ...]
    within: float
    by_chance: Callable[[], float]
    conditions: tuple[str, ...] = ()
    times: Sequence[float] = ()

    @property
    def occasions(self) -> Iterator[_Tried]:
        return (one for one in self.tried if one.held.issuperset(self.conditions))


def _habits_of(days: Days, done: Happenings) -> Iterator[FoundHabit | None]:
    """Yield the habits of one step: the best one, and then those that explain deeds that the ones before do not."""
    yield None
    if not done.step or len({days.midnight(at) for at in done.done}) < _LEAST_DAYS:
        return
    rules: list[_Rule] = []
    for rule in (*_after_events(days, done), *_at_times(days, done)):
        rules.append(rule)
        yield None
    left = set(done.done)
    for _ in range(_MOST_PER_STEP):
        best = _best(rules, days.conditions, left, range(len(days.midnights)))
        if best is None:
            return
        habit = _proved(rules, days, best, left, done)
        followed = {one.occasion.done_at for one in best.occasions}
        if habit is None or not followed & left:
            return
        yield habit
        left -= followed
        yield None


def _after_events(days: Days, done: Happenings) -> Iterator[_Rule]:
    """Yield the rules of frequent events before."""
    before: Counter[str] = Counter()
    for at in done.done:
        texts = {one.text for one in days.between(at - _WITHIN[-1], at) if one.device != done.device}
        before.update(texts)
    least = max(_LEAST_DAYS, 0.25 * len(done.done))
    common = [(text, count) for text, count in before.items() if count >= least]
    common.sort(key=lambda one: one[1] / len(days.by_text[one[0]].times) ** 0.5, reverse=True)
    for text, _ in common[:_MOST_TRIGGERS]:
        times = days.by_text[text].times
        within = _within(times, done)
        yield _Rule(text, _tried(days, done, times, within), within, partial(_chance, days, done, times, within))


def _within(times: Sequence[float], done: Happenings) -> float:
    """Return the shortest span within which most of the deeds follow."""
    followed = [len({at for time in times if (at := done.first(time, time + span)) is not None}) for span in _WITHIN]
    return next(span for span, count in zip(_WITHIN, followed, strict=True) if count >= 0.9 * followed[-1])


def _at_times(days: Days, done: Happenings) -> Iterator[_Rule]:
    """Yield the rules of the times of day, and of the sun, around which most of it is done."""
    for offset in _common_times([at - days.midnight(at) for at in done.done]):
        clock = f"{int(offset // 3600) % 24:02}:{int(offset // 60) % 60:02}"
        yield _timed(days, done, clock, [midnight + offset for midnight in days.midnights])
    for text, moment in days.moments.items():
        moments = [at for midnight in days.midnights if (at := moment(midnight)) is not None]
        if len(moments) < _LEAST_DAYS:
            continue
        gaps = [min((at - one for one in moments), key=abs) for at in done.done]
        near = [gap for gap in gaps if abs(gap) <= 3600]
        if len(near) >= _LEAST_DAYS:
            shift = round(median(near) / _ROUND) * _ROUND
            sign = "" if not shift else f" {'+' if shift > 0 else '-'} {abs(shift) / 60:g}m"
            yield _timed(days, done, text + sign, [at + shift for at in moments])


def _common_times(offsets: Sequence[float]) -> Iterable[float]:
    """Return the times of day around which most is done, rounded: two for a deed of twice a day."""
    hours = Counter(round(one / 3600) for one in offsets)
    near = ([one for one in offsets if abs(one - hour * 3600) <= 3600] for hour, _ in hours.most_common(_MOST_TIMES))
    return dict.fromkeys(round(median(one) / _ROUND) * _ROUND for one in near)


def _timed(days: Days, done: Happenings, text: str, times: Sequence[float]) -> _Rule:
    begins, ends = days.events[0].at, days.events[-1].at - _TOLERANCE
    times = [at for at in times if begins <= at <= ends]
    tried = _tried(days, done, [at - _TOLERANCE for at in times], 2 * _TOLERANCE)
    moved = [
        replace(one, occasion=replace(one.occasion, at=one.occasion.at + _TOLERANCE), held=days.held(at))
        for one in tried
        if (at := one.occasion.at + _TOLERANCE)
    ]
    begun = [at - _TOLERANCE for at in times]
    chance = partial(_chance, days, done, begun, 2 * _TOLERANCE, _EARLIER_OR_LATER)
    return _Rule(text, tuple(moved), _TOLERANCE, chance, times=times)


def _tried(days: Days, done: Happenings, times: Iterable[float], within: float) -> tuple[_Tried, ...]:
    """Return the moments at which a routine would have acted: not again soon, nor where it is so already."""
    tried: list[_Tried] = []
    last = float("-inf")
    for at in times:
        if at < last + within or days.is_so(done, at):
            continue
        last = at
        tried.append(_Tried(Occasion(at, done.first(at, at + within)), days.number(at), days.held(at)))
    return tuple(tried)


def _chance(
    days: Days, done: Happenings, times: Sequence[float], within: float, shifts: Sequence[float] = _SHIFTS
) -> float:
    """Return how often it is done after other times, such as those of other days."""
    shifted = (_share(_tried(days, done, [at + shift * DAY for at in times], within)) for shift in shifts)
    return max(shifted)


def _share(tried: Sequence[_Tried]) -> float:
    return sum(one.occasion.done_at is not None for one in tried) / len(tried) if tried else 0.0


def _best(rules: Iterable[_Rule], conditions: Iterable[str], left: set[float], chosen: Iterable[int]) -> _Rule | None:
    """Return the rule, with at most two conditions, that is best on the *chosen* days; None if none is any good."""
    best, most = None, 0.0
    numbers, conditions = frozenset(chosen), tuple(conditions)
    combined = [(), *((one,) for one in conditions), *combinations(conditions, 2)]
    for rule in rules:
        own = [one for one in rule.tried if one.day in numbers]
        for chosen_conditions in combined:
            score = _score(own, chosen_conditions, left)
            if score > most + _SIMPLER * (1 + len(chosen_conditions)):
                best, most = replace(rule, conditions=chosen_conditions), score
    return best


def _score(tried: Sequence[_Tried], conditions: tuple[str, ...], left: set[float]) -> float:
    own = [one.occasion for one in tried if one.held.issuperset(conditions)]
    followed = {one.done_at for one in own if one.done_at is not None}
    new = len(followed & left)
    if new < _LEAST_DAYS * (_FOLDS - 1) // _FOLDS:
        return 0.0
    sure = sure_share(len(followed), len(own))
    return sure + 0.3 * new / len(left) if sure >= _LEAST_SURE * 0.8 else 0.0


def _proved(rules: Sequence[_Rule], days: Days, best: _Rule, left: set[float], done: Happenings) -> FoundHabit | None:
    """Return the habit if it holds on days that were not used to find it; None otherwise."""
    occasions = tuple(one.occasion for one in best.occasions)
    hits = [one for one in best.occasions if one.occasion.done_at is not None]
    numbers = range(len(days.midnights))
    recent = [one for one in best.occasions if one.day >= len(numbers) - _RECENT]
    precision = _share([*_held_out(rules, days, left)])
    usual = sum(days.held(at).issuperset(best.conditions) for at in best.times)
    is_habit = (
        len({one.day for one in hits}) >= max(_LEAST_DAYS, _LEAST_OF_DAYS * usual)
        and sure_share(len(hits), len(occasions)) >= _LEAST_SURE
        and precision >= max(_LEAST_PRECISION, best.by_chance() + _ABOVE_CHANCE)
        and _share(recent) >= _LEAST_RECENT
    )
    if not is_habit:
        return None
    recall = len({one.occasion.done_at for one in hits}) / len(done.done)
    return FoundHabit(best.when, best.conditions, done.step, done.device, best.within, occasions, precision, recall)


def _held_out(rules: Sequence[_Rule], days: Days, left: set[float]) -> Iterator[_Tried]:
    """Yield the occasions of each third of the days, by the best rule of the others."""
    for fold in range(_FOLDS):
        known = [one for one in range(len(days.midnights)) if one % _FOLDS != fold]
        found = _best(rules, days.conditions, {at for at in left if days.number(at) in known}, known)
        yield from () if found is None else (one for one in found.occasions if one.day % _FOLDS == fold)
