"""Progress of one command: a fold of the facts of its part since. Pure.

Replaying the facts gives the same progress. The cost of a report does not depend on the number of earlier ones.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from operator import attrgetter
from typing import Final, NamedTuple, final

from homebot.control import durations
from homebot.control.timeline.facts import (
    NOTHING,
    CommandFact,
    Decided,
    Order,
    PartRef,
    Reported,
    ReportRole,
    SendingEnded,
    Sent,
    Transmission,
)
from homebot.control.timeline.goal import Motion, WantedValue, side_role
from homebot.control.timeline.profile import DeviceProfile
from homebot.devices.outcomes import Confirmed, Contradicted, NoAnswer, Outcome
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import STOPPED, changes, is_intermediate, is_same, related

_POSITIONS: Final = frozenset({"position", "tilt"})
_GIVEN_UP: Final = frozenset({"lock", "alarm"})
"""Capabilities that end their way with any other state, as a lock that jams; a cover may be open on its way."""

_NONE: Final[frozenset[str]] = frozenset()
_NO_NUMBERS: Final[frozenset[int]] = frozenset()
_MET_AT: Final = attrgetter("met_at")
_WAS_SO: Final = attrgetter("was_so")
_IS_CERTAIN: Final = attrgetter("is_certain")


class Undoing(NamedTuple):
    """The end of a confirmed value.

    Attributes:
        after: Seconds after the confirmation.
    """

    capability: str
    after: float


@final
class CommandProgress:
    """Progress of one command: the reports while it is watched, and their roles.

    It is watched until it can have no further effect. A confirmed value has to last meanwhile: another value is a
    further step of the transition, which the next one has to follow, or undoes it.

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
        until: Until when it may cause reports; inf while it is open, -inf when it cannot any more.
        may_have_effect: Whether it is open, or may have had an effect, or may have one yet.
        unsure_until: Until when a report is doubtful as the command failed; -inf if it did not.
        is_confirmed: Whether its values were reported, and have to last.
        has_held: Whether they lasted.
        undoing: The end of one of them; None if they have lasted so far.
        led_nowhere: The numbers of the reports that counted as steps, but were that end.
        learns_late: Whether an answer after its failure shows the device's response time.
        followers: The other parts that changed along with it.
        has_echo: Whether a bridge may report the wanted values before the device obeyed.
        suspected: The capabilities whose fast reports were retracted before, as a bridge's echoes are.
    """

    will_at = told_otherwise_at = -math.inf
    members: tuple[CommandProgress, ...] = ()
    fellows: Sequence[CommandProgress] = ()
    superseded_by = ""
    outcome: Outcome | None = None
    is_open = True
    ended_at = until = math.inf
    may_have_effect = True
    unsure_until = -math.inf
    learns_late = is_learnt = is_confirmed = has_held = False
    undoing: Undoing | None = None
    led_nowhere = _steps = _NO_NUMBERS
    followers: frozenset[PartRef] = frozenset()
    suspected = _NONE
    _released = _NONE  # capabilities that newer commands set
    _step = ""  # the capability of the last value that a further step has to follow
    _step_value: PlainValue = None
    _level_until = math.inf
    _settle = _steps_until = 0.0
    _fades_until = -math.inf

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
        self.wanted: dict[str, WantedValue] = {}
        for name, value in order.wanted.items():
            self.wanted[name] = WantedValue(order, name, value, known.get(name, NOTHING), profile)
        if order.turns_on:  # the wanted colour or level does not show that it is on
            self.wanted["on_off"] = WantedValue(order, "on_off", value=True, known=NOTHING, profile=profile)
        self.must_answer = answers and not self.wanted
        self._fades_out = order.settings.get("on_off") is False
        if profile.returns:
            self.suspected = frozenset(
                [name for name in order.settings if name not in order.echoed and profile.is_echo(name)]
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
        times = [wanted.met_at for wanted in self.wanted.values() if wanted.met_at is not None]
        return times or [at for member in self.members for at in member.met_times]

    @property
    def is_met_by_members(self) -> bool:
        """True if all members of a group that report its values reported the wanted ones."""
        reporting = [member for member in self.members if member.wanted]
        return bool(reporting) and all(command.is_met for command in reporting)

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
    def next_at(self) -> float:
        """The time of the next call of :meth:`advance`; inf for never."""
        is_watched = self.is_confirmed and self.until > -math.inf
        return min(self.until, self._level_until) if is_watched else math.inf

    @property
    def is_accepted(self) -> bool:
        """True if the network accepted each setting."""
        return len(self.transmission.accepted) == len(self.order.settings)

    @property
    def has_failed(self) -> bool:
        """True if the outcome is one of a command that may have had an effect, although no report says so."""
        return self.outcome is not None and self.outcome.may_obey_later and not self.is_raw

    @property
    def was_so(self) -> bool:
        """True if it was certain before that the values are the wanted ones."""
        if self.order.opens_further:
            return False
        if self.wanted:
            return all(map(_WAS_SO, self.wanted.values()))
        return all(  # of a part that reports none of them
            name in self.known and WantedValue(self.order, name, value, self.known[name], self._profile).was_so
            for name, value in self.order.settings.items()
        )

    @property
    def may_repeat(self) -> bool:
        """True while no report since the first sending, also of a member, may be a person's, or an undeclared echo."""
        undeclared = [wanted for name, wanted in self.wanted.items() if name not in self.order.echoed]
        is_stopped = any(command.will_at >= self.transmission.first_sent_at for command in (self, *self.members))
        return not (is_stopped or any(wanted.echoed_at is not None for wanted in undeclared))

    @property
    def is_mute(self) -> bool:
        """True if no part that the message was for has reported a wanted value since the first sending, or is asked."""
        wanted = (value for command in (self, *self.members, *self.fellows) for value in command.wanted.values())
        sendings = self.transmission
        return not sendings.can_be_asked and all(value.seen_at < sendings.first_sent_at for value in wanted)

    @property
    def others(self) -> dict[str, PlainValue]:
        """The reported values that differ from the wanted ones."""
        return {
            name: wanted_value.seen
            for name, wanted_value in self.wanted.items()
            if wanted_value.met_at is None and wanted_value.seen is not NOTHING
        }

    @property
    def reported(self) -> dict[str, PlainValue]:
        """The reported values that match the wanted ones."""
        wanted = self.wanted.items()
        return {
            name: wanted_value.seen
            for name, wanted_value in wanted
            if wanted_value.met_at is not None and wanted_value.seen is not NOTHING
        }

    def is_stale(self, capability: str) -> bool:
        """Return whether a value is from before the last sending, or an intermediate one."""
        wanted = self.wanted[capability]
        is_word = isinstance(wanted.seen, str) and is_intermediate(capability, wanted.value, wanted.seen)
        return is_word or wanted.seen_at < self.transmission.sent_at

    def may_be_taken_back(self, fact: Reported) -> bool:
        """Return whether *fact* may retract the wanted value, which a bridge told before the device obeyed."""
        fast_at = self.wanted[fact.capability].fast_at
        return fast_at is not None and self.motion.moved_at <= fast_at and fact.at - fact.since <= durations.TAKEN_BACK

    def apply(self, fact: CommandFact, settle: float) -> None:
        """Add the next fact about the command; a confirmed value has to last for *settle* seconds."""
        if isinstance(fact, Decided):
            self._decide(fact.outcome, fact.at, settle)
            return
        self.transmission.apply(fact)
        if self.is_raw and self.outcome is not None and isinstance(fact, Sent):  # it is told to the group again
            self.is_confirmed = self.is_learnt = False
            self.ended_at, self.until = fact.at, fact.at + durations.LATE
        if not self.wanted and isinstance(fact, SendingEnded) and fact.is_unacknowledged:
            self.must_answer = True  # a device without reports may still answer

    def supersede(self, newer: Order, now: float) -> None:
        """End the command, or the watch of some of its values, because of a *newer* command to the same part."""
        self.learns_late = False
        if not (self.is_open or self.is_confirmed or self.until > self.ended_at + durations.LATE):
            return
        touched = {
            own
            for own, held in self.order.settings.items()
            for capability, value in newer.settings.items()
            if own == capability or (own in related(capability) and changes(own, held, capability, value))
        }
        if not touched:
            return
        if self.is_open:
            self.superseded_by, self.is_open = newer.id, False
            self.ended_at, self.until = now, now + durations.SUPERSEDED
        elif self.is_confirmed:
            self.release(touched)
        else:
            self.until = min(self.until, self.ended_at + durations.LATE)

    def release(self, capabilities: AbstractSet[str]) -> None:
        """Watch *capabilities* no longer, because a newer command sets them."""
        self._released |= capabilities
        if self._released >= self.order.settings.keys():
            self.until = -math.inf

    def advance(self, now: float) -> None:
        """End the watch of confirmed values: the last step, if another one did not follow it in time, undid them."""
        if now < self.next_at:
            return
        if self._step:
            self._undo(self._step, self.next_at)
        else:
            self.has_held, self.until = True, -math.inf

    def report(self, fact: Reported) -> ReportRole:
        """Record a live report, and return its role, which nothing else decides."""
        capability, value, wanted = fact.capability, fact.value, self.wanted.get(fact.capability)
        if value == STOPPED:
            self.motion.stopped_at = fact.at
        has_failed = not (self.is_open or self.is_confirmed)
        is_late = has_failed and (fact.at > self.ended_at + durations.LATE or self.will_at > -math.inf)
        if self.superseded_by or is_late or capability in self._released:
            return self._late_role(wanted, fact, is_exact=is_late)
        if value is None:
            return ReportRole.MATCHES  # a lost value proves nothing
        if wanted is None or (capability == "level" and self._fades_out):
            return self._side_role(fact)
        if self.is_confirmed:
            return self._confirmed_role(wanted, fact)
        if wanted.fits(value) and wanted.is_told(value):
            return self._arrival(wanted, fact)
        return self._departure(wanted, fact)

    def _arrival(self, wanted: WantedValue, fact: Reported) -> ReportRole:
        """Return the role of the wanted value while the command is open, or had no answer."""
        if self.transmission.group.echoed and self._is_of_group(fact) and not self.members:
            wanted.seen = NOTHING if wanted.met_at is None else wanted.seen  # the part itself is still to be heard
            return ReportRole.ECHO
        if not (self.has_echo and self._is_echo(wanted, fact)):
            wanted.meet(fact, self.transmission.sent_at)
            return ReportRole.EFFECT
        if not wanted.is_answered and wanted.met_at is None:
            wanted.seen = NOTHING  # it was reported before the bridge had the command
        return ReportRole.ECHO

    def _decide(self, outcome: Outcome, now: float, settle: float) -> None:
        self.outcome, self.is_open = outcome, False
        if not self.superseded_by:
            self.ended_at = now
        self.may_have_effect = self.transmission.count > 0 and (outcome.succeeded or outcome.may_obey_later)
        if outcome.may_obey_later and not self.is_raw:  # if it is contradicted, a report since the sending is certain
            self.unsure_until = self.transmission.sent_at if isinstance(outcome, Contradicted) else self.ended_at
        if self.superseded_by:
            return
        if isinstance(outcome, Confirmed):
            self.is_confirmed, self.has_held, self.undoing, self._released = True, False, None, _NONE
            self._settle, self.until = settle, now + settle + self.order.transition
            self._fades_until = now + self.order.transition if self.order.has_ramp else -math.inf
            self._steps_until = now + self.order.transition + durations.LAST_STEPS
            if self._step:
                self._end_steps(self._step)
        else:
            is_silent = isinstance(outcome, NoAnswer) and not (outcome.reason or self.is_raw)
            is_sent = self.transmission.count > 0
            self.until = now + (durations.ASLEEP if is_silent else durations.LATE) if is_sent else -math.inf

    def _late_role(self, wanted: WantedValue | None, fact: Reported, *, is_exact: bool) -> ReportRole:
        """Return the role of a report after a newer command, or long after the last sending: only the first effect."""
        if is_exact:
            self.learns_late = False
        if wanted is None or wanted.met_at is not None:
            return ReportRole.SIDE_EFFECT
        is_same_value = is_same(fact.capability, wanted.value, fact.value) and self.will_at == -math.inf
        if not (is_same_value if is_exact else wanted.fits(fact.value)):
            return ReportRole.SIDE_EFFECT
        wanted.met_at = fact.at
        return ReportRole.EFFECT

    def _side_role(self, fact: Reported) -> ReportRole:
        """Return the role of a report of another capability, or of the level of a lamp that is told off."""
        capability, value = fact.capability, fact.value
        is_nearer = self.motion.approaches(capability, value, fact.at)
        if not (self.is_confirmed and self._fades_out and capability == "level"):
            return ReportRole.STEP if is_nearer else side_role(self.order, capability, value)
        if not self._step:  # it did not report that it is on again
            return ReportRole.STEP if is_nearer else ReportRole.MATCHES
        self._judge_fade(fact.at)
        return self._step_role(fact)

    def _departure(self, wanted: WantedValue, fact: Reported) -> ReportRole:
        """Return the role of another value than the wanted one while the command is open, or had no answer."""
        capability, value, before = fact.capability, fact.value, wanted.seen
        is_nearer, was_met = self.motion.approaches(capability, value, fact.at), wanted.met_at is not None
        wanted.depart(fact)
        if is_nearer or is_intermediate(capability, wanted.value, value):
            self.motion.moved_at = fact.at
            wanted.is_step = True
            return ReportRole.DEVIATES if self._is_astray(wanted, fact, before) else ReportRole.STEP
        self.told_otherwise_at = fact.at
        if wanted.is_step and capability in _GIVEN_UP:
            self.motion.stopped_at = fact.at
        if before == value:
            return ReportRole.UNDONE if was_met else ReportRole.REPEAT
        wanted.is_step = False
        return ReportRole.UNDONE if was_met or self._was_echoed(wanted, fact) else ReportRole.UNRELATED

    def _confirmed_role(self, wanted: WantedValue, fact: Reported) -> ReportRole:
        """Return the role of a report after the confirmation: another value is a step, or the end of the wanted one."""
        capability, value, now = fact.capability, fact.value, fact.at
        if wanted.fits(value):
            if self.members:
                self._is_of_group(fact)  # those of its members follow
            self._end_steps(capability)
            wanted.refine(value)
            return ReportRole.EFFECT
        is_on_again = capability == "on_off" and self._fades_out
        may_fade = is_on_again and (now < self._fades_until or self.motion.has_level)
        if not (may_fade or self._may_move_on(wanted, fact)):
            self._undo(capability, now)
            return ReportRole.UNDONE
        if (self._step, self._step_value) != (capability, value):
            self._step, self._step_value = capability, value
            self._steps_until = max(self._steps_until, now + durations.LAST_STEPS)
            self._wait_on(now)
            self._level_until = max(now, self._fades_until) + durations.LEVEL_FOLLOWS if may_fade else math.inf
            if self._fades_out:
                self._judge_fade(now)
        return self._step_role(fact)

    def _may_move_on(self, wanted: WantedValue, fact: Reported) -> bool:
        """Return whether a dimmer or a motor that reported the wanted value may still be on its way there."""
        capability, value = fact.capability, fact.value
        if is_intermediate(capability, wanted.value, value):
            return True
        if fact.at > self._steps_until or not (isinstance(wanted.value, float) and isinstance(value, float)):
            return False
        if capability == "level" and self.order.turns_on and value < wanted.value:
            return True  # it fades in from 0
        before = self.known.get(capability)
        if not isinstance(before, float):
            return self.motion.may_pass(capability, value)
        return min(before, wanted.value) < value < max(before, wanted.value)

    def _judge_fade(self, at: float) -> None:
        """Judge by its level whether a lamp that is on again fades out, or was turned on."""
        sign = self.motion.fade_sign(at)
        if sign == "back" and at < self._fades_until:
            self._level_until = min(self._level_until, max(at + durations.LEVEL_FOLLOWS, self._fades_until))
        elif sign == "back":
            self._undo(self._step, at)
        elif sign == "fading":
            self._level_until = math.inf
            self._wait_on(at)

    def _wait_on(self, now: float) -> None:
        self.until = max(self.until, min(now + self._settle, self.ended_at + durations.MAX_MOVE))

    def _step_role(self, fact: Reported) -> ReportRole:
        if self.undoing is not None:
            return ReportRole.UNDONE
        self._steps |= {fact.number}
        return ReportRole.STEP

    def _end_steps(self, capability: str) -> None:
        if self._step == capability:
            self._step, self._step_value, self._level_until, self._steps = "", None, math.inf, _NO_NUMBERS

    def _undo(self, capability: str, at: float) -> None:
        self.led_nowhere, self._steps = self._steps, _NO_NUMBERS
        self.undoing = Undoing(capability, at - self.ended_at)
        is_awaited = self.members and not self.is_met_by_members  # a group whose other members are still to follow
        self.until = at + self._settle if is_awaited else -math.inf

    def _was_echoed(self, wanted: WantedValue, fact: Reported) -> bool:
        """Return whether a bridge repeated the wanted value since the last sending, or the message to the group."""
        is_own = wanted.echoed_at is not None and wanted.echoed_at >= self.transmission.sent_at
        told_at = self._told_of_group.get(fact.capability, -math.inf)
        return is_own or (told_at > -math.inf and (not self.is_raw or fact.at - told_at <= durations.UNREAD))

    def _is_astray(self, wanted: WantedValue, fact: Reported, before: object) -> bool:
        if not isinstance(before, float):
            before = self.last.get(fact.capability)
        goal, value = wanted.value, fact.value
        if fact.capability not in _POSITIONS or not (
            isinstance(goal, float) and isinstance(value, float) and isinstance(before, float)
        ):
            return False
        is_beyond = (value - goal) * (before - goal) < 0  # a motor runs one way
        return is_beyond or abs(value - goal) > abs(before - goal)

    def _is_of_group(self, fact: Reported) -> bool:
        """Return whether a report of the wanted value repeats the message to its group."""
        sendings = self.transmission
        is_message = self.is_raw or sendings.count == 1  # a repetition goes to the part alone
        if not (is_message and sendings.group.is_echo(fact.capability, fact.at, sendings.sent_at)):
            return False
        told_at = self._told_of_group.get(fact.capability, -math.inf)
        if told_at < sendings.sent_at:
            told_at = self._told_of_group[fact.capability] = fact.at
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
