"""Knowledge about a device from its timeline: response times, reverts, echoes, rounding, and programs. Pure.

A profile may be deleted at any time: commands then wait a little longer, and no outcome becomes wrong.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Annotated, Final, NamedTuple, TypeAlias, TypeVar, final

from pydantic import Field

from homebot.control import durations
from homebot.control.timeline.facts import Cause, Reported
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import departs, fits, is_other_end, is_same

KEPT: Final = 16
_MAX_ANSWERS: Final = 8
"""The limit of answers to different values, for each capability."""

ENOUGH: Final = 3
_NEWEST: Final = 5
"""The number of times of one value among which enough have to be the same, of a time that is no long one."""

_IN_VAIN: Final = 2
"""Consecutive commands without effect after which a route is tried last: a person may have undone one."""

_FIRST_ECHOES: Final = 3
_MAX_ROUNDING: Final = 25.0
"""Percent by which a dimmer may round; a larger error is not rounding."""

_SLACK: Final = 1.5
"""Percent by which the errors of one dimmer vary: most have 254 steps, or 99 as with Z-Wave.

Sources: openhab/org.openhab.binding.zigbee#108 (99 becomes 98), home-assistant/core#33927 (22 becomes 21).
"""


_T = TypeVar("_T")
_Newest: TypeAlias = Annotated[list[_T], Field(max_length=KEPT)]
_Seconds: TypeAlias = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_Answers: TypeAlias = Annotated[list[tuple[PlainValue, PlainValue]], Field(max_length=_MAX_ANSWERS)]
"""The reported values for commanded values, each of which occurs once."""


class Return(NamedTuple):
    """End of one confirmed value.

    Attributes:
        is_fast: Whether its report was so fast that it may have been an echo.
        after: Seconds after which another value followed; None if none did.
    """

    is_fast: bool
    after: _Seconds | None


@dataclass(slots=True, eq=False)
class DeviceProfile:
    """Knowledge about one part, by capability; the last 16 items of each.

    Attributes:
        times: The response times, in seconds.
        returns: The ends of confirmed values; empty as long as no value was undone.
        echoes: For each expected echo, whether the device's own report followed it.
        answers: The reported values by commanded value.
        stays: How long commanded values lasted until another followed.
        kept: How many commanded values lasted, at most three, by :func:`_value_name`.
        gaps: The seconds between changes that nothing explains: between those of a level or colour, and to one value.
        creeps: How many times in a row another program changed the level or colour a little, at most three.
        pairs: How often in a row it changed along with commands to each part near it, at most three times.
        failures: By route, the number of consecutive commands without effect, at most two; see :attr:`Route.name`.
        changes: The number of live reports since one that repeated a value, at most three.
        is_told_once: Whether it is a dimmer that did not answer several sendings: each may have restarted its ramp.
        is_changed: Whether it has unsaved knowledge.
    """

    times: dict[str, _Newest[_Seconds]] = field(default_factory=dict)
    returns: dict[str, _Newest[Return]] = field(default_factory=dict)
    echoes: dict[str, _Newest[bool]] = field(default_factory=dict)
    answers: dict[str, _Answers] = field(default_factory=dict)
    stays: dict[str, _Newest[tuple[bool | float | str, _Seconds]]] = field(default_factory=dict)
    gaps: dict[str, _Newest[tuple[bool | float | str, _Seconds]]] = field(default_factory=dict)
    kept: Annotated[dict[str, int], Field(max_length=KEPT)] = field(default_factory=dict)
    creeps: Annotated[int, Field(ge=0, le=ENOUGH)] = 0
    pairs: Annotated[dict[str, int], Field(max_length=KEPT)] = field(default_factory=dict)
    failures: Annotated[dict[str, int], Field(max_length=KEPT)] = field(default_factory=dict)
    changes: Annotated[int, Field(ge=0, le=ENOUGH)] = 0
    is_told_once: bool = False
    is_changed: bool = False

    def add(self, earlier: DeviceProfile) -> None:
        """Add the knowledge of an earlier run, except about capabilities and routes that are known already."""
        for item in fields(self):
            own, before = getattr(self, item.name), getattr(earlier, item.name)
            setattr(self, item.name, {**before, **own} if isinstance(own, dict) else max(own, before))

    def answer_time(self, capabilities: Iterable[str], first: float) -> tuple[float, float]:
        """Return how long to wait for an answer, and the longest known answer, in seconds.

        Args:
            first: The shortest wait if fewer than three answers are known.
        """
        longest, is_known = 0.0, True
        for capability in capabilities:
            times = self.times.get(capability, ())
            longest = max(longest, max(times, default=0.0))
            is_known = is_known and len(times) >= ENOUGH
        limit = durations.ANSWER_FACTOR * longest + durations.ANSWER_SPARE
        if not is_known:
            limit, longest = max(limit, first), max(longest, durations.UNKNOWN_ANSWER)
        return min(max(limit, durations.MIN_ANSWER), durations.MAX_ANSWER), longest

    def learn_time(
        self, capability: str, seconds: float, first: float, *, sendings: int = 1, is_change: bool = True
    ) -> None:
        """Record a response time, counted from the first of *sendings*.

        After several sendings it counts as at most *first*, or each repetition would delay the next ones. A report that
        is not a change may be a coincidence, so it never makes the wait longer.
        """
        limit = durations.ANSWER_FACTOR * seconds + durations.ANSWER_SPARE
        if not is_change and limit > self.answer_time((capability,), first)[0]:
            return
        times = self.times.setdefault(capability, [])
        longest, count = max(times, default=0.0), len(times)
        times.append(min(seconds, first) if sendings > 1 else seconds)
        del times[:-KEPT]
        if count == ENOUGH - 1 or abs(max(times) - longest) >= durations.ANSWER_SPARE:  # the next wait depends on it
            self.is_changed = True

    def learn_repetition(self) -> None:
        """Record a live report of the same value as before."""
        self.is_changed = self.is_changed or self.changes >= ENOUGH
        self.changes = 0

    def learn_return(self, capability: str, after: float | None, *, is_fast: bool) -> None:
        """Record the end of a confirmed value; a device that never reverts one has no record."""
        if after is not None or capability in self.returns:
            self.returns[capability] = [*self.returns.get(capability, ()), Return(is_fast, after)][-KEPT:]
            self.is_changed = True

    def learn_echo(self, capability: str, *, is_answered: bool) -> None:
        """Record whether the device's own report followed an echo."""
        self.echoes[capability] = [*self.echoes.get(capability, ()), is_answered][-KEPT:]
        self.is_changed = True

    def learn_routes(self, routes: Iterable[str], worked: str = "") -> None:
        """Record the *routes* by which a command was sent, and the one that *worked*, empty for none."""
        for route in dict.fromkeys(routes):
            before = self.failures.pop(route, 0)
            count = 0 if route == worked else min(before + 1, _IN_VAIN)
            self.is_changed = self.is_changed or count != before
            if count:
                self.failures[route] = count
        while len(self.failures) > KEPT:
            del self.failures[next(iter(self.failures))]

    def learn_kept(self, capability: str, value: PlainValue) -> None:
        """Record that a commanded *value* lasted."""
        name = _value_name(capability, value)
        before = self.kept.pop(name, 0)
        self.kept[name] = min(before + 1, ENOUGH)
        if len(self.kept) > KEPT:
            del self.kept[next(iter(self.kept))]
        self.is_changed = self.is_changed or before < ENOUGH

    def keeps(self, capability: str, value: PlainValue) -> bool:
        """Return whether commanded values such as *value* usually last."""
        return self.kept.get(_value_name(capability, value), 0) >= ENOUGH

    def learn_stay(self, capability: str, value: PlainValue, seconds: float) -> int:
        """Record that *value* lasted for *seconds*; return how often it did so the last times, at least five.

        The longer it lasted, the seldomer does a person hit the time by chance, so more of the last times count.
        People undo a command so soon so often that a short time counts only if it is always the same.
        """
        before = sum(lasted == value for lasted, _ in self.stays.get(capability, ()))
        slack = max(durations.REGULAR, durations.CLOCK_DRIFT * seconds)
        newest = min(max(_NEWEST, int(seconds / durations.HASTY)), KEPT)
        count = self._learn_regular(self.stays, capability, value, seconds, slack, newest)
        needed = _NEWEST if self.keeps(capability, value) else min(before, _NEWEST)
        return count if seconds > durations.HASTY or count >= needed else 0

    def learn_gap(self, capability: str, value: PlainValue, seconds: float) -> bool:
        """Record the time since the last change that nothing explains; return whether these come regularly."""
        return self._learn_regular(self.gaps, capability, value, seconds, durations.PUNCTUAL) >= ENOUGH

    def is_tick(self, capability: str, gap: float) -> bool:
        """Return whether *gap* is a multiple of a program's interval, so that it went on unseen."""
        gaps = [seconds for _, seconds in self.gaps.get(capability, ())]
        shortest = [seconds for seconds in gaps if seconds - min(gaps) <= durations.PUNCTUAL]
        if len(shortest) < ENOUGH or gap == math.inf:
            return False
        interval = sum(shortest) / len(shortest)
        return abs(gap - round(gap / interval) * interval) <= min(durations.PUNCTUAL, interval / KEPT)

    def learn_creep(self, *, is_small: bool) -> bool:
        """Record a change of the level or colour of a lit lamp; return whether it is usual: three were small before."""
        before = self.creeps
        self.creeps = min(before + 1, ENOUGH) if is_small else 0
        self.is_changed = self.is_changed or self.creeps != before
        return is_small and before >= ENOUGH

    def _learn_regular(
        self,
        records: dict[str, list[tuple[bool | float | str, float]]],
        capability: str,
        value: PlainValue,
        seconds: float,
        slack: float,
        newest: int = _NEWEST,
    ) -> int:
        """Record *seconds*; return how many of the *newest* records of *value* are as long: they differ by *slack*."""
        if isinstance(value, tuple) or value is None:
            return 0
        known = records.get(capability, [])
        times = [lasted for known_value, lasted in known if known_value == value][-newest:]
        records[capability], self.is_changed = [*known, (value, seconds)][-KEPT:], True
        same = [seconds, *(time for time in times if abs(time - seconds) <= slack)]
        return max(sum(0.0 <= time - begin <= slack for time in same) for begin in same if begin <= seconds) - 1

    def learn_pair(self, other: str, *, is_missed: bool) -> bool:
        """Record that it changed along with a command to the part *other*; return whether it usually does.

        Args:
            is_missed: Whether it did not the last time.
        """
        count = 0 if is_missed else self.pairs.pop(other, 0)
        self.pairs[other] = min(count + 1, ENOUGH)
        if len(self.pairs) > KEPT:
            del self.pairs[next(iter(self.pairs))]
        self.is_changed = self.is_changed or self.pairs[other] != count
        return count >= ENOUGH

    @property
    def ineffective(self) -> frozenset[str]:
        """The routes whose last commands had no effect."""
        return frozenset(route for route, count in self.failures.items() if count >= _IN_VAIN)

    def learn_answer(self, capability: str, wanted: PlainValue, seen: PlainValue) -> None:
        """Record that the device reported *seen* for *wanted*; always reporting wanted values leaves no record."""
        if capability not in self.answers:
            rounds = CAPABILITIES.get(capability, OWN).comparison.rounds
            is_usual = wanted == seen or not (rounds or fits(capability, wanted, seen))
            if is_usual or is_same(capability, wanted, seen):
                return
        answers = self.answers.get(capability, [])
        if (wanted, seen) not in answers:
            others = [answer for answer in answers if answer[0] != wanted]
            self.answers[capability] = [*others, (wanted, seen)][-_MAX_ANSWERS:]
            self.is_changed = True

    def fits(self, capability: str, wanted: PlainValue, value: PlainValue) -> bool:
        """Return whether *value* is the wanted one, allowing for the device's rounding."""
        if fits(capability, wanted, value):
            return True
        if capability not in self.answers or not (isinstance(wanted, float) and isinstance(value, float)):
            return False
        return abs(wanted - value) <= self.rounding(capability) and not is_other_end(capability, wanted, value)

    def departs(self, capability: str, wanted: PlainValue, value: PlainValue) -> bool:
        """Return whether *value* shows that the device is neither at the wanted one nor on its way there."""
        return departs(capability, wanted, value) and not self.fits(capability, wanted, value)

    def rounding(self, capability: str) -> float:
        """Return by how much the device rounds values of *capability*; 0 if unknown.

        It is the largest error of at least three answers with two different values.
        """
        if capability not in self.answers or not CAPABILITIES.get(capability, OWN).comparison.rounds:
            return 0.0
        known = [
            (wanted, seen)
            for wanted, seen in self.answers[capability]
            if isinstance(wanted, float) and isinstance(seen, float)
        ]
        if len(known) < ENOUGH or len({seen for _, seen in known}) < 2:
            return 0.0
        largest = max(abs(wanted - seen) for wanted, seen in known)
        return largest + _SLACK if largest <= _MAX_ROUNDING else 0.0

    def is_echo(self, capability: str) -> bool:
        """Return whether fast reports are a bridge's echoes: the last three were retracted, quickly and regularly.

        A value that holds ends the suspicion.
        """
        if capability not in self.returns:
            return False
        fast = [end.after for end in self.returns[capability] if end.is_fast][-ENOUGH:]
        taken_back = [after for after in fast if after is not None and after <= durations.TAKEN_BACK]
        return len(taken_back) == ENOUGH and max(taken_back) - min(taken_back) <= durations.REGULAR

    def echo_patience(self, capability: str, limit: float) -> float:
        """Return how long to wait after an echo, at most *limit* seconds: not at all if nothing ever follows."""
        echoes = self.echoes.get(capability, ())
        if any(echoes) or capability in self.returns:
            return limit
        return min(durations.ECHO_PATIENCE, limit) if len(echoes) < _FIRST_ECHOES else 0.0


_LOOKS: Final = frozenset({"level", "color_temperature", "color"})
_MAX_CREEP: Final = 0.05


class _Creep(NamedTuple):
    """Change of the level or colour of a lit lamp that nothing explains, with its further steps.

    Attributes:
        at: When its newest step came, in seconds.
        begin: The values before, by capability.
        is_small: Whether it is hardly seen.
        cause: The cause of such changes; None if they are not usual.
    """

    at: float
    begin: dict[str, PlainValue]
    is_small: bool
    cause: Cause | None


@final
class ProgramWatch:
    """The changes of one part that nothing explains: a program makes them regularly, or little by little.

    At intervals of at most an hour; a setpoint at the same second each day; or the level and colour of a lit lamp by at
    most five percent, again and again. A lamp that was off catches up, at one of the times at which the program changes
    the others.
    """

    def __init__(self, profile: DeviceProfile) -> None:
        self._profile = profile
        self._creep: _Creep | None = None
        self._changed_at: dict[tuple[str, PlainValue], float] = {}

    def cause(self, fact: Reported, lit_since: float) -> Cause | None:
        """Return *program* for a change that is usual for one, *unknown* if it may be one's; learn from it.

        Args:
            lit_since: When the lamp came on, in seconds; inf if it is off.
        """
        capability, is_look = fact.capability, fact.capability in _LOOKS
        value = "" if is_look else fact.value  # each value is another one
        gap = fact.at - self._changed_at.pop((capability, value), -math.inf)
        self._changed_at[capability, value] = fact.at
        if len(self._changed_at) > KEPT:
            del self._changed_at[next(iter(self._changed_at))]
        if is_look and self._creep is not None and fact.at - self._creep.at < durations.CREEPS:
            return self._cause_of_step(fact, self._creep)
        is_tick = is_look and self._profile.is_tick(capability, gap)
        is_interval = gap <= durations.INTERVAL or (isinstance(value, float) and gap < math.inf)
        is_usual = is_interval and self._profile.learn_gap(capability, value, gap)
        if is_look and lit_since <= fact.at:
            return self._cause_of_look(fact, lit_since, is_usual=is_usual, is_tick=is_tick)
        return Cause.PROGRAM if is_usual else None

    def _cause_of_look(self, fact: Reported, lit_since: float, *, is_usual: bool, is_tick: bool) -> Cause | None:
        """Return the cause of a first step of the level or colour of a lit lamp."""
        capability, creep = fact.capability, self._creep
        catches_up = self._profile.creeps == ENOUGH and (creep is None or creep.at < lit_since)
        is_small = not catches_up and _is_small(capability, fact.previous, fact.value)
        is_usual = is_usual or is_tick if catches_up else self._profile.learn_creep(is_small=is_small) or is_usual
        cause = Cause.PROGRAM if is_usual else Cause.UNKNOWN if is_small or catches_up else None
        self._creep = _Creep(fact.at, {capability: fact.previous}, is_small, cause)
        return cause

    def _cause_of_step(self, fact: Reported, creep: _Creep) -> Cause | None:
        """Return the cause of a further step, or of the colour after the level, of a change."""
        is_other = fact.capability not in creep.begin
        begin = creep.begin.setdefault(fact.capability, fact.previous)
        is_small = creep.is_small and _is_small(fact.capability, begin, fact.value)
        if creep.is_small and not is_small:
            self._profile.learn_creep(is_small=False)
        self._creep = creep._replace(at=fact.at, is_small=is_small)
        return creep.cause if is_small or (is_other and not creep.is_small) else None


def may_be_timer(seconds: float) -> bool:
    """Return whether a time is as long as the first one of a timer: most are set to whole minutes."""
    return abs(seconds - round(seconds / 60.0) * 60.0) <= durations.REGULAR < seconds


def _value_name(capability: str, value: PlainValue) -> str:
    """Return the name under which it counts whether a value lasts: all numbers of a capability have one."""
    return f"{capability} {value}" if isinstance(value, bool | str) else capability


def _is_small(capability: str, before: PlainValue, value: PlainValue) -> bool:
    """Return whether a number changed by at most five percent, of the range of a level or of the colour temperature."""
    if not (isinstance(before, float) and isinstance(value, float)):
        return False
    return abs(value - before) <= _MAX_CREEP * (100.0 if capability == "level" else before)
