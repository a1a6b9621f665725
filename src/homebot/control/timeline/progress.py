"""Progress of one command: the role of each report since, updated with each fact. Pure.

It is a function of the facts of its part: feeding them once more gives the same progress. The cost of a report does not
depend on the number of earlier ones.
"""

from __future__ import annotations

import math
from typing import Final, final

from homebot.control import durations
from homebot.control.timeline.facts import Commanded, Order, Reported, ReportRole
from homebot.control.timeline.goal import Motion, WantedValues
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.settling import Settling
from homebot.control.values import POWERS, STOPPED, changes, is_intermediate, related
from homebot.devices.outcomes import Confirmed, Outcome
from homebot.devices.value import PlainValue

__all__ = ["CommandProgress"]

_NOTHING: Final = object()
_TURNED: Final = POWERS | {"fan_mode"}
"""Capabilities by which a person turns a part on or off against a command."""

_POSITIONS: Final = frozenset({"position", "tilt"})


@final
class CommandProgress:
    """Progress of one command: the reports since, and their roles.

    Args:
        fact: The command.
        profile: Knowledge of the device before this command.

    Attributes:
        order: The command.
        given_at: When it was given.
        wanted: The values that the part is to report.
        known: The values that were certain before.
        last: The values that were reported last before.
        roles: The role of each report, by its number.
        seen: The values that the device reported since, by capability.
        fitting: When each wanted value was reported first, if it still is.
        echoed: When the last echo of each capability came.
        fast: When each capability was reported so fast that it may be an echo.
        returned: After how many seconds another value followed a fast report, before the outcome.
        sendings: How often it was sent.
        first_sent_at: When it was first sent.
        sent_at: When it was last sent.
        moved_at: When the device was last seen on its way; None if it was not.
        stopped_at: When a motor last reported that it stopped; -inf if it did not.
        told_otherwise_at: When another value was last reported, and no movement; -inf for never.
        superseded_by: The id of the newer command that replaced it; empty if none did.
        refusal: The reason why the device refuses it; empty if it does not.
        must_answer: Whether the device answers commands, so that its answer is waited for.
        ended_at: When its outcome was decided, or it was superseded; inf before.
        outcome: Its outcome, once decided.
        settling: The judgement of later reports, once confirmed.
        learns_late: Whether an answer after its failure teaches how long the device takes.
        is_witnessed: Whether a second device observed the effect.
        is_learnt: Whether the profile knows how the confirmed value ended.
        is_raw: Whether it is a raw text, of which no outcome is awaited.
    """

    def __init__(self, fact: Commanded, profile: DeviceProfile) -> None:
        order = fact.order
        self.order: Order = order
        self.given_at = self.first_sent_at = self.sent_at = fact.at
        self.known, self.last = fact.known, fact.last
        self._values = WantedValues(order, fact.known, profile)
        self.wanted = self._values.by_capability
        self.roles: dict[int, ReportRole] = {}
        self.seen: dict[str, PlainValue] = {}
        self.fitting: dict[str, float] = {}
        self.echoed: dict[str, float] = {}
        self.fast: dict[str, float] = {}
        self.returned: dict[str, float] = {}
        self.accepted: dict[str, float] = {}
        self.sendings = 0
        self.moved_at: float | None = None
        self.stopped_at = self.told_otherwise_at = -math.inf
        self.superseded_by = self.refusal = ""
        self.must_answer = self.learns_late = self.is_witnessed = self.is_learnt = False
        self.ended_at = math.inf
        self.outcome: Outcome | None = None
        self.settling: Settling | None = None
        self.suspected = frozenset([one for one in order.settings if one not in order.echoed and profile.is_echo(one)])
        self.usual_returns = {one: after for one in self.wanted if (after := profile.usual_return(one)) is not None}
        self.is_raw = fact.is_raw
        self._profile = profile
        self._motion = Motion(order, fact.last)
        self._is_fade = False
        self._echoed_since_sent: dict[str, float] = {}
        self._answered: set[str] = set()
        self._seen_before: set[str] = set()  # by the last sending
        self._stepping: set[str] = set()
        self._overruled: set[str] = set()  # capabilities with a new value that is not the wanted one
        self._opposed: set[str] = set()  # further ones with a new value that the command contradicts

    @property
    def is_met(self) -> bool:
        """True if the device reported all wanted values; at once if it reports none of them."""
        if self.must_answer and not self.wanted:
            return self.is_accepted
        return len(self.fitting) == len(self.wanted)

    @property
    def is_over(self) -> bool:
        """True if no report can make the outcome any better."""
        return bool(self.superseded_by or self.refusal) or self.is_met

    @property
    def is_open(self) -> bool:
        """True if its outcome is not decided yet."""
        return self.outcome is None and not self.superseded_by

    @property
    def is_accepted(self) -> bool:
        """True if the network accepted each setting."""
        return len(self.accepted) == len(self.order.settings)

    @property
    def was_so(self) -> bool:
        """True if the values were certain to be the wanted ones before."""
        return self._values.were_so

    @property
    def has_echo(self) -> bool:
        """True if a bridge may report the wanted values before the device obeyed."""
        return bool(self.order.echoed or self.suspected)

    @property
    def has_faded(self) -> bool:
        """True if it is a dimmer that was seen on its way."""
        return self._is_fade and self.moved_at is not None

    @property
    def has_stopped(self) -> bool:
        """True if it is a motor that was seen on its way, and then reported that it stopped."""
        return self.moved_at is not None and self.moved_at - self.stopped_at <= durations.SAME_MESSAGE

    @property
    def is_overruled(self) -> bool:
        """True if the newest report is neither the wanted value nor that from before: a person, or its own answer."""
        is_suspect = any(one not in self.order.echoed for one in self.echoed)
        return is_suspect or bool(self._opposed) or not self._overruled <= self.order.echoed

    @property
    def others(self) -> dict[str, PlainValue]:
        """The reported values that are not the wanted ones."""
        return {name: value for name, value in self.seen.items() if name not in self.fitting}

    def is_stale(self, capability: str) -> bool:
        """Return whether a value is from before the last sending, or a word on the way."""
        value = self.seen[capability]
        is_word = isinstance(value, str) and is_intermediate(capability, self.wanted[capability], value)
        return is_word or capability in self._seen_before

    def covers(self, at: float) -> bool:
        """Return whether a report at that time may be due to it."""
        if self.is_open:
            return True
        if self.superseded_by:
            return at <= self.ended_at + durations.SUPERSEDED
        if self.settling is not None:
            return not self.settling.is_over and at <= self.settling.until
        return self.sendings > 0 and at <= self.ended_at + durations.LATE

    def send(self, now: float) -> None:
        """Record that it is sent."""
        self.sent_at = now
        self.first_sent_at = now if self.sendings == 0 else self.first_sent_at
        self.sendings += 1
        self._seen_before.update(self.seen)
        self._echoed_since_sent.clear()

    def accept(self, capability: str, at: float) -> None:
        """Record that the network accepted one setting."""
        if capability in self.order.settings:
            self.accepted.setdefault(capability, at)

    def refuse(self, reason: str) -> None:
        """Record that the device refuses it."""
        self.refusal = self.refusal or reason

    def decide(self, outcome: Outcome, now: float, settle: float) -> None:
        """Record the outcome; a confirmed one has to hold for *settle* seconds."""
        self.outcome, self.ended_at = outcome, min(self.ended_at, now)
        if isinstance(outcome, Confirmed):
            self.settling = Settling(self, now, settle)

    def supersede(self, newer: Order, now: float) -> None:
        """End it, or the watch of some values after it, for a *newer* command to the same part."""
        self.learns_late = False
        touched = {
            other
            for capability, value in newer.settings.items()
            for other in related(capability)
            if other in self.order.settings
            and (other == capability or changes(other, self.order.settings[other], capability, value))
        }
        if not touched:
            return
        if self.settling is not None:
            self.settling.release(touched, now)
        elif self.outcome is None and not self.superseded_by:
            self.superseded_by, self.ended_at = newer.id, now

    def report(self, fact: Reported) -> ReportRole:
        """Record a live report, and return its role."""
        role = self.roles[fact.number] = self._role_of(fact)
        return role

    def fits(self, capability: str, value: PlainValue) -> bool:
        """Return whether *value* is the wanted one, as the device rounds."""
        return self._values.fits(capability, value)

    def refine(self, capability: str, value: PlainValue) -> None:
        """Record that a confirmed value is now reported as *value*: the device's own answer."""
        self.seen[capability] = value
        self._profile.learn_answer(capability, self.wanted[capability], value)

    def side_role(self, capability: str, value: PlainValue) -> ReportRole:
        """Return the role of a report of a capability that is not wanted."""
        settings = self.order.settings
        if STOPPED in settings.values():
            return ReportRole.AGREES
        own = [one for one in related(capability) if one in settings and one != capability]
        is_against = any(changes(capability, value, one, settings[one]) for one in own)
        return ReportRole.ASIDE if is_against else ReportRole.AGREES

    def _role_of(self, fact: Reported) -> ReportRole:
        if fact.value == STOPPED:
            self.stopped_at = fact.at
        if self.superseded_by:
            return self._superseded_role(fact)
        if self.settling is not None:
            return self.settling.report(fact)
        if fact.capability in self.wanted:
            return self._wanted_role(fact)
        return self._other_role(fact)

    def _superseded_role(self, fact: Reported) -> ReportRole:
        capability = fact.capability
        if capability in self.wanted and capability not in self.fitting and self.fits(capability, fact.value):
            self.fitting[capability] = fact.at
            return ReportRole.EFFECT
        return ReportRole.ASIDE

    def _wanted_role(self, fact: Reported) -> ReportRole:
        capability, value = fact.capability, fact.value
        if self._values.shows_obedience(capability, value):
            if self.has_echo and self._is_echo(capability, fact.at):
                if capability not in self._answered and capability not in self.fitting:
                    self.seen.pop(capability, None)  # it was reported before the bridge had the command
                return ReportRole.ECHO
            return self._met(fact)
        return self._not_met(fact)

    def _met(self, fact: Reported) -> ReportRole:
        capability = fact.capability
        self._see(fact)
        if fact.at - self.sent_at <= durations.FAST and capability not in self.fitting:
            self.fast[capability] = fact.at
        self.fitting.setdefault(capability, fact.at)
        self._stepping.discard(capability)
        self._overruled.discard(capability)
        return ReportRole.EFFECT

    def _not_met(self, fact: Reported) -> ReportRole:
        capability, value = fact.capability, fact.value
        before, is_nearer = self.seen.get(capability, _NOTHING), self._is_nearer(capability, value)
        was_met = self.fitting.pop(capability, None) is not None
        self._see(fact)
        if capability in self.fast:
            self.returned.setdefault(capability, fact.at - self.fast[capability])
        if is_nearer or is_intermediate(capability, self.wanted[capability], value):
            self.moved_at = fact.at
            self._stepping.add(capability)
            self._overruled.discard(capability)
            return ReportRole.ASTRAY if self._is_astray(capability, value, before) else ReportRole.STEP
        self.told_otherwise_at = fact.at
        is_repeated = before == value
        if not is_repeated:
            is_new = capability in self._stepping or self.last.get(capability, value) != value
            self._stepping.discard(capability)
            (self._overruled.add if is_new else self._overruled.discard)(capability)
        if was_met or (capability in self._echoed_since_sent and not is_repeated):
            return ReportRole.UNDONE
        return ReportRole.REPEAT if is_repeated else ReportRole.OTHERWISE

    def _see(self, fact: Reported) -> None:
        if fact.capability in self.echoed:
            self._answered.add(fact.capability)
        self.seen[fact.capability] = fact.value
        self._seen_before.discard(fact.capability)

    def _other_role(self, fact: Reported) -> ReportRole:
        capability, value = fact.capability, fact.value
        if self._is_nearer(capability, value):
            self.moved_at = fact.at
            return ReportRole.STEP
        role = self.side_role(capability, value)
        is_against = role is ReportRole.ASIDE and capability in _TURNED and self.last.get(capability, value) != value
        (self._opposed.add if is_against else self._opposed.discard)(capability)
        return role

    def _is_nearer(self, capability: str, value: PlainValue) -> bool:
        is_nearer = self._motion.shows(capability, value)
        if capability == "level":
            self._is_fade = self._is_fade or is_nearer
        return is_nearer

    def _is_astray(self, capability: str, value: PlainValue, before: object) -> bool:
        wanted = self.wanted[capability]
        if not isinstance(before, float):
            before = self.last.get(capability)
        if capability not in _POSITIONS or not (
            isinstance(wanted, float) and isinstance(value, float) and isinstance(before, float)
        ):
            return False
        return abs(value - wanted) > abs(before - wanted)

    def _is_echo(self, capability: str, now: float) -> bool:
        """Return whether a report of the wanted value is the bridge's; each sending has one."""
        echoed_at = self._echoed_since_sent.get(capability)
        if echoed_at is not None:
            return now - echoed_at <= durations.SAME_MESSAGE
        is_fast = now - self.sent_at <= durations.FAST
        if capability not in self.order.echoed and not (is_fast and capability in self.suspected):
            return False
        if is_fast:
            self.fast[capability] = now
        self.echoed[capability] = self._echoed_since_sent[capability] = now
        return True
