"""Evidence of a command: its outcome so far, and the next step. Pure."""

import math
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from homebot.control import durations
from homebot.control.timeline.goal import NOTHING
from homebot.control.timeline.progress import CommandProgress
from homebot.control.timeline.transmission import Transmission
from homebot.devices.obedience import value_text
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, NoAnswer, Outcome, Superseded


class Step(NamedTuple):
    """The next action for a command.

    Attributes:
        kind: ``send``: send it, perhaps again; ``wait``: for a fact, or until *until*; ``done``: it is decided.
        until: Seconds on the monotonic clock.
    """

    kind: Literal["send", "wait", "done"]
    until: float = math.inf


_DONE: Final = Step("done")
_SEND: Final = Step("send")


@dataclass(slots=True, frozen=True)
class SendingPlan:
    """Times of the sendings of one command.

    Attributes:
        tries: The largest number of sendings.
        interval: Seconds between two sendings.
        lasts: Seconds from the end of the first sending to the end; a later repetition has its interval.
        keeps_for: Seconds for which the network may store a sending.
        echo_patience: Seconds to wait after an echo for the device's own report; inf without echoes.
    """

    tries: int
    interval: float
    lasts: float
    keeps_for: float = 0.0
    echo_patience: float = math.inf

    def end(self, sendings: Transmission) -> float:
        """Return the end: a dimmer that is stuck on its way is sent its command again later than any other."""
        return max(sendings.began + self.lasts, sendings.sent_at + self.interval)


def next_step(progress: CommandProgress, plan: SendingPlan, now: float) -> Step:
    """Return the next step of a command at *now*."""
    if not (progress.transmission.attempts or progress.superseded_by or progress.transmission.refusal):
        return _SEND
    over_at = progress.over_at
    if over_at < math.inf:
        return Step("wait", over_at) if now < over_at else _DONE
    if not progress.transmission.can_be_asked and progress.is_mute:
        return _DONE
    echo_until = weakly_met_at(progress) + plan.echo_patience if progress.has_echo else math.inf
    until = _answer_until(progress, plan, echo_until)
    if now < min(until, echo_until):
        return Step("wait", until)
    return _after_silence(progress, plan, now, is_echoed=echo_until <= now)


def outcome_of(progress: CommandProgress, now: float) -> Outcome:
    """Return the current outcome of a command at *now*."""
    name, waited = progress.order.id, now - progress.given_at
    if progress.superseded_by:
        return Superseded(progress.superseded_by, command_id=name)
    if refusal := progress.transmission.refusal:
        return Contradicted(refusal, command_id=name)
    if progress.over_at < math.inf:
        if not progress.wanted:
            return Confirmed(waited, Evidence.ACKNOWLEDGED, command_id=name)
        latency = max(progress.met_times) - progress.given_at
        return Confirmed(latency, Evidence.REPORTED, command_id=name, reported=progress.reported)
    if others := progress.others:
        if not progress.motion.has_faded and all(map(progress.is_stale, others)):
            return _no_answer(progress, waited)
        saw = ", ".join(f"{capability} is {value_text(value)}" for capability, value in others.items())
        return Contradicted(saw, command_id=name)
    return _silent_outcome(progress, waited)


def weakly_met_at(progress: CommandProgress) -> float:
    """Return when all values were reported or echoed, or sent if an echo is declared; inf if they were not."""
    order = progress.order
    if not progress.wanted or any(member.others for member in progress.members):  # a member did not follow
        return math.inf
    latest = -math.inf
    for name, wanted in progress.wanted.items():
        at = wanted.met_at
        if at is None and wanted.seen is NOTHING:
            at = (
                progress.transmission.sent_at if wanted.echoed_at is None and name in order.echoed else wanted.echoed_at
            )
        latest = max(latest, math.inf if at is None else at)
    return latest


def _silent_outcome(progress: CommandProgress, waited: float) -> Outcome:
    """Return the outcome of a command for which the device reported nothing."""
    name, sendings = progress.order.id, progress.transmission
    if sendings.is_unacknowledged and not progress.is_accepted:
        return _no_answer(progress, waited)
    at = max(sendings.accepted.values()) if progress.is_accepted else weakly_met_at(progress)
    if at < math.inf:
        return Confirmed(at - progress.given_at, Evidence.ACKNOWLEDGED, command_id=name)
    if not (progress.was_so or progress.is_mute):
        return _no_answer(progress, waited)
    if (
        progress.is_mute or progress.has_echo or progress.order.is_always_sent
    ):  # the previous report may be an echo, or of before
        return Confirmed(waited, Evidence.ACKNOWLEDGED, command_id=name)
    return AlreadySo(command_id=name)


def _no_answer(progress: CommandProgress, waited: float) -> NoAnswer:
    is_unacknowledged = progress.transmission.is_unacknowledged
    return NoAnswer(waited, command_id=progress.order.id, is_unacknowledged=is_unacknowledged)


def _answer_until(progress: CommandProgress, plan: SendingPlan, echo_until: float) -> float:
    """Return the deadline for an answer to the last sending; it is later while the device is on its way."""
    sendings, motion = progress.transmission, progress.motion
    until = min(sendings.asked_at + plan.interval, plan.end(sendings))
    if motion.moved_at == -math.inf:
        return min(until, echo_until)
    ends_at = motion.moved_at + (durations.FADE_SILENCE if motion.has_faded else durations.MOTOR_SILENCE)
    if motion.has_stopped:
        ends_at = motion.stopped_at + durations.STOPPED
    return min(max(until, ends_at), sendings.began + durations.MAX_MOVE)


def _after_silence(progress: CommandProgress, plan: SendingPlan, now: float, *, is_echoed: bool) -> Step:
    sendings, motion, end = progress.transmission, progress.motion, plan.end(progress.transmission)
    is_awaited = motion.is_under_way or is_echoed or (now >= end and motion.moved_at == -math.inf)
    if is_awaited or sendings.attempts >= plan.tries or not progress.may_repeat:
        if motion.has_stopped or isinstance(outcome_of(progress, now), Confirmed | AlreadySo):
            return _DONE
    elif sendings.lost_at < max(sendings.first_sent_at, progress.told_otherwise_at):
        return _SEND  # after a lost connection the device has to report first that it did not obey
    return Step("wait", end) if now < end else _DONE
