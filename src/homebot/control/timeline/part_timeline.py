"""Timeline of one part: its newest facts, and the questions about them. Pure."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple, final

from homebot.control import durations
from homebot.control.timeline.cause import NOWHERE, HeldValue, Nearby, Roles, judge, rests_where_sent
from homebot.control.timeline.evidence import learn_failure, learn_late_answer, learn_outcome, learn_settled
from homebot.control.timeline.facts import (
    Attribution,
    Cause,
    CommandFact,
    Decided,
    Order,
    PartRef,
    Reported,
    ReportRole,
    SendingEnded,
    Sent,
)
from homebot.control.timeline.profile import ENOUGH, DeviceProfile, ProgramWatch, may_be_timer
from homebot.control.timeline.progress import CommandProgress, Undoing
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.outcomes import Confirmed, Evidence, NoAnswer
from homebot.devices.value import PlainValue, SetBy
from homebot.devices.value_comparison import changes, fits, related

MAX_REPORTS: Final = 128
_MAX_SENT: Final = 2000
"""As many as a rate limit needs, which counts up to 1,000 changes within an hour, and repetitions."""

_MAX_CLOCK_ERROR_S: Final = 0.001
"""Seconds by which time stamps and the monotonic clock may differ: some devices answer at once."""

_NONE: Final[Mapping[str, PlainValue]] = MappingProxyType({})


class _Brought(NamedTuple):
    """Value that a command brought: it was reported as *seen* and lasts from *at* on."""

    command: str
    value: PlainValue
    seen: PlainValue
    at: float

    def is_near(self, fact: Reported) -> bool:
        """Return whether a number is the same but for rounding, so that nobody wanted another one.

        The rounding that a profile has learnt is for wanted values only: what a person sets may be as near.
        """
        values = self.value, self.seen
        return isinstance(fact.value, float) and any(fits(fact.capability, value, fact.value) for value in values)


@final
class PartTimeline:
    """The commands and reports of one part in the last 15 minutes, at most 128 each.

    Reports are appended once, when they arrive, each with its cause and its role for a command; all else reads these.
    They are amended in three cases: a raw text of another program becomes known later than its effect; what counted as
    the step of a transition leads nowhere; a cover reports that it rests before it reports where.

    Args:
        first: Seconds that a device with unknown response times has to answer.
        settle: Seconds for which a confirmed value has to last.

    Attributes:
        reports: The reports, oldest first.
        commands: The commands, including older ones that may still have an effect, oldest first.
        active: Those of them that may have caused a report now; all that have no outcome are.
        sent: The newest 2,000 sendings of commands in an hour, oldest first.
        place: The part.
        nearby: The commands to this part and those near it.
        held: The values that leases hold.
        newest: The newest change of each capability, with its cause.
        unexplained_change: The newest change that a person may have made; None if there is none.
        on_news: Called with each report for each command that may have caused it, and with None for a replaced command.
        on_undone: Called with a command whose confirmed value is undone, the value since, and the cause.
    """

    def __init__(self, profile: DeviceProfile, first: float, settle: float) -> None:
        self.reports: deque[Reported] = deque()
        self.commands: deque[CommandProgress] = deque()
        self.active: list[CommandProgress] = []
        self.sent: deque[Sent] = deque(maxlen=_MAX_SENT)
        self.profile = profile
        self.place: PartRef = ("", "")
        self.nearby: Nearby = NOWHERE
        self.held: list[HeldValue] = []
        self.newest: dict[str, Reported] = {}
        self.unexplained_change: Reported | None = None
        self.on_news: Callable[[CommandProgress, Reported | None], None] = lambda *_: None
        self.on_undone: Callable[[CommandProgress, Undoing, PlainValue, Cause], None] = lambda *_: None
        self._first = first
        self._settle = settle
        self._latest: dict[str, tuple[PlainValue, float, float]] = {}  # value, last report, first report
        self._echoes: dict[str, tuple[CommandProgress, Reported]] = {}  # the newest report, if it was one
        self._brought: dict[str, _Brought] = {}
        self._programs = ProgramWatch(profile)
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
        self._forget_sent(at)
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
                    self._judge(fact, [(progress, progress.report(fact))])
                    self._learn(progress, fact.at)
        if len(self.commands) > MAX_REPORTS or self.commands[0].ended_at < at - durations.REMEMBERED:
            self.forget_commands(at, at - durations.REMEMBERED)
        return progress

    def forget(self, now: float) -> None:
        """Forget durations that ended 15 minutes ago, and sendings of an hour ago: nothing may ever come again.

        The newest report stays, and the commands that :meth:`certain` still needs.
        """
        self._forget_sent(now)
        while len(self.reports) > 1 and self.reports[0].at < now - durations.REMEMBERED:
            self.reports.popleft()
        if self.commands:
            self.forget_commands(now, now - durations.REMEMBERED)

    def forget_commands(self, now: float, before: float) -> int:
        """Forget the commands that ended *before* that time, those kept as in :meth:`forget`; return how many."""
        self.active = [command for command in self.active if now <= command.until]  # no report may ever drop them
        count = len(self.commands)
        self._drop_commands(before)
        return count - len(self.commands)

    def append(self, fact: CommandFact) -> None:
        """Append a fact about a command, and learn from its outcome."""
        if isinstance(fact, Sent):
            self.sent.append(fact)
            for capability, value in fact.settings.items() if self._brought else ():
                brought = self._brought.get(capability)
                if brought is not None and brought.value == value:  # a repetition starts timers anew
                    self._brought[capability] = brought._replace(at=fact.at)
        for progress in reversed(self.commands):
            if progress.order.id == fact.command:
                break
        else:
            return  # a rehearsed text, or a command that is forgotten
        progress.apply(fact, self._settle)
        if progress.is_raw and progress not in self.active:
            self.active.append(progress)
        if isinstance(fact, SendingEnded):
            if fact.at - progress.transmission.sent_at > durations.SENT_AT_ONCE:  # it arrives only now
                self.sent.append(Sent(fact.command, progress.order.settings, fact.at))
        elif isinstance(fact, Decided):
            self._end(progress, fact)

    def report(
        self,
        at: float,
        stamp: float,
        capability: str,
        value: PlainValue,
        lost_at: float = -math.inf,
        absent_at: float = -math.inf,
        set_by: SetBy = "",
    ) -> Reported | None:
        """Append a live report with its cause, and return it; None for a repetition that no command waits for.

        Args:
            at: Seconds on the monotonic clock.
            stamp: The time of the message, in seconds since the Unix epoch.
        """
        active = self.active = [command for command in self.active if at <= command.until]
        latest = self._latest.get(capability)
        if latest is not None and latest[0] == value and not active:
            self._latest[capability] = value, at, latest[2]
            self.profile.learn_repetition()
            was_absent = -math.inf < absent_at >= latest[1]
            self._report_held(capability, value, Attribution(Cause.PERSON, was_absent=was_absent))
            return None
        fact = self._append(at, stamp, capability, value, lost_at, absent_at, set_by)
        roles = [(command, command.report(fact)) for command in reversed(active)]
        self._judge(fact, roles)
        self._record_brought(fact, roles)
        for command in active:
            self._learn(command, at)
        for command in active:
            self.on_news(command, fact)
        if self.held:
            self._report_held(capability, value, fact.attribution)
        return fact

    def _append(
        self,
        at: float,
        stamp: float,
        capability: str,
        value: PlainValue,
        lost_at: float,
        absent_at: float,
        set_by: SetBy,
    ) -> Reported:
        """Append a report, with the facts about the value before it."""
        previous, seen_at, since = self._latest.get(capability, (None, math.inf, at))
        is_first = capability not in self._latest
        is_same = previous == value and not is_first
        self._latest[capability] = value, at, since if is_same else at
        echo = self._echoes.pop(capability, None)
        if echo is not None and (echo[0].is_open or at - seen_at <= durations.TAKEN_BACK):
            previous, seen_at, since = echo[1].previous, echo[1].seen_at, echo[1].since  # an echo is no report
        is_off_again = is_same and value is False and self._is_turning_on(capability)
        self._number += 1
        fact = Reported(
            at,
            stamp,
            self._number,
            capability,
            value,
            previous,
            since,
            seen_at,
            is_first,
            is_after_loss=seen_at < lost_at,
            was_absent=-math.inf < absent_at >= seen_at,
            is_news=is_off_again or (is_same and echo is None and self.profile.changes >= ENOUGH),
            set_by=set_by,
        )
        if not is_same:
            self.profile.changes = min(self.profile.changes + 1, ENOUGH)
        elif not is_off_again:
            self.profile.learn_repetition()
        self.reports.append(fact)
        while len(self.reports) > MAX_REPORTS or self.reports[0].at < at - durations.REMEMBERED:
            self._drop_commands(self.reports.popleft().at)
        return fact

    def _is_turning_on(self, capability: str) -> bool:
        """Return whether an open command turns *capability* on along with other values, so "off" is a new will."""
        return any(
            command.is_open and command.transmission.count and len(command.wanted) > 1 and wanted.value is True
            for command in self.active
            if (wanted := command.wanted.get(capability)) is not None
        )

    @property
    def next_at(self) -> float:
        """The time of the next call of :meth:`advance`; inf for never."""
        return min([command.next_at for command in self.active if command.is_confirmed], default=math.inf)

    def advance(self, now: float) -> None:
        """End the commands that waited for a further report that did not come."""
        for command in self.active:
            if command.next_at <= now:
                command.advance(now)
                self._learn(command, now)

    def value(self, capability: str) -> PlainValue:
        """Return the newest live value; None if there is none."""
        known = self._latest.get(capability)
        return None if known is None else known[0]

    def order_of(self, command: str) -> Order | None:
        """Return a command; None if it is not known any more."""
        return next((progress.order for progress in self.commands if progress.order.id == command), None)

    def find(self, capability: str, value: PlainValue, stamp: float) -> Reported | None:
        """Return the report of *value* with that *stamp*; None if it is not among the reports."""
        for fact in reversed(self.reports):
            if (fact.stamp, fact.capability, fact.value) == (stamp, capability, value):
                return fact
        return None

    def unexplained(self, since: float) -> Reported | None:
        """Return the newest change since then that a person may have made; None if there is none."""
        change = self.unexplained_change
        return change if change is not None and change.at >= since else None

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
        if value is None:
            return None
        is_replaced = False
        for sent in reversed(self.commands):
            settings = sent.order.settings
            is_unsure = told_at <= sent.unsure_until + _MAX_CLOCK_ERROR_S
            if is_unsure and not settings.keys().isdisjoint(related(capability)):
                return None
            if sent.may_have_effect and not is_replaced and sent.order.id != except_id:
                if settings.get(capability) != value:
                    is_before = told_at < sent.transmission.sent_at - _MAX_CLOCK_ERROR_S
                    may_change = is_before or _is_on_its_way(sent, capability, now)
                    if may_change and self._changes(settings, capability, value):
                        return None
                is_replaced = capability in settings  # all older ones are, but one of them may have failed
            if sent.is_confirmed and capability in settings:
                break
        return value

    def last_proved(self, capability: str) -> CommandProgress | None:
        """Return the last command for *capability* that is confirmed, or the last that failed, whichever is newer.

        One that failed may have had an effect on all related capabilities, although no report says so.
        """
        for sent in reversed(self.commands):
            settings = sent.order.settings
            if sent.is_confirmed:
                if capability in settings:
                    return sent
            elif sent.has_failed and not settings.keys().isdisjoint(related(capability)):
                return sent
        return None

    def _changes(self, settings: Mapping[str, PlainValue], capability: str, value: PlainValue) -> bool:
        """Return whether *settings* are for another *value* of *capability*."""
        if capability in settings and self.profile.fits(capability, settings[capability], value):
            return False
        return any(changes(capability, value, name, settings[name]) for name in related(capability) if name in settings)

    def _end(self, progress: CommandProgress, fact: Decided) -> None:
        """Learn from an outcome."""
        settings, outcome = progress.order.settings, fact.outcome
        if outcome.succeeded:
            for held in self.held:
                held.confirm(settings)
        if progress.is_confirmed:
            for older in self.active:
                if older is not progress and older.is_confirmed:
                    older.release(settings.keys())
            learn_outcome(progress, self.profile, self._first)
            return
        if outcome.may_obey_later:
            learn_failure(progress, outcome, self.profile)

    def _relate(self, fact: Reported) -> None:
        """Relate a change that no command explains to what lasted as long, or drifted, or changed nearby."""
        attribution, brought = fact.attribution, self._brought.get(fact.capability)
        is_unexplained = not attribution.command or attribution.role is ReportRole.UNRELATED
        if not (is_unexplained or attribution.cause is Cause.UNKNOWN):
            return
        if is_unexplained and brought is not None and brought.is_near(fact):
            fact.drifted_from = brought.command
            return
        if not attribution.command:
            self.nearby.explain(fact, self.place, self.profile)
        if not fact.along and brought is not None:
            self._relate_to_end(fact, brought, is_explained=not is_unexplained)
        if is_unexplained and not (fact.along or fact.timed >= ENOUGH):
            is_on, _, since = self._latest.get("on_off", (True, 0.0, -math.inf))
            fact.by_program = self._programs.cause(fact, math.inf if is_on is False else since)

    def _relate_to_end(self, fact: Reported, brought: _Brought, *, is_explained: bool) -> None:
        """Relate the end of a commanded value to how long it lasted: a timer may have ended it."""
        if not self.profile.fits(fact.capability, brought.value, fact.previous):
            return
        lasted = fact.at - brought.at
        fact.timed = self.profile.learn_stay(fact.capability, fact.previous, lasted) or int(may_be_timer(lasted))
        if is_explained and fact.attribution.cause is Cause.UNKNOWN and not fact.timed:
            self.nearby.explain(fact, self.place, self.profile)
        fact.was_kept = self.profile.keeps(fact.capability, brought.value)

    def _judge(self, fact: Reported, roles: Roles) -> None:
        """Store the cause of a report, the only time that it is asked for."""
        fact.attribution = judge(fact, roles)
        is_unknown = fact.is_after_loss or fact.was_absent or fact.set_by
        if fact.is_change and fact.attribution.may_be_person and not is_unknown:
            self._relate(fact)
            fact.attribution = judge(fact, roles)
        self._record_change(fact, roles)
        if fact.timed >= ENOUGH and fact.attribution.role is ReportRole.UNDONE:
            for command, _ in roles:  # a timer ended it, unless a bridge may have told it too early
                if command.motion.moved_at > -math.inf or fact.at - fact.since > durations.TAKEN_BACK:
                    command.will_at = fact.at

    def _record_change(self, fact: Reported, roles: Roles) -> None:
        """Keep the newest changes, and the times of what may be a person's will."""
        is_change, may_be_person = fact.is_change, fact.attribution.may_be_person
        newest = self.newest.get(fact.capability)
        if is_change or fact.is_first or (newest is not None and newest.value != fact.value):  # or takes back an echo
            self.newest[fact.capability] = fact
        if is_change and may_be_person:
            self.unexplained_change = fact
        elif self.unexplained_change is fact:
            self.unexplained_change = None
        if may_be_person or fact.attribution.cause is Cause.PROGRAM:
            self._record_will(fact, roles)

    @staticmethod
    def _record_will(fact: Reported, roles: Roles) -> None:
        """Stop the repetitions of commands against what may be a person's will, or a program's."""
        is_will = fact.is_change or fact.is_news
        if not is_will and not (fact.is_first and fact.attribution.may_be_person):
            return
        for command, _ in roles:
            if is_will or command.last.get(fact.capability, fact.value) != fact.value:
                command.will_at = fact.at

    def _record_brought(self, fact: Reported, roles: Roles) -> None:
        """Remember the value that a command brought, from when on it lasts, until another value follows; or an echo."""
        capability, brought = fact.capability, self._brought.get(fact.capability)
        for command, role in roles:
            if role is ReportRole.ECHO:
                self._echoes[capability] = command, fact
            elif role is ReportRole.EFFECT and (wanted := command.wanted.get(capability)) is not None:
                if brought is None or brought.command != command.order.id:
                    at = max(fact.at if fact.is_change else -math.inf, command.transmission.sent_at)
                    self._brought[capability] = _Brought(command.order.id, wanted.value, fact.value, at)
                    if command.order.moves:
                        self._explain_rest(command, fact.at)
                return
        if brought is not None and fact.is_change and not brought.is_near(fact):
            del self._brought[capability]

    def _explain_rest(self, progress: CommandProgress, at: float) -> None:
        """Correct the cause of a cover's rest that it reported before its position."""
        for fact in reversed(self.reports):
            if fact.at < at - durations.CAME_ALONG:
                return
            if fact.attribution.may_be_person and not fact.attribution.command and rests_where_sent(fact, progress):
                self._amend(frozenset([fact.number]), progress, Cause.COMMAND, ReportRole.SIDE_EFFECT)

    def _amend(self, numbers: frozenset[int], progress: CommandProgress, cause: Cause, role: ReportRole) -> None:
        """Correct the cause of some reports."""
        for fact in self.reports:
            if fact.number in numbers and fact.attribution.command in {
                "",
                progress.order.id,
            }:  # else another explains it
                own_role = None if progress.is_raw else role
                fact.attribution = Attribution(cause, progress.order.id, own_role, progress.order.is_foreign)
                self._record_change(fact, [(progress, role)])

    def _learn(self, progress: CommandProgress, now: float) -> None:
        if not progress.is_confirmed:
            if progress.is_raw and progress.wanted and progress.is_met:
                outcome = Confirmed(now - progress.given_at, Evidence.REPORTED)
                progress.apply(Decided(progress.order.id, now, outcome), self._settle)
            elif progress.learns_late and progress.is_met:
                learn_late_answer(progress, self.profile, self._first)
        elif not progress.is_learnt and (progress.has_held or progress.undoing is not None):
            progress.is_learnt = True
            learn_settled(progress, self.profile)
            if progress.undoing is not None:
                self._undone(progress, progress.undoing)

    def _undone(self, progress: CommandProgress, undoing: Undoing) -> None:
        newest, steps, cause = self.newest.get(undoing.capability), progress.led_nowhere, Cause.UNKNOWN
        if newest is not None and newest.attribution.role is ReportRole.UNDONE:
            cause = newest.attribution.cause
        if steps:
            cause = Cause.DEVICE if undoing.capability in progress.suspected else Cause.UNKNOWN
            self._amend(steps, progress, cause, ReportRole.UNDONE)
        if progress.is_raw:
            return
        value = self.value(undoing.capability)
        if steps:  # it counted as a step
            attribution = Attribution(cause, progress.order.id, ReportRole.UNDONE)
            self._report_held(undoing.capability, value, attribution)
        self.on_undone(progress, undoing, value, cause)

    def _report_held(self, capability: str, value: PlainValue, attribution: Attribution) -> None:
        for held in tuple(self.held):
            held.report(capability, value, attribution)

    def _forget_sent(self, now: float) -> None:
        while self.sent and self.sent[0].at < now - durations.COUNTED:
            self.sent.popleft()

    def _drop_commands(self, before: float) -> None:
        """Drop the commands that ended *before* that time, and the oldest if there are too many.

        What :meth:`last_proved` returns is kept where a command failed.
        """
        commands, kept = self.commands, list[CommandProgress]()
        while commands and not commands[0].is_open:
            oldest = commands[0]
            if oldest.ended_at >= before and len(commands) <= MAX_REPORTS:
                break
            if oldest.has_failed or (kept and oldest.is_confirmed):
                names = {other for name in oldest.order.settings for other in related(name)}
                kept += [oldest] if any(self.last_proved(name) is oldest for name in names) else []
            commands.popleft()
        commands.extendleft(reversed(kept))


def _is_on_its_way(sent: CommandProgress, capability: str, now: float) -> bool:
    since, wanted = now - sent.transmission.sent_at, sent.wanted.get(capability)
    if not sent.is_open and (sent.is_confirmed or not sent.is_raw):
        if not CAPABILITIES.get(capability, OWN).comparison.moves:
            return since < sent.order.transition
        if wanted is not None and wanted.met_at is not None and sent.has_held:
            return False  # it has arrived
    return since < durations.MAX_MOVE
