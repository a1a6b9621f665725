"""A command whose outcome is not known yet, and the reports about it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Final, final

from homebot.control.command import IssuedCommand
from homebot.control.echoes import FAST, NO_ECHOES, ExpectedEchoes
from homebot.control.held_values import STOPPED, departs
from homebot.control.motion_watch import LevelWatch, MotionWatch
from homebot.control.response_times import ResponseTimes
from homebot.control.tolerance import fits, is_intermediate, is_same
from homebot.control.value_text import value_text
from homebot.devices.command_messages import Setting
from homebot.devices.outcomes import (
    AlreadySo,
    Confirmed,
    Contradicted,
    Evidence,
    NoAnswer,
    Outcome,
    Superseded,
)
from homebot.devices.value import PlainValue

__all__ = ["PendingCommand"]

_MOST_NOTED: Final = 20
"""Reports of one command that are worth a note, should a device report one value after the other."""

_SAME: Final = 0.01
"""Seconds within which further reports are those of the same message, by this or by other routes."""

_NOTHING: Final = object()

_setting_of = Setting.of  # looked up once, as `of_checked` says

_MOVES_FOR: Final = 60.0
"""Seconds that a device gets from its last sign of moving on."""

_FADES_FOR: Final = 6.0
"""Seconds that a dimmer gets from its last sign of fading until it is told again."""

_STANDS_FOR: Final = 10.0
"""Seconds that a motor which reports that it stopped on its way gets to go on, or to report where it is."""

_LONGEST: Final = 300.0
"""Seconds from sending after which no sign of moving helps any more."""


@final
class PendingCommand:
    """State of one command: what is wanted, and what was reported.

    Args:
        command: The command.
        before: The values that it is about, as the device had reported them live; those unknown are missing.
        expected: The values that the part is to report.
        began: Seconds of the monotonic clock.
        wake: Called when something changed.
        echoes: The echoes that it may cause.
        was_answered: Returns whether *before* is how the device answered the same command, with its rounding.

    Attributes:
        command: The command.
        echoes: The echoes that it may cause.
        echoed: The capabilities of which an echo came, each with the time of the last one.
        fast: The capabilities of which a report came so fast that it may turn out to be an echo, each with the time.
        repeated: Those of them that were reported again later: by the device, or by a bridge that repeats what it told.
        is_witnessed: Whether a witness saw that the device obeyed.
        moved_at: When the device was last seen on its way; None where it was not.
        must_answer: Whether the device answers commands, so that one of which it reports nothing waits for the answer.
        first_sent_at: When it was first sent.
        told_otherwise_at: When the device last reported something else, and not that it moves; -inf where it did not.
        superseded_by: The id of the newer command that took its place; empty where there is none.
        sendings: How often it was sent.
    """

    def __init__(
        self,
        command: IssuedCommand,
        before: dict[str, PlainValue],
        expected: Mapping[str, PlainValue],
        began: float,
        wake: Callable[[], None],
        echoes: ExpectedEchoes = NO_ECHOES,
        was_answered: Callable[[IssuedCommand, str], bool] | None = None,
    ) -> None:
        self.command = command
        self.echoes = echoes
        self.echoed: dict[str, float] = {}
        self.fast: dict[str, float] = {}
        self.repeated: set[str] = set()
        self.is_witnessed = False
        self.moved_at: float | None = None
        self.must_answer = False
        self.superseded_by = ""
        self.sendings = 0
        self.told_otherwise_at = -math.inf
        self._stopped_at = -math.inf
        self._answers: dict[str, float] = {}
        self._refusal = ""
        self._before = before
        self._was_answered = was_answered
        self._wanted = dict(expected)
        self._began = self._sent_at = self.first_sent_at = began
        self._wake = wake
        self._echoed_since_sent: dict[str, float] = {}
        self._answered: set[str] = set()
        self._back_after: dict[str, float] = {}
        self._seen: dict[str, PlainValue] = {}
        self._seen_before: set[str] = set()
        self._fitting: dict[str, float] = {}
        self._moving: set[str] = set()
        self._motion = MotionWatch(command) if command.moves else None
        self._fade: LevelWatch | None = None  # made with the first level that is not the wanted one
        self._noted = 0
        self._turns_on = command.turns_on
        if self._turns_on and self._was_about_so:  # that it is off at what is wanted does not show that it obeyed
            self._wanted["on_off"] = True

    @property
    def is_over(self) -> bool:
        """True if nothing can come any more that would change the outcome for the better."""
        return bool(self.superseded_by or self._refusal) or self.is_met

    @property
    def is_met(self) -> bool:
        """True if the device reported all that can be reported; at once where it reports nothing of it."""
        if self.must_answer and not self._wanted:
            return self._is_accepted
        return len(self._fitting) == len(self._wanted)

    @property
    def is_verified(self) -> bool:
        """True if the device reports any of what was commanded, so that it shows whether it obeyed."""
        return bool(self._wanted)

    @property
    def was_so(self) -> bool:
        """True if the device had reported before that all of it is so."""
        before = self._before
        for name, value in (self._wanted or self.command.settings).items():
            if name not in before or not (is_same(name, value, before[name]) or self._is_rounded(name, before[name])):
                return False
        return not self.command.opens_further

    @property
    def _was_about_so(self) -> bool:
        before, wanted = self._before, self._wanted or self.command.settings
        return all(name in before and fits(name, value, before[name]) for name, value in wanted.items())

    def _is_rounded(self, capability: str, value: PlainValue) -> bool:
        """Return whether *value*, which was reported before, is what the device makes of the wanted one."""
        if self._was_answered is None or not fits(capability, self.command.settings.get(capability), value):
            return False
        return self._was_answered(self.command, capability)

    def waits_until(self, until: float, began: float) -> float:
        """Return when waiting ends, by the rule at *until*: later on its way, sooner where only echoes come."""
        if self.moved_at is None:
            return until if self.echoes is NO_ECHOES else min(until, self._gives_up_at())
        ends_at = self.moved_at + (_MOVES_FOR if self._fade is None else _FADES_FOR)
        if self.has_stopped:
            ends_at = self._stopped_at + _STANDS_FOR
        return min(max(until, ends_at), began + _LONGEST)

    @property
    def has_stopped(self) -> bool:
        """True if it is a motor that was seen on its way, and then reported that it stopped."""
        return self.moved_at is not None and self.moved_at - self._stopped_at <= _SAME  # of one message

    @property
    def has_faded(self) -> bool:
        """True if it is a dimmer that was seen on its way."""
        return self._fade is not None and self.moved_at is not None

    def gives_up(self, now: float) -> bool:
        """Return whether nothing but echoes came for long enough."""
        return self.echoes is not NO_ECHOES and self._gives_up_at() <= now

    def note_sent(self, now: float) -> None:
        """Note that it is sent now, which may cause an echo."""
        self._sent_at = now
        self.first_sent_at = now if self.sendings == 0 else self.first_sent_at
        self.sendings += 1
        self._seen_before.update(self._seen)
        self._echoed_since_sent.clear()

    def take(self, capability: str, value: PlainValue, now: float) -> bool:
        """Take in a live report of the part at *now*; return whether it is worth a note."""
        if value == STOPPED:
            self._stopped_at = now
        if capability in self._wanted:
            return self._take_wanted(capability, value, now)
        if self._shows_motion(capability, value):
            self.moved_at = now
            self._wake()
        return False

    def _take_wanted(self, capability: str, value: PlainValue, now: float) -> bool:
        wanted = self._wanted[capability]
        is_met = fits(capability, wanted, value)
        if is_met and self._before.get(capability, _NOTHING) == value:
            is_met = is_same(capability, wanted, value) or self._is_rounded(capability, value)  # else it did nothing
        is_moving = not is_met and (is_intermediate(capability, wanted, value) or self._is_fading(capability, value))
        is_news = self._is_news(capability, value, is_moving=is_moving)
        if is_met:
            self.note_again(capability, value, now)
        if is_met and self.echoes is not NO_ECHOES and self._is_echo(capability, now):
            if capability not in self._answered and capability not in self._fitting:
                self._seen.pop(capability, None)  # it was reported before the bridge had the command
            self._wake()
            return is_news
        if capability in self.echoed:
            self._answered.add(capability)
        self._seen[capability] = value
        self._seen_before.discard(capability)
        if is_met:
            if now - self._sent_at <= FAST and capability not in self._fitting:
                self.fast[capability] = now
            self._fitting.setdefault(capability, now)
        else:
            self._fitting.pop(capability, None)
            if capability in self.fast:
                self._back_after.setdefault(capability, now - self.fast[capability])
            if is_moving:
                self.moved_at = now
            else:
                self.told_otherwise_at = now
        self._wake()
        return is_news

    def _shows_motion(self, capability: str, value: PlainValue) -> bool:
        """Return whether a report of something else than is wanted shows that the device is on its way."""
        if self._motion is not None:
            return self._motion.shows_motion(capability, value)
        return self._is_fading(capability, value)

    def _is_fading(self, capability: str, value: PlainValue) -> bool:
        if capability != "level":
            return False
        if self._fade is None:
            self._fade = LevelWatch(self.command)
        return self._fade.shows_motion(value)

    def _is_news(self, capability: str, value: PlainValue, *, is_moving: bool) -> bool:
        """Return whether a report says something new: a motor reports its position again and again on its way."""
        is_repeated = capability in self._moving if is_moving else self._seen.get(capability, _NOTHING) == value
        if is_moving:
            self._moving.add(capability)
        if is_repeated or self._noted >= _MOST_NOTED:
            return False
        self._noted += 1
        return True

    def take_answer(self, capability: str, problem: str, now: float) -> None:
        """Take in the device's answer to a setting at *now*: the reason why it refuses, or empty where it accepts."""
        if capability not in self.command.settings:
            return
        if problem:
            self._refusal = self._refusal or problem
        else:
            self._answers.setdefault(capability, now)
        self._wake()

    @property
    def _is_accepted(self) -> bool:
        return len(self._answers) == len(self.command.settings)

    def _is_echo(self, capability: str, now: float) -> bool:
        """Return whether a report of what is wanted is the bridge's; each sending has one."""
        echoed_at = self._echoed_since_sent.get(capability)
        if echoed_at is not None:
            return now - echoed_at <= _SAME or capability in self.echoes.repeated
        is_fast = now - self._sent_at <= FAST
        if capability not in self.echoes.declared and not (is_fast and capability in self.echoes.suspected):
            return False
        if is_fast:
            self.fast[capability] = now
        self.echoed[capability] = self._echoed_since_sent[capability] = now
        return True

    def _gives_up_at(self) -> float:
        return self._weakly_met_at() + self.echoes.patience

    def _weakly_met_at(self) -> float:
        """Return when all was reported or echoed, or sent where an echo is declared; infinity where it was not."""
        latest = -math.inf if self._wanted else math.inf
        for name in self._wanted:
            at = self._fitting.get(name)
            if at is None and name not in self._seen:
                at = self.echoed.get(name, self._sent_at if name in self.echoes.declared else None)
            latest = max(latest, math.inf if at is None else at)
        return latest

    def supersede(self, by: str) -> None:
        """Note that the command *by* took its place."""
        self.superseded_by = self.superseded_by or by
        self._wake()

    def departs(self, capability: str, value: PlainValue) -> bool:
        """Return whether a later report of *value* shows that the device went back."""
        if capability == "on_off" and capability not in self.command.settings:
            return False  # a newer command may have turned it off
        return capability in self._wanted and departs(capability, self._wanted[capability], value)

    def may_move_on(self, capability: str, value: PlainValue) -> bool:
        """Return whether a dimmer or motor that reported what is wanted, and then *value*, may be on its way there."""
        before, wanted = self._before.get(capability), self._wanted.get(capability)
        if not (isinstance(wanted, float) and isinstance(value, float)):
            return False
        is_motor = is_intermediate(capability, wanted, value)
        if capability == "level" and self._turns_on and value < wanted:
            return True  # it fades up from nothing, whatever it kept as its level
        return is_motor or not isinstance(before, float) or min(before, wanted) < value < max(before, wanted)

    @property
    def reported(self) -> tuple[Setting, ...]:
        """The values that the device reported and that fit."""
        return tuple([_setting_of(one, self._seen[one]) for one in self._fitting])

    @property
    def wanted(self) -> tuple[Setting, ...]:
        """The values that the device is to report."""
        return tuple([_setting_of(name, value) for name, value in self._wanted.items()])

    def answers(self) -> Iterable[tuple[str, PlainValue]]:
        """Yield the capabilities that it reported, each with the value, where that is another one than before."""
        for capability, seen in self._seen.items():
            if self._before.get(capability, _NOTHING) != seen:
                yield capability, seen

    def note_times(self, times: ResponseTimes) -> None:
        """Have *times* note how long the capabilities took that were reported as wanted."""
        target, sendings, last = self.command.target, self.sendings, self.command.last_reported
        for name, at in self._fitting.items():
            is_change = last.get(name, _NOTHING) != self._seen[name]
            times.note(target, name, at - self._began, sendings=sendings, is_change=is_change)

    def note_again(self, capability: str, value: PlainValue, now: float) -> None:
        """Note that *value* is reported at *now*, which may repeat a fast report."""
        reported_at = self.fast.get(capability)
        if reported_at is not None and now - reported_at > FAST and fits(capability, self._wanted[capability], value):
            self.repeated.add(capability)

    @property
    def taken_back(self) -> Iterable[tuple[str, float | None]]:
        """The capabilities of which a fast report was followed by another value, each with the seconds until then.

        None in place of the seconds where the device had obeyed.
        """
        for capability, seconds in self._back_after.items():
            if capability not in self._fitting:
                yield capability, None if self.is_witnessed else seconds

    def echo_answers(self) -> Iterable[tuple[str, bool]]:
        """Yield the capabilities with an expected echo, each with whether the device reported by itself, too."""
        for capability in self._wanted:
            if capability in self.echoed or capability in self.echoes.declared:
                yield capability, capability in self._seen

    def outcome(self, now: float) -> Outcome:
        """Return the outcome as it is at *now*."""
        name = self.command.id
        if self.superseded_by:
            return Superseded(self.superseded_by, command_id=name)
        if self._refusal:
            return Contradicted(self._refusal, command_id=name)
        if self.is_met:
            if not self._wanted:
                return Confirmed(now - self._began, Evidence.ACKNOWLEDGED, command_id=name)
            return Confirmed(max(self._fitting.values()) - self._began, Evidence.REPORTED, command_id=name)
        others = [(one, seen) for one, seen in self._seen.items() if one not in self._fitting]
        words = [one for one, seen in others if isinstance(seen, str)]  # a position may be where it is stuck
        moving = [one for one in words if is_intermediate(one, self._wanted[one], self._seen[one])]
        if others and not self.has_faded and all(one in self._seen_before or one in moving for one, _ in others):
            return NoAnswer(now - self._began, command_id=name)  # since it was sent, or since it began to move
        if others:
            saw = ", ".join(f"{capability} is {value_text(value)}" for capability, value in others)
            return Contradicted(saw, command_id=name)
        if self._is_accepted:
            return Confirmed(max(self._answers.values()) - self._began, Evidence.ACKNOWLEDGED, command_id=name)
        weak_at = math.inf if self.echoes is NO_ECHOES else self._weakly_met_at()
        if weak_at < math.inf:
            return Confirmed(weak_at - self._began, Evidence.ACKNOWLEDGED, command_id=name)
        if self.was_so:
            waited = now - self._began  # what was reported before may have been an echo
            is_sure = self.echoes is NO_ECHOES
            return AlreadySo(command_id=name) if is_sure else Confirmed(waited, Evidence.ACKNOWLEDGED, command_id=name)
        return NoAnswer(now - self._began, command_id=name)
