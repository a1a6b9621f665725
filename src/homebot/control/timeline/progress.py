"""Progress of one command: a fold of the facts of its part since. Pure.

Replaying the facts gives the same progress. The cost of a report does not depend on the number of earlier ones.
"""

import math
from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Final, final

from homebot.control import durations
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
from homebot.control.timeline.goal import NOTHING, Motion, WantedValue, side_role
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.settling import Settling
from homebot.control.timeline.transmission import Transmission
from homebot.devices.obedience import STOPPED, changes, is_intermediate, is_same, related
from homebot.devices.outcomes import Confirmed, NoAnswer, Outcome
from homebot.devices.value import PlainValue

_POSITIONS: Final = frozenset({"position", "tilt"})
_GIVEN_UP: Final = frozenset({"lock", "alarm"})
"""Capabilities that end their way with any other state, as a lock that jams; a cover may be open on its way."""

_NONE: Final[frozenset[str]] = frozenset()
_MET_AT: Final = attrgetter("met_at")
_WAS_SO: Final = attrgetter("was_so")
_IS_CERTAIN: Final = attrgetter("is_certain")


@final
class CommandProgress:
    """Progress of one command: the reports since, and their roles.

    Args:
        last: The values that the part last reported before, certain or not.
        answers: Whether the device is known to answer commands.
        is_raw: Whether it has no outcome here: a raw text, or a command to a group of which the part is a member.

    Attributes:
        transmission: Its sendings, and the answers of the network.
        wanted: The values that the part should report, and its reports of them.
        motion: The way of the part to them.
        will_at: When the last report came that may be a person's; -inf for none.
        members: The same command for the members of a group.
        fellows: The commands for which one message was sent, this one among them; empty if it was sent by itself.
        told_otherwise_at: When another value was last reported without movement; -inf for never.
        superseded_by: The id of the newer command that replaced it; empty if none did.
        must_answer: Whether the device answers commands but reports no values, so its answer is awaited.
        is_open: Whether its outcome is not decided yet, and no newer command replaced it.
        ended_at: When its outcome was decided, or it was superseded; inf before.
        late_until: Until when an answer after its failure may come.
        learns_late: Whether an answer after its failure shows the device's response time.
        followers: The other parts that changed along with it.
        has_echo: Whether a bridge may report the wanted values before the device obeyed.
        suspected: The capabilities whose fast reports were retracted before, as a bridge's echoes are.
    """

    def __init__(
        self,
        order: Order,
        at: float,
        known: Mapping[str, PlainValue],
        last: Mapping[str, PlainValue],
        profile: DeviceProfile,
        *,
        answers: bool = False,
        is_raw: bool = False,
    ) -> None:
        self.order, self.known, self.last, self.is_raw = order, known, last, is_raw
        self.given_at = at
        self.transmission = Transmission(at)
        self.motion = Motion(order, last)
        self.wanted = {
            name: WantedValue(order, name, value, known.get(name, NOTHING), profile)
            for name, value in order.wanted.items()
        }
        if order.turns_on:  # the wanted colour or level does not show that it is on
            self.wanted["on_off"] = WantedValue(order, "on_off", value=True, known=NOTHING, profile=profile)
        self.will_at = -math.inf
        self.members: tuple[CommandProgress, ...] = ()
        self.fellows: Sequence[CommandProgress] = ()
        self.told_otherwise_at = -math.inf
        self.superseded_by = ""
        self.must_answer = answers and not self.wanted
        self.learns_late = self.is_learnt = False
        self.is_open, self.ended_at = True, math.inf
        self.late_until = math.inf
        self.outcome: Outcome | None = None
        self.settling: Settling | None = None
        self.followers: frozenset[PartRef] = frozenset()
        self.suspected = _NONE
        if profile.returns:
            self.suspected = frozenset(
                [one for one in order.settings if one not in order.echoed and profile.is_echo(one)]
            )
        self.has_echo = bool(order.echoed or self.suspected)
        self._profile = profile
        self._told_of_group: dict[str, float] = {}  # when a bridge repeated the message to a group, by capability

    @property
    def is_met(self) -> bool:
        """True if the device reported all wanted values; at once if it reports none of them."""
        if self.must_answer:
            return self.is_accepted
        return None not in map(_MET_AT, self.wanted.values())

    @property
    def met_times(self) -> list[float]:
        """The time of the first report of each wanted value that is still reported."""
        times = [one.met_at for one in self.wanted.values() if one.met_at is not None]
        return times or [at for one in self.members for at in one.met_times]

    @property
    def is_met_by_members(self) -> bool:
        """True if all members of a group that report its values reported the wanted ones."""
        reporting = [one for one in self.members if one.wanted]
        return bool(reporting) and all(one.is_met for one in reporting)

    @property
    def over_at(self) -> float:
        """The time from which no report can improve the outcome; inf if one still can.

        Matter nodes and Hue bridges report only changes: a lamp that had the wanted level when it went off reports only
        "on". Values that were certain before are awaited for as long as a level may follow.
        """
        if self.superseded_by or self.transmission.refusal:
            return -math.inf
        if self.must_answer:
            return -math.inf if self.is_accepted else math.inf
        if self.members and self.is_met_by_members:
            return -math.inf
        times = [*map(_MET_AT, self.wanted.values())]
        if None not in times:
            return -math.inf
        if times.count(None) == len(times) or not all(map(_IS_CERTAIN, self.wanted.values())):
            return math.inf
        return max(self.met_times) + durations.LEVEL_FOLLOWS

    @property
    def is_accepted(self) -> bool:
        """True if the network accepted each setting."""
        return len(self.transmission.accepted) == len(self.order.settings)

    @property
    def was_so(self) -> bool:
        """True if it was certain before that the values are the wanted ones."""
        wanted = self.wanted
        were_so = all(map(_WAS_SO, wanted.values())) if wanted else self._settings_were_so()
        return were_so and not self.order.opens_further

    @property
    def may_repeat(self) -> bool:
        """True while no report since the first sending, also of a member, may be a person's, or an undeclared echo."""
        undeclared = [one for name, one in self.wanted.items() if name not in self.order.echoed]
        is_stopped = any(one.will_at >= self.transmission.first_sent_at for one in (self, *self.members))
        return not (is_stopped or any(one.echoed_at is not None for one in undeclared))

    @property
    def is_mute(self) -> bool:
        """True if no part that the message was for has reported a wanted value since the first sending, or is asked."""
        wanted = (value for command in (self, *self.members, *self.fellows) for value in command.wanted.values())
        sendings = self.transmission
        return not sendings.can_be_asked and all(one.seen_at < sendings.first_sent_at for one in wanted)

    @property
    def others(self) -> dict[str, PlainValue]:
        """The reported values that differ from the wanted ones."""
        return {name: one.seen for name, one in self.wanted.items() if one.met_at is None and one.seen is not NOTHING}

    @property
    def reported(self) -> dict[str, PlainValue]:
        """The reported values that match the wanted ones."""
        wanted = self.wanted.items()
        return {name: one.seen for name, one in wanted if one.met_at is not None and one.seen is not NOTHING}

    def is_stale(self, capability: str) -> bool:
        """Return whether a value is from before the last sending, or an intermediate one."""
        wanted = self.wanted[capability]
        is_word = isinstance(wanted.seen, str) and is_intermediate(capability, wanted.value, wanted.seen)
        return is_word or wanted.seen_at < self.transmission.sent_at

    def covers(self, at: float) -> bool:
        """Return whether the command may have caused a report at that time."""
        if self.is_open:
            return True
        if self.superseded_by:
            return at <= self.ended_at + durations.SUPERSEDED
        if self.settling is not None:
            return not self.settling.is_over and at <= self.settling.until
        return self.transmission.count > 0 and at <= self.late_until

    def apply(self, fact: CommandFact, settle: float) -> None:
        """Add the next fact about the command; a confirmed value has to last for *settle* seconds."""
        if isinstance(fact, Decided):
            self._decide(fact.outcome, fact.at, settle)
            return
        self.transmission.apply(fact)
        if isinstance(fact, Sent) and self.is_raw and self.outcome is not None:  # it is told to the group again
            self.settling, self.is_learnt, self.ended_at = None, False, fact.at
            self.late_until = fact.at + durations.LATE
        if isinstance(fact, SendingEnded) and fact.is_unacknowledged and not self.wanted:
            self.must_answer = True  # a device without reports may still answer

    def supersede(self, newer: Order, now: float) -> None:
        """End the command, or the watch of some of its values, because of a *newer* command to the same part."""
        self.learns_late = False
        if not self.is_open and self.settling is None and self.late_until <= self.ended_at + durations.LATE:
            return
        touched = {
            own
            for own, held in self.order.settings.items()
            for capability, value in newer.settings.items()
            if own == capability or (own in related(capability) and changes(own, held, capability, value))
        }
        if not touched:
            return
        self.late_until = min(self.late_until, self.ended_at + durations.LATE)
        if self.settling is not None:
            self.settling.release(touched, now)
        elif self.is_open:
            self.superseded_by, self.is_open, self.ended_at = newer.id, False, now

    def report(self, fact: Reported) -> ReportRole:
        """Record a live report, and return its role."""
        return self._role_of(fact)

    def _decide(self, outcome: Outcome, now: float, settle: float) -> None:
        self.outcome, self.is_open, self.ended_at = outcome, False, min(self.ended_at, now)
        is_silent = isinstance(outcome, NoAnswer) and not (outcome.reason or self.is_raw)
        self.late_until = self.ended_at + (durations.ASLEEP if is_silent else durations.LATE)
        if isinstance(outcome, Confirmed):
            self.settling = Settling(self.order, self.wanted, self.known, self.last, now, settle)

    def _settings_were_so(self) -> bool:
        """Return whether the settings were certain before, if the part reports none of them."""
        known, settings = self.known, self.order.settings
        return all(
            name in known and WantedValue(self.order, name, value, known[name], self._profile).was_so
            for name, value in settings.items()
        )

    def _role_of(self, fact: Reported) -> ReportRole:
        if fact.value == STOPPED:
            self.motion.stopped_at = fact.at
        wanted = self.wanted.get(fact.capability)
        if self.superseded_by:
            return _superseded_role(wanted, fact)
        if fact.value is None:
            return ReportRole.AGREES  # a lost value proves nothing
        if self.settling is not None:
            return self.settling.report(fact)
        if fact.at > self.ended_at + durations.LATE:
            return self._late_role(wanted, fact)
        return self._other_role(fact) if wanted is None else self._wanted_role(wanted, fact)

    def _late_role(self, wanted: WantedValue | None, fact: Reported) -> ReportRole:
        """Return the role of a report long after a command without an answer: only the exact value is its effect."""
        self.learns_late = False
        if wanted is None:
            return ReportRole.ASIDE
        is_open = wanted.met_at is None and self.will_at == -math.inf
        if is_open and is_same(fact.capability, wanted.value, fact.value):
            wanted.met_at = fact.at
            return ReportRole.EFFECT
        return ReportRole.ASIDE

    def _wanted_role(self, wanted: WantedValue, fact: Reported) -> ReportRole:
        if not wanted.shows_obedience(fact.value):
            return self._not_met(wanted, fact)
        if self.transmission.echoed and self._is_of_group(fact):
            wanted.seen = NOTHING if wanted.met_at is None else wanted.seen  # the part itself is still to be heard
            return ReportRole.ECHO
        if not (self.has_echo and self._is_echo(wanted, fact)):
            wanted.meet(fact, self.transmission.sent_at)
            return ReportRole.EFFECT
        if not wanted.is_answered and wanted.met_at is None:
            wanted.seen = NOTHING  # it was reported before the bridge had the command
        return ReportRole.ECHO

    def _not_met(self, wanted: WantedValue, fact: Reported) -> ReportRole:
        capability, value, before = fact.capability, fact.value, wanted.seen
        is_nearer, was_met = self.motion.approaches(capability, value), wanted.met_at is not None
        wanted.depart(fact)
        if is_nearer or is_intermediate(capability, wanted.value, value):
            self.motion.moved_at = fact.at
            wanted.is_step = True
            return ReportRole.ASTRAY if self._is_astray(wanted, fact, before) else ReportRole.STEP
        self.told_otherwise_at = fact.at
        if wanted.is_step and capability in _GIVEN_UP:
            self.motion.stopped_at = fact.at
        if before == value:
            return ReportRole.UNDONE if was_met else ReportRole.REPEAT
        wanted.is_step = False
        return ReportRole.UNDONE if was_met or self._was_echoed(wanted, fact) else ReportRole.OTHERWISE

    def _was_echoed(self, wanted: WantedValue, fact: Reported) -> bool:
        """Return whether a bridge repeated the wanted value since the last sending, or the message to the group."""
        is_own = wanted.echoed_at is not None and wanted.echoed_at >= self.transmission.sent_at
        told_at = self._told_of_group.get(fact.capability, -math.inf)
        return is_own or (told_at > -math.inf and (not self.is_raw or fact.at - told_at <= durations.UNREAD))

    def _other_role(self, fact: Reported) -> ReportRole:
        capability, value = fact.capability, fact.value
        if self.motion.approaches(capability, value):
            self.motion.moved_at = fact.at
            return ReportRole.STEP
        return side_role(self.order, capability, value)

    def _is_astray(self, wanted: WantedValue, fact: Reported, before: object) -> bool:
        if not isinstance(before, float):
            before = self.last.get(fact.capability)
        goal, value = wanted.value, fact.value
        if fact.capability not in _POSITIONS or not (
            isinstance(goal, float) and isinstance(value, float) and isinstance(before, float)
        ):
            return False
        return abs(value - goal) > abs(before - goal)

    def _is_of_group(self, fact: Reported) -> bool:
        """Return whether a report of the wanted value repeats the message to its group."""
        if self.transmission.count != 1 or fact.capability not in self.transmission.echoed:
            return False
        told_at = self._told_of_group.setdefault(fact.capability, fact.at)
        return fact.at - told_at <= durations.SAME_MESSAGE

    def _is_echo(self, wanted: WantedValue, fact: Reported) -> bool:
        """Return whether a report of the wanted value is the bridge's echo; each sending has one."""
        sent_at = self.transmission.sent_at
        if wanted.echoed_at is not None and wanted.echoed_at >= sent_at:
            return fact.at - wanted.echoed_at <= durations.SAME_MESSAGE
        is_fast = fact.at - sent_at <= durations.FAST
        if fact.capability not in self.order.echoed and not (is_fast and fact.capability in self.suspected):
            return False
        wanted.echo(fact.at, is_fast=is_fast)
        return True


def _superseded_role(wanted: WantedValue | None, fact: Reported) -> ReportRole:
    if wanted is None or wanted.met_at is not None or not wanted.fits(fact.value):
        return ReportRole.ASIDE
    wanted.met_at = fact.at
    return ReportRole.EFFECT
