"""Timeline of one part: its newest facts, and the questions about them. Pure."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Final, final

from homebot.control import durations
from homebot.control.timeline import facts
from homebot.control.timeline.cause import Attribution, cause_of
from homebot.control.timeline.learning import learn_failure, learn_late_answer, learn_outcome, learn_settled
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.outcomes import NoAnswer
from homebot.devices.value import PlainValue

__all__ = ["MOST_FACTS", "PartTimeline"]

MOST_FACTS: Final = 128
_MOST_WHILE_OPEN: Final = 256


@final
class PartTimeline:
    """The facts of one part, at most 128 of the last 15 minutes; 256 while a command is open.

    Facts are appended once, when they arrive. The progress of each command beside them is a function of the later
    facts.

    Args:
        profile: Knowledge of the device.
        first: Seconds that a device with unknown response times has for its answer.
        settle: Seconds for which a confirmed value has to hold.

    Attributes:
        facts: The facts, oldest first.
        commands: The commands among them, and those that still may have an effect, oldest first.
        profile: Knowledge of the device.
        unsure_since: Since when each capability may have another value than the reported one.
        dropped_change: The newest unexplained change that is no longer among the facts; None if there is none.
        on_report: Called with each report for each command that it may be due to.
        on_end: Called with a command that a newer one replaced, or that was answered.
        on_undone: Called with a command when its confirmed value ended.
    """

    def __init__(self, profile: DeviceProfile, first: float, settle: float) -> None:
        self.facts: deque[facts.Fact] = deque()
        self.commands: deque[CommandProgress] = deque()
        self.profile = profile
        self.unsure_since: dict[str, float] = {}
        self.dropped_change: facts.Reported | None = None
        self.on_report: Callable[[CommandProgress, facts.Reported], None] = _ignore
        self.on_end: Callable[[CommandProgress], None] = _ignore
        self.on_undone: Callable[[CommandProgress], None] = _ignore
        self._first = first
        self._settle = settle
        self._latest: dict[str, tuple[PlainValue, float]] = {}
        self._number = 0
        self._active: list[CommandProgress] = []  # that a report now may be due to

    def seed(self, capability: str, value: PlainValue, at: float) -> None:
        """Record a value that was reported live before the timeline began: it is no change."""
        self._latest.setdefault(capability, (value, at))

    def command(self, fact: facts.Commanded) -> CommandProgress:
        """Append a command, which supersedes the older ones for the same; return its progress."""
        for older in self._active:
            older.supersede(fact.order, fact.at)
            if older.superseded_by:
                self.on_end(older)
        progress = CommandProgress(fact, self.profile)
        if fact.is_raw:
            progress.send(fact.at)
            progress.decide(NoAnswer(0.0, command_id=fact.order.id), fact.at, self._settle)
        self.commands.append(progress)
        self._active.append(progress)
        self._append(fact)
        return progress

    def send(self, progress: CommandProgress, at: float) -> None:
        """Append the sending of a command."""
        progress.send(at)
        self._append(facts.Sent(at, progress.order.id))

    def accept(self, command: str, capability: str, problem: str, at: float) -> None:
        """Append the answer of the network or the device to a command; a *problem* is a refusal."""
        progress = next((one for one in self.commands if one.order.id == command), None)
        if progress is None or capability not in progress.order.settings:
            return
        if problem:
            progress.refuse(problem)
            self._append(facts.RefusedByDevice(at, command, problem))
        else:
            progress.accept(capability, at)
            self._append(facts.Acknowledged(at, command, capability))
        self.on_end(progress)

    def decide(self, progress: CommandProgress, fact: facts.Decided) -> None:
        """Append the outcome of a command, and learn from it."""
        progress.decide(fact.outcome, fact.at, self._settle)
        if progress.settling is not None:
            self._replace_settling(progress, fact.at)
            learn_outcome(progress, self.profile, self._first)
        else:
            learn_failure(progress, self.profile)
        self._append(fact)

    def witness(self, fact: facts.Witnessed) -> None:
        """Append the observation of a second device."""
        self._append(fact)

    def report(
        self, at: float, stamp: float, capability: str, value: PlainValue, lost_at: float = -math.inf
    ) -> facts.Reported | None:
        """Append a live report, or None if it is a repetition that no command waits for.

        Args:
            at: Seconds on the monotonic clock.
            stamp: The time of the message, in seconds since the Unix epoch.
            capability: The capability.
            value: Its value.
            lost_at: When the connection was last lost.
        """
        known = self._latest.get(capability)
        self._latest[capability] = value, at
        active = self._active = [one for one in self._active if one.covers(at)]
        if not active and known is not None and known[0] == value:
            return None
        self._number += 1
        previous, before = (None, math.inf) if known is None else known
        fact = facts.Reported(at, stamp, self._number, capability, value, previous, known is None, before < lost_at)
        self._append(fact)
        for one in active:
            one.report(fact)
            self._learn(one)
        for one in active:
            self.on_report(one, fact)
        return fact

    @property
    def next_at(self) -> float:
        """The time at which :meth:`advance` has something to do; inf for never."""
        settlings = [one.settling for one in self._active if one.settling is not None]
        return min((one.next_at for one in settlings if not one.is_over), default=math.inf)

    def advance(self, now: float) -> None:
        """End the commands that waited in vain for a further report."""
        for one in self._active:
            if one.settling is not None and not one.settling.is_over:
                one.settling.advance(now)
                self._learn(one)

    def value(self, capability: str) -> PlainValue:
        """Return the newest live value; None if there is none."""
        known = self._latest.get(capability)
        return None if known is None else known[0]

    def cause_of(self, fact: facts.Reported) -> Attribution:
        """Return the cause of a report."""
        return cause_of(fact, reversed(self.commands))

    def find(self, capability: str, value: PlainValue, stamp: float) -> facts.Reported | None:
        """Return the report of *value* with that *stamp*; None if it is not among the facts."""
        for fact in reversed(self.facts):
            if isinstance(fact, facts.Reported) and fact.stamp == stamp and fact.capability == capability:
                return fact if fact.value == value else None
        return None

    def unexplained(self, since: float) -> facts.Reported | None:
        """Return the newest change since then that may be a person's; None if there is none."""
        for fact in reversed(self.facts):
            if fact.at < since:
                break
            if self._is_unexplained(fact):
                return fact if isinstance(fact, facts.Reported) else None
        kept = self.dropped_change
        return kept if kept is not None and kept.at >= since else None

    def last_sent(self, capability: str, except_id: str) -> tuple[PlainValue, float] | None:
        """Return the value and the time of the newest sent command for *capability*, except that command."""
        for one in reversed(self.commands):
            if one.sendings and one.order.id != except_id and capability in one.order.settings:
                return one.order.settings[capability], one.sent_at
        return None

    def open_commands(self) -> list[CommandProgress]:
        """Return the commands without an outcome, oldest first; no raw texts."""
        return [one for one in self._active if one.is_open]

    def _learn(self, progress: CommandProgress) -> None:
        """Learn from the end of a confirmed value, or from a late answer."""
        settling = progress.settling
        if settling is None:
            if progress.learns_late and progress.is_met:
                learn_late_answer(progress, self.profile, self._first)
        elif not progress.is_learnt and (settling.has_held or settling.undoing is not None):
            progress.is_learnt = True
            learn_settled(progress, self.profile)
            if settling.undoing is not None:
                self.on_undone(progress)

    def _replace_settling(self, progress: CommandProgress, at: float) -> None:
        """Watch the capabilities of a newly confirmed command for that one alone."""
        own = set(progress.order.settings)
        for older in self._active:
            if older is not progress and older.settling is not None:
                older.settling.release(own, at)

    def _is_unexplained(self, fact: facts.Fact) -> bool:
        return isinstance(fact, facts.Reported) and fact.is_change and self.cause_of(fact).cause.may_be_person

    def _append(self, fact: facts.Fact) -> None:
        known = self.facts
        known.append(fact)
        while len(known) > MOST_FACTS or known[0].at < fact.at - durations.REMEMBERED:
            is_needed = len(known) <= _MOST_WHILE_OPEN and any(one.covers(fact.at) for one in self._active)
            if is_needed and known[0].at >= fact.at - durations.REMEMBERED:
                break
            self._drop(known.popleft())

    def _drop(self, fact: facts.Fact) -> None:
        if self._is_unexplained(fact) and isinstance(fact, facts.Reported):
            self.dropped_change = fact
        while self.commands and not self.commands[0].is_open and self.commands[0].ended_at < fact.at:
            self.commands.popleft()


def _ignore(*_: object) -> None:
    pass
