"""The search for habits in recorded days. Pure, and in slices: it yields after each that may take a few milliseconds.

For each step that people did on several days, everything that happened shortly before is a possible trigger, and so
are the time of day and the sun. The occasions of a trigger are those at which a routine would have acted; at most two
conditions narrow them. A deed as likely at the same time on other days is no habit: motion precedes everything.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from statistics import median
from typing import Final

from homebot.features.habits.days import DAY, MIN_DAYS, Days, EventSeries
from homebot.features.habits.habit import FoundHabit, Occasion, p_value, wilson_lower_bound

_WITHIN: Final = (60.0, 300.0, 900.0)
"""Seconds within which people act after a trigger."""

_REACTION: Final = 0.5
"""Seconds that a person needs; what follows sooner is an effect, such as that of a bound button."""

_PUNCTUAL: Final = 2.0
"""Seconds by which people are never punctual day after day, and within which they never do more after a press."""

_LONG_DELAY: Final = 30.0
"""Seconds after which people are never punctual, as after a door that they pass."""

_TOLERANCE: Final = 1200.0
"""Seconds before and after a time of day within which people act."""

_ROUND: Final = 300.0
"""Times of day are whole multiples of it."""

_MIN_OF_DAYS: Final = 0.4
"""The share of days on which it is done at a time of day: it may be so already on the others."""

_MIN_PRECISION: Final = 0.7
"""On days that were not used to find it: fewer than all, so of 12 days out of 16 they show less."""

_MIN_SURE: Final = 0.5
_MIN_RECENT: Final = 1 / 3
"""In the last days, which are few: what is done in 7 of 10 cases comes in 2 of 5 there by chance."""

_ABOVE_CHANCE: Final = 0.35
_MAX_LUCK: Final = 0.01
"""The probability that any proposal of a house without habits is mere p_value."""

_RECENT: Final = 7
_FOLDS: Final = 6
"""The rule of five sixths of the days is mostly that of all; that of two thirds is often none."""

_MIN_NEW: Final = MIN_DAYS * (_FOLDS - 1) // _FOLDS
_CONDITION_PENALTY: Final = 0.02
_LATENCY_PENALTY: Final = 0.05 / 900
"""Per second: of two triggers that are as good, the nearer one is the cause."""

_WORTH_A_LOOK: Final = 0.8 * _MIN_SURE
"""The sure share that scores; what is done less often does not reach it."""

_MAX_TRIGGERS: Final = 12
_MAX_TIMES: Final = 3
_MAX_CONDITIONS: Final = 2
_MAX_PER_STEP: Final = 3
_OTHER_DAYS: Final = (-2.0, -1.0, 1.0, 2.0)
_OTHER_HOURS: Final = (-3 / 24, -1.5 / 24, 1.5 / 24, 3 / 24)


def find_habits(days: Days) -> Iterator[FoundHabit | None]:
    """Yield habits, and None after each slice of work."""
    steps = list(_steps(days))
    unlikely = _MAX_LUCK / max(1, len(steps))  # each step is a try that p_value has
    changed: list[str] = []
    for done in steps:
        count = 0
        for habit in _habits_of(days, done, unlikely):
            count += habit is not None
            yield habit
        if not count:
            changed.append(done.text)
    recent = days.recent(len(days.midnights) // 2)
    for done in _steps(recent):
        if done.text in changed:
            yield from _habits_of(recent, done, unlikely)


def _steps(days: Days) -> Iterator[EventSeries]:
    """Yield what people did on several days."""
    for done in days.by_text.values():
        if done.step and len({days.midnight(at) for at in done.done}) >= MIN_DAYS:
            yield done


def occasions_of(days: Days, habit: FoundHabit) -> tuple[Occasion, ...]:
    """Return the occasions of a habit in other days, however seldom it is done there."""
    rule = _rule(days, days.by_text[habit.do], habit.when, habit.within, is_found=True)
    return tuple(case.occasion for case in replace(rule, conditions=habit.conditions).occasions)


@dataclass(frozen=True, slots=True)
class _Tried:
    """One moment of a trigger: the number of its day, the deed that followed, and the conditions that held."""

    occasion: Occasion
    day: int
    held: frozenset[str]


@dataclass(frozen=True, slots=True)
class _Rule:
    """A trigger, and the conditions that narrow it.

    Attributes:
        begins: The times from which people have *span* seconds to do it.
        late: Seconds by which the trigger is later than that; negative if it is earlier.
        shifts: Days by which these times are moved to see how often it is done by chance.
    """

    when: str
    begins: Sequence[float]
    span: float
    late: float
    shifts: Sequence[float]
    tried: tuple[_Tried, ...]
    conditions: tuple[str, ...] = ()

    @property
    def occasions(self) -> list[_Tried]:
        return [case for case in self.tried if case.held.issuperset(self.conditions)]


def _habits_of(days: Days, done: EventSeries, unlikely: float) -> Iterator[FoundHabit | None]:
    """Yield the habits of one step: the best one, and then those that explain deeds that the ones before do not."""
    rules: list[_Rule] = []
    for rule in (*_after_events(days, done), *_at_times(days, done)):
        rules.append(rule)
        yield None
    left = set(done.done)
    for _ in range(_MAX_PER_STEP):
        best = _best(rules, left, range(len(days.midnights)))
        yield None
        if best is None:
            return
        habit = _prove(rules, days, best, left, done, unlikely)
        followed = {case.occasion.done_at for case in best.occasions}
        if habit is None or len(followed & left) < MIN_DAYS:
            return
        yield habit
        left -= followed


def _after_events(days: Days, done: EventSeries) -> Iterator[_Rule]:
    """Yield the rules of frequent events before."""
    before: Counter[str] = Counter()
    for at in done.done:
        texts = {event.text for event in days.between(at - _WITHIN[-1], at) if event.device != done.device}
        before.update(texts)
    least = max(MIN_DAYS, 0.25 * len(done.done))
    common = [(text, count) for text, count in before.items() if count >= least]
    common.sort(key=lambda pair: (-pair[1] / len(days.by_text[pair[0]].times) ** 0.5, pair[0]))
    for text, _ in common[:_MAX_TRIGGERS]:
        yield _rule(days, done, text, _within(days.by_text[text].times, done))


def _within(times: Sequence[float], done: EventSeries) -> float:
    """Return the shortest span within which most of the deeds follow."""
    gaps = [at - times[place - 1] for at in done.done if (place := bisect_left(times, at))]
    followed = [sum(gap <= span for gap in gaps) for span in _WITHIN]
    return next(span for span, count in zip(_WITHIN, followed, strict=True) if count >= 0.9 * followed[-1])


def _at_times(days: Days, done: EventSeries) -> Iterator[_Rule]:
    """Yield the rules of the times of day, and of the sun, around which most of it is done."""
    for offset in _common_times([at - days.midnight(at) for at in done.done]):
        yield _rule(days, done, f"{int(offset // 3600) % 24:02}:{int(offset // 60) % 60:02}", _TOLERANCE)
    for text in days.moments:
        moments = days.moments_of(text)
        if len(moments) < MIN_DAYS:
            continue
        gaps = [min((at - moment for moment in moments), key=abs) for at in done.done]
        near = [gap for gap in gaps if abs(gap) <= 3600]
        if len(near) >= MIN_DAYS:
            shift = round(median(near) / _ROUND) * _ROUND
            sign = "" if not shift else f" {'+' if shift > 0 else '-'} {abs(shift) / 60:g}m"
            yield _rule(days, done, text + sign, _TOLERANCE)


def _common_times(offsets: Sequence[float]) -> Iterable[float]:
    """Return the times of day around which most is done, rounded: two for a deed of twice a day."""
    hours = Counter(round(offset / 3600) for offset in offsets)
    near = (
        [offset for offset in offsets if abs(offset - hour * 3600) <= 3600] for hour, _ in hours.most_common(_MAX_TIMES)
    )
    return dict.fromkeys(round(median(group) / _ROUND) * _ROUND for group in near)


def _rule(days: Days, done: EventSeries, when: str, within: float, *, is_found: bool = False) -> _Rule:
    """Return the rule of a trigger: people do it *within* so many seconds after it, or before and after a time.

    Nothing is tried of one that is not *found* yet and cannot score.
    """
    if when in days.by_text:
        begins = [at + _REACTION for at in days.by_text[when].times]
        span, late, shifts = within - _REACTION, -_REACTION, _OTHER_DAYS
    else:
        first, last = days.events[0].at, days.events[-1].at - within
        begins = [at - within for at in days.moments_of(when) if first <= at <= last]
        span, late, shifts = 2 * within, within, _OTHER_HOURS
    occasions = _occasions(days, done, begins, span, late)
    tried = _try_rules(days, done, occasions) if is_found or _is_worth_a_look(days, done, occasions) else ()
    return _Rule(when, begins, span, late, shifts, tried)


def _is_worth_a_look(days: Days, done: EventSeries, occasions: Iterable[Occasion]) -> bool:
    """Return whether it is done often enough to score: always, or where one condition holds."""
    hits = [occasion.at for occasion in occasions if occasion.done_at is not None]
    others = [occasion.at for occasion in occasions if occasion.done_at is None]
    for holds in (lambda _: True, *days.conditions_on(done.device).values()):
        count = sum(map(holds, hits))
        most = int(count / _WORTH_A_LOOK) - count
        if count >= _MIN_NEW and len([*islice(filter(holds, others), most + 1)]) <= most:
            return True
    return False


def _occasions(days: Days, done: EventSeries, begins: Iterable[float], span: float, late: float) -> list[Occasion]:
    """Return when a routine would have acted: not again soon, nor where it is so already."""
    occasions: list[Occasion] = []
    last = float("-inf")
    for begin in begins:
        if begin >= last + span and not days.is_so(done, begin):
            last = begin
            occasions.append(Occasion(begin + late, done.first(begin, begin + span)))
    return occasions


def _try_rules(days: Days, done: EventSeries, occasions: Iterable[Occasion]) -> tuple[_Tried, ...]:
    conditions = days.conditions_on(done.device).items()
    return tuple(
        _Tried(occasion, days.number(occasion.at), frozenset(text for text, holds in conditions if holds(occasion.at)))
        for occasion in occasions
    )


def _by_chance(days: Days, done: EventSeries, rule: _Rule) -> float:
    """Return how often it is done after other times, such as those of other days, under the same conditions."""
    first, last = days.events[0].at, days.events[-1].at
    moved = ([at + shift * DAY for at in rule.begins] for shift in rule.shifts)
    other = [occasion for begins in moved for occasion in _occasions(days, done, begins, rule.span, rule.late)]
    conditions = [days.conditions[condition] for condition in rule.conditions]
    followed = [
        occasion.done_at is not None
        for occasion in other
        if first <= occasion.at <= last and all(holds(occasion.at) for holds in conditions)
    ]
    return (sum(followed) + 1) / (len(followed) + 2)


def _share(tried: Sequence[_Tried]) -> float:
    return _hits(tried) / len(tried) if tried else 0.0


def _hits(tried: Iterable[_Tried]) -> int:
    return sum(case.occasion.done_at is not None for case in tried)


def _best(rules: Iterable[_Rule], left: set[float], chosen: Iterable[int]) -> _Rule | None:
    """Return the rule, with at most two conditions, that is best on the *chosen* days; None if none is any good."""
    best, most = None, 0.0
    numbers = frozenset(chosen)
    for rule in rules:
        own = [case for case in rule.tried if case.day in numbers]
        known = sorted(frozenset[str]().union(*(case.held for case in own)))
        conditions: tuple[str, ...] = ()
        for count in range(_MAX_CONDITIONS + 1):
            wider = (
                [(*conditions, condition) for condition in known if condition not in conditions]
                if count
                else [conditions]
            )
            scores = [_score(own, choice, left) - _LATENCY_PENALTY * (rule.span - rule.late) for choice in wider]
            if not scores:
                break
            conditions = wider[scores.index(max(scores))]
            if max(scores) > most + _CONDITION_PENALTY * (1 + count):
                best, most = replace(rule, conditions=conditions), max(scores)
    return best


def _score(tried: Sequence[_Tried], conditions: tuple[str, ...], left: set[float]) -> float:
    own = [case.occasion for case in tried if case.held.issuperset(conditions)]
    followed = {occasion.done_at for occasion in own if occasion.done_at is not None}
    new = len(followed & left)
    if new < _MIN_NEW:
        return 0.0
    sure = wilson_lower_bound(len(followed), len(own))
    return sure + 0.3 * new / len(left) if sure >= _WORTH_A_LOOK else 0.0


def _prove(
    rules: Sequence[_Rule], days: Days, best: _Rule, left: set[float], done: EventSeries, unlikely: float
) -> FoundHabit | None:
    """Return the habit if it holds on days that were not used to find it; None otherwise."""
    tried = best.occasions
    hits = [case for case in tried if case.occasion.done_at is not None]
    recent = [case for case in tried if case.day >= len(days.midnights) - _RECENT]
    held_out = [*_test_held_out(rules, days, left)]
    proved = _hits(held_out), len(held_out)
    precision = (proved[0] + 0.5) / (proved[1] + 1)  # H. Jeffreys (1946)
    chance = _by_chance(days, done, best)
    is_habit = (
        len({case.day for case in hits}) >= max(MIN_DAYS, _MIN_OF_DAYS * _chances(days, best))
        and wilson_lower_bound(len(hits), len(tried)) >= _MIN_SURE
        and precision >= max(_MIN_PRECISION, chance + _ABOVE_CHANCE)
        and p_value(*proved, chance) <= unlikely
        and _share(recent) >= _MIN_RECENT
        and not _is_automatic(days, best, hits)
    )
    if not is_habit:
        return None
    occasions = tuple(case.occasion for case in tried)
    recall = len({case.occasion.done_at for case in hits}) / len(done.done)
    return FoundHabit(
        best.when, best.conditions, done.step, done.device, best.span - best.late, occasions, proved, recall
    )


def _chances(days: Days, rule: _Rule) -> int:
    """Return how often there was an occasion for a rule that is late; 0 for any other."""
    conditions = [days.conditions[condition] for condition in rule.conditions]
    return sum(all(holds(at + rule.late) for holds in conditions) for at in rule.begins) if rule.late > 0 else 0


def _is_automatic(days: Days, rule: _Rule, hits: Iterable[_Tried]) -> bool:
    """Return whether most was done at the same second of the day, right after a press, or after the same long delay.

    No person does that: programs of devices do, buttons that are bound to a device, and a fan that follows its lamp.
    """
    late = [case.occasion.done_at - case.occasion.at for case in hits if case.occasion.done_at is not None]
    usual = median(late)
    if rule.late < 0 and days.by_text[rule.when].is_press:
        usual = 0.0
    elif rule.late < 0 and usual < _LONG_DELAY:
        return False
    return sum(abs(delay - usual) <= _PUNCTUAL for delay in late) >= 0.8 * len(late)


def _test_held_out(rules: Sequence[_Rule], days: Days, left: set[float]) -> Iterator[_Tried]:
    """Yield the occasions of each third of the days, by the best rule of the others."""
    for fold in range(_FOLDS):
        known = [day for day in range(len(days.midnights)) if day % _FOLDS != fold]
        rule = _best(rules, {at for at in left if days.number(at) in known}, known)
        yield from () if rule is None else (case for case in rule.occasions if case.day % _FOLDS == fold)
