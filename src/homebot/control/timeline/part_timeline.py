"""Timeline of one part: its newest facts, and the questions about them. Pure."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, final

from homebot.control import durations
from homebot.control.timeline.cause import (
    NOWHERE,
    Attribution,
    Cause,
    HeldValue,
    Nearby,
    cause_of,
    cause_of_undoing,
)
from homebot.control.timeline.facts import (
    CommandFact,
    Decided,
    Order,
    PartRef,
    Reported,
    ReportRole,
    SendingEnded,
    Sent,
)
from homebot.control.timeline.learning import learn_failure, learn_late_answer, learn_outcome, learn_settled
from homebot.control.timeline.profile import ENOUGH, DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.control.timeline.settling import Undoing
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.obedience import changes, related
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, NoAnswer
from homebot.devices.value import PlainValue

__all__ = ["MOST_REPORTS", "PartTimeline"]

MOST_REPORTS: Final = 128
_MOST_WHILE_OPEN: Final = 256
_MOST_SENT: Final = 2000
"""As many as a rate limit needs, which counts up to 1,000 changes, and repetitions."""

_ROUNDING: Final = 0.001
"""Seconds by which time stamps and the monotonic clock may differ: some devices answer at once."""

_NONE: Final[Mapping[str, PlainValue]] = MappingProxyType({})


@final
class PartTimeline:
    """The commands and reports of one part in the last 15 minutes, at most 128 each; 256 reports during a command.

    Reports are appended once, when they arrive. The progress of each command is a function of the later reports.

    Args:
        first: Seconds that a device with unknown response times has to answer.
        settle: Seconds for which a confirmed value has to last.

    Attributes:
        reports: The reports, oldest first.
        commands: The commands, including older ones that may still have an effect, oldest first.
        active: Those of them that may have caused a report now; all that have no outcome are.
        sent: The newest 2,000 sendings of commands, oldest first.
        place: The part.
        nearby: The commands to this part and those near it.
        unsure_since: The end of the last failed command for each capability, if none is confirmed since, in seconds.
        held: The values that leases hold.
        dropped_change: The newest unexplained change that is no longer among the reports; None if there is none.
        on_news: Called with each report for each command that may have caused it, and with None for a replaced command.
        on_undone: Called with a command whose confirmed value is undone, and the cause.
    """

    def __init__(self, profile: DeviceProfile, first: float, settle: float) -> None:
        self.reports: deque[Reported] = deque()
        self.commands: deque[CommandProgress] = deque()
        self.active: list[CommandProgress] = []
        self.sent: deque[Sent] = deque(maxlen=_MOST_SENT)
        self.profile = profile
        self.place: PartRef = ("", "")
        self.nearby: Nearby = NOWHERE
        self.unsure_since: dict[str, float] = {}
        self.held: list[HeldValue] = []
        self.dropped_change: Reported | None = None
        self.on_news: Callable[[CommandProgress, Reported | None], None] = lambda *_: None
        self.on_undone: Callable[[CommandProgress, Undoing, Cause], None] = lambda *_: None
        self._first = first
        self._settle = settle
        self._latest: dict[str, tuple[PlainValue, float, float]] = {}  # value, last report, first report
        self._number = 0

    def seed(self, capability: str, value: PlainValue, at: float) -> None:
        """Record a value that was reported live before the timeline began: it is not a change."""
        self._latest.setdefault(capability, (value, at, at))

    def command(
        self,
        order: Order,
        at: float,
        known: Mapping[str, PlainValue] = _NONE,
        last: Mapping[str, PlainValue] = _NONE,
        *,
        answers: bool = False,
        is_raw: bool = False,
    ) -> CommandProgress:
        """Append a command, which supersedes older ones for the same values; return its progress.

        Args:
            last: The values that the part reported last, certain or not.
            answers: Whether the device is known to answer commands.
            is_raw: Whether it has no outcome here: a raw text, or a command to a group of which the part is a member.
        """
        for older in self.active:
            older.supersede(order, at)
            if older.superseded_by == order.id:
                self.on_news(older, None)
        progress = CommandProgress(order, at, known, last, self.profile, answers=answers, is_raw=is_raw)
        self.commands.append(progress)
        self.nearby.device.append(progress)
        self.nearby.room.append(progress)
        self.active.append(progress)
        if is_raw:
            sent = Sent(order.id, order.settings, at)
            progress.apply(sent, self._settle)
            self.sent.extend(() if order.is_foreign else (sent,))
            progress.apply(Decided(order.id, at, NoAnswer(0.0, command_id=order.id)), self._settle)
            for fact in self.reports:
                if fact.at >= at:  # the text is known a little later than its effect
                    self._report(progress, fact)
        if len(self.commands) > MOST_REPORTS or self.commands[0].ended_at < at - durations.REMEMBERED:
            self.active = [one for one in self.active if one.covers(at)]  # no report may ever come that drops them
            self._drop_commands(at - durations.REMEMBERED)
        return progress

    def append(self, fact: CommandFact) -> None:
        """Append a fact about a command, and learn from its outcome."""
        if isinstance(fact, Sent):
            self.sent.append(fact)
        for progress in reversed(self.commands):
            if progress.order.id == fact.command:
                break
        else:
            return  # a rehearsed text, or a command that is forgotten
        progress.apply(fact, self._settle)
        if isinstance(fact, SendingEnded):
            if fact.at - progress.transmission.sent_at > durations.SENT_AT_ONCE:  # it arrives only now
                self.sent.append(Sent(fact.command, progress.order.settings, fact.at))
        elif isinstance(fact, Decided):
            self._end(progress, fact)

    def report(
        self, at: float, stamp: float, capability: str, value: PlainValue, lost_at: float = -math.inf
    ) -> Reported | None:
        """Append a live report and return it; None for a repetition that no command waits for.

        Args:
            at: Seconds on the monotonic clock.
            stamp: The time of the message, in seconds since the Unix epoch.
        """
        is_first = capability not in self._latest
        previous, before, since = self._latest.get(capability, (None, math.inf, at))
        is_same = previous == value and not is_first
        self._latest[capability] = value, at, since if is_same else at
        active = self.active = [one for one in self.active if one.covers(at)]
        if not active and is_same:
            self.profile.learn_repetition()
            self._report_held(capability, value, Attribution(Cause.PERSON))
            return None
        self._number += 1
        fact = Reported(at, stamp, self._number, capability, value, previous, since, is_first, before < lost_at)
        self._append(fact)
        for one in active:
            self._report(one, fact)
        if is_same:
            self.profile.learn_repetition()
        else:
            self._learn_change(fact)
        for one in active:
            self.on_news(one, fact)
        if self.held:
            self._report_held(capability, value, self.cause_of(fact))
        return fact

    @property
    def next_at(self) -> float:
        """The time of the next call of :meth:`advance`; inf for never."""
        next_at = math.inf
        for one in self.active:
            if one.settling is not None and not one.settling.is_over:
                next_at = min(next_at, one.settling.next_at)
        return next_at

    def advance(self, now: float) -> None:
        """End the commands that waited for a further report that did not come."""
        for one in self.active:
            if one.settling is not None:
                one.settling.advance(now)
                self._learn(one, now)

    def value(self, capability: str) -> PlainValue:
        """Return the newest live value; None if there is none."""
        known = self._latest.get(capability)
        return None if known is None else known[0]

    def cause_of(self, fact: Reported) -> Attribution:
        """Return the cause of a report."""
        return cause_of(fact, reversed(self.commands))

    def find(self, capability: str, value: PlainValue, stamp: float) -> Reported | None:
        """Return the report of *value* with that *stamp*; None if it is not among the reports."""
        for fact in reversed(self.reports):
            if (fact.stamp, fact.capability, fact.value) == (stamp, capability, value):
                return fact
        return None

    def unexplained(self, since: float) -> Reported | None:
        """Return the newest change since then that a person may have made; None if there is none."""
        for fact in reversed(self.reports):
            if fact.at < since:
                break
            if self._is_unexplained(fact):
                return fact
        kept = self.dropped_change
        return kept if kept is not None and kept.at >= since else None

    def certain(
        self, capability: str, value: PlainValue, told_at: float, now: float, except_id: str = ""
    ) -> PlainValue:
        """Return *value*, reported at *told_at* on the monotonic clock, if no command makes it doubtful; else None.

        A report since the last command is certain, also of what a person did, and so is one of what the command is for.
        It is doubtful

        - if it came before the end of a command that failed: the device may have obeyed unseen, or have lost power;
        - if a command that changes it was sent since: even a confirmed one, as some devices report only a part of it;
        - if the part may be on its way to another value: for five minutes while a command is open, after a raw text
          that has shown no effect, and of a motor that has not arrived; and during a transition.

        Args:
            except_id: The id of a command that does not count.
        """
        if value is None or told_at <= self.unsure_since.get(capability, -math.inf) + _ROUNDING:
            return None
        for sent in reversed(self.commands):
            outcome, sendings, settings = sent.outcome, sent.transmission, sent.order.settings
            has_effect = outcome is None or (sendings.count > 0 and (outcome.succeeded or outcome.may_obey_later))
            if sent.order.id == except_id or not has_effect:
                continue
            if settings.get(capability) != value:
                may_change = told_at < sendings.sent_at - _ROUNDING or _is_on_its_way(sent, capability, now)
                if may_change and self._changes(settings, capability, value):
                    return None
            if capability in settings:
                break  # it replaced all older ones
        return value

    def _changes(self, settings: Mapping[str, PlainValue], capability: str, value: PlainValue) -> bool:
        """Return whether *settings* are for another *value* of *capability*."""
        if capability in settings and self.profile.fits(capability, settings[capability], value):
            return False
        return any(changes(capability, value, one, settings[one]) for one in related(capability) if one in settings)

    def _end(self, progress: CommandProgress, fact: Decided) -> None:
        """Learn from an outcome; a command that failed may have had an effect, although no report says so."""
        settings, outcome = progress.order.settings, fact.outcome
        if outcome.succeeded:
            for held in self.held:
                held.confirm(settings)
        if progress.settling is not None:
            for capability in settings if self.unsure_since else ():
                self.unsure_since.pop(capability, None)
            self._replace_settling(progress, fact.at)
            learn_outcome(progress, self.profile, self._first)
            return
        if outcome.may_obey_later:  # if it is contradicted, certain is what it has reported since the last sending
            since = progress.transmission.sent_at if isinstance(outcome, Contradicted) else fact.at
            self.unsure_since.update((other, since) for one in settings for other in related(one))
        learn_failure(progress, self.profile)

    def _learn_change(self, fact: Reported) -> None:
        """Relate a change that no command explains to one nearby, or else to the time that the value before lasted."""
        self.profile.changes = min(self.profile.changes + 1, ENOUGH)
        is_effect = ReportRole.EFFECT in [one.roles.get(fact.number) for one in self.active]
        if not fact.is_change or is_effect or self.cause_of(fact).cause is not Cause.PERSON:
            return
        self.nearby.explain(fact, self.place, self.profile)
        if not fact.along and (began := self._timed_from(fact)) is not None:
            fact.timed = self.profile.learn_stay(fact.capability, fact.previous, fact.at - began)

    def _timed_from(self, fact: Reported) -> float | None:
        """Return when a command brought the previous value, or was sent for it again; None if none did."""
        for one in reversed(self.commands):
            wanted, sendings = one.wanted.get(fact.capability), one.transmission
            if wanted is not None and sendings.count and wanted.fits(fact.previous):
                is_effect = wanted.met_at is not None and fact.since <= wanted.met_at
                return max(fact.since, sendings.sent_at) if is_effect or fact.since < sendings.sent_at else None
        return None

    def _report(self, progress: CommandProgress, fact: Reported) -> None:
        progress.report(fact)
        self._learn(progress, fact.at)

    def _learn(self, progress: CommandProgress, now: float) -> None:
        settling = progress.settling
        if settling is None:
            if progress.is_raw and progress.wanted and progress.is_met:
                outcome = Confirmed(now - progress.given_at, Evidence.REPORTED)
                progress.apply(Decided(progress.order.id, now, outcome), self._settle)
            elif progress.learns_late and progress.is_met:
                learn_late_answer(progress, self.profile, self._first)
        elif not progress.is_learnt and (settling.has_held or settling.undoing is not None):
            progress.is_learnt, undoing = True, settling.undoing
            learn_settled(progress, undoing, self.profile)
            if undoing is not None and not progress.is_raw:
                capability, cause = undoing.capability, cause_of_undoing(progress, undoing.capability)
                found = Attribution(cause, progress.order.id, ReportRole.UNDONE)
                self._report_held(capability, self.value(capability), found)  # its report counted as a step
                self.on_undone(progress, undoing, cause)

    def _report_held(self, capability: str, value: PlainValue, found: Attribution) -> None:
        for held in tuple(self.held):
            held.report(capability, value, found)

    def _replace_settling(self, progress: CommandProgress, at: float) -> None:
        """Watch the capabilities of a newly confirmed command only for that command."""
        own = set(progress.order.settings)
        for older in self.active:
            if older is not progress and older.settling is not None:
                older.settling.release(own, at)

    def _is_unexplained(self, fact: Reported) -> bool:
        return fact.is_change and self.cause_of(fact).cause.may_be_person

    def _append(self, fact: Reported) -> None:
        known, oldest = self.reports, fact.at - durations.REMEMBERED
        known.append(fact)
        while len(known) > MOST_REPORTS or known[0].at < oldest:
            is_needed = len(known) <= _MOST_WHILE_OPEN and any(one.covers(fact.at) for one in self.active)
            if is_needed and known[0].at >= oldest:
                break
            dropped = known.popleft()
            if self._is_unexplained(dropped):
                self.dropped_change = dropped
            self._drop_commands(dropped.at)

    def _drop_commands(self, before: float) -> None:
        """Drop the commands that ended *before* that time, and the oldest if there are too many."""
        commands = self.commands
        while commands and not commands[0].is_open:
            if commands[0].ended_at >= before and len(commands) <= MOST_REPORTS:
                break
            commands.popleft()


def _is_on_its_way(sent: CommandProgress, capability: str, now: float) -> bool:
    since, settling, wanted = now - sent.transmission.sent_at, sent.settling, sent.wanted.get(capability)
    if not (sent.is_open or (sent.is_raw and settling is None)):
        if not CAPABILITIES.get(capability, OWN).obedience.moves:
            return since < sent.order.transition
        if wanted is not None and wanted.met_at is not None and settling is not None and settling.has_held:
            return False  # it has arrived
    return since < durations.LONGEST_MOVE
