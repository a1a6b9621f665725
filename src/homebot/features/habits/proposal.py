"""A habit as a routine, with its proof in words; and routines of habits that people undo. Pure."""

from collections.abc import Iterable, Sequence
from hashlib import sha256
from typing import Final, NamedTuple

from homebot.devices.journal_messages import JournalEntry
from homebot.devices.wording.time_format import age_text
from homebot.features.habits.habit import FoundHabit, TriedHabit
from homebot.features.habits.messages import HabitOccasion, HabitProposal
from homebot.features.habits.recorded import is_persons
from homebot.messages.builtin_interfaces import Time
from homebot.words.routine_text import routine_text
from homebot.words.times import DaysAndTime, SunMoment

_MAX_CHARACTERS: Final = 100
_MAX_OCCASIONS: Final = 100
_AGAINST: Final = 600.0
"""Seconds in which a person's change of the same value undoes a command."""

_LAST: Final = 5
UNDONE: Final = 3
"""The undone commands among the last five of a routine from which on its removal is proposed."""


class Undone(NamedTuple):
    """The last commands of a routine, and those of them that people undid."""

    undone: int
    given: int


def name_of(habit: FoundHabit) -> str:
    """Return the name of the routine for *habit*."""
    first, *others = f"{habit.do} {'at' if _is_timed(habit.when) else 'after'} {habit.when}".split('name="')
    return "".join((first, *(text.replace('"', "", 1) for text in others)))[:_MAX_CHARACTERS]


def proposal_of(tried: TriedHabit) -> HabitProposal:
    """Return the routine that would act as people do."""
    habit = tried.found
    table: dict[str, object] = {"name": name_of(habit), "when": [habit.when]}
    if habit.conditions:
        table["if"] = list(habit.conditions)
    table["do"] = [habit.do]
    key = repr((habit.when, habit.conditions, habit.do))
    known = (*habit.occasions, *tried.trial)
    occasions = [
        HabitOccasion(at=Time.from_seconds(occasion.at), done_at=Time.from_seconds(occasion.done_at or 0.0))
        for occasion in known
    ]
    lowest, highest = tried.precision_range
    return HabitProposal(
        id=sha256(key.encode()).hexdigest()[:8],
        name=name_of(habit),
        when=habit.when,
        conditions=habit.conditions,
        do=habit.do,
        text=routine_text(table),
        proof=_proof(tried),
        precision=round(tried.precision, 3),
        precision_low=round(lowest, 3),
        precision_high=round(highest, 3),
        trial_done=tried.done,
        trial_total=len(tried.trial),
        recall=round(habit.recall, 3),
        occasions=tuple(occasions[-_MAX_OCCASIONS:]),
    )


def is_same(one: HabitProposal, when: str, do: str) -> bool:
    """Return whether a habit is the same as one that was rejected: a time of day may move by an hour."""
    if one.do != do:
        return False
    times = [DaysAndTime.read(text) for text in (one.when, when)]
    if times[0] is not None and times[1] is not None:
        first, second = (_minutes(text) for text in times if text is not None)
        return min(abs(first - second), 1440 - abs(first - second)) <= 60
    suns = [SunMoment.read(text) for text in (one.when, when)]
    if suns[0] is not None and suns[1] is not None:
        return suns[0].event == suns[1].event
    return one.when == when


def undone_commands(entries: Sequence[JournalEntry], issuer: str) -> Undone:
    """Return how many of the last five commands of *issuer* a person undid within ten minutes."""
    given = [entry for entry in entries if entry.kind == "requested" and entry.issuer == issuer][-_LAST:]
    by_persons = [entry for entry in entries if is_persons(entry)]
    return Undone(sum(_is_undone(entry, by_persons) for entry in given), len(given))


def _is_undone(command: JournalEntry, by_persons: Iterable[JournalEntry]) -> bool:
    wanted, at = {setting.capability: setting.value for setting in command.settings}, command.at.to_seconds()
    return any(
        (entry.device, entry.part) == (command.device, command.part)
        and wanted.get(setting.capability, setting.value) != setting.value
        for entry in by_persons
        if at < entry.at.to_seconds() <= at + _AGAINST
        for setting in entry.settings
    )


def _proof(tried: TriedHabit) -> str:
    habit, done, total = tried.found, tried.done, len(tried.trial)
    gaps = sorted(abs(occasion.done_at - occasion.at) for occasion in habit.occasions if occasion.done_at is not None)
    near = age_text(max(1.0, gaps[int(0.9 * (len(gaps) - 1))]))
    within = f"within {near} of that time" if _is_timed(habit.when) else f"within {near}"
    low, high = (round(100 * share) for share in tried.precision_range)
    return (
        f"in the week of the trial you did this {within} {done} of {total} times; "
        f"a routine would be right {low} to {high} % of the time"
    )


def _is_timed(when: str) -> bool:
    return (DaysAndTime.read(when) or SunMoment.read(when)) is not None


def _minutes(moment: DaysAndTime) -> int:
    hours, minutes = moment.time.split(":")[:2]
    return int(hours) * 60 + int(minutes)
