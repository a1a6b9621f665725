"""Evidence of a command: its outcome so far, the next step, and the knowledge that it brings. Pure."""

import math
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from homebot.control import durations
from homebot.control.timeline.facts import NOTHING, Transmission
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, NoAnswer, Outcome, Superseded
from homebot.devices.value_comparison import fits, value_text


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


def learn_outcome(progress: CommandProgress, profile: DeviceProfile, first: float) -> None:
    """Learn from a confirmed command."""
    _learn_times(progress, profile, first)
    _learn_answers(progress, profile)
    _learn_echoes(progress, profile)
    _set_told_once(profile, is_told_once=False)
    routes = progress.transmission.routes
    if routes and progress.wanted:
        profile.learn_routes(routes, routes[-1])


def learn_failure(progress: CommandProgress, outcome: Outcome, profile: DeviceProfile) -> None:
    """Learn from a command without an answer, or that the device contradicted, so it may obey later."""
    _learn_answers(progress, profile)
    if not progress.transmission.refusal:
        profile.learn_routes(progress.transmission.routes)
    if isinstance(outcome, Contradicted):
        _learn_echoes(progress, profile)
    was_sent = not (isinstance(outcome, NoAnswer) and outcome.reason)
    if was_sent and progress.over_at == math.inf and progress.wanted:  # else it will not answer
        last, wanted = progress.last, progress.wanted.items()  # if it keeps reporting its old state, it will not either
        progress.learns_late = not all(
            name in last and fits(name, wanted_value.value, last[name]) for name, wanted_value in wanted
        )
    was_told_once = profile.is_told_once
    if isinstance(outcome, NoAnswer) or was_told_once or progress.order.is_told_once:
        is_silent = isinstance(outcome, NoAnswer) and progress.transmission.count > 1 and progress.order.has_ramp
        _set_told_once(profile, is_told_once=is_silent)


def learn_late_answer(progress: CommandProgress, profile: DeviceProfile, first: float) -> None:
    """Learn from an answer after a failure; if it was sent once, this is the device's response time."""
    progress.learns_late = False
    _learn_times(progress, profile, first)
    _set_told_once(profile, is_told_once=True)


def learn_settled(progress: CommandProgress, profile: DeviceProfile) -> None:
    """Learn from a confirmed value that held, or was undone."""
    outcome, undoing = progress.outcome, progress.undoing
    is_witnessed = isinstance(outcome, Confirmed) and outcome.evidence is Evidence.WITNESSED
    for capability, wanted in progress.wanted.items():
        is_undone = undoing is not None and undoing.capability == capability
        if undoing is not None and not is_undone:
            continue
        if undoing is None:
            profile.learn_kept(capability, wanted.value)
        is_fast = wanted.fast_at is not None and not is_witnessed
        profile.learn_return(capability, undoing.after if undoing is not None else None, is_fast=is_fast)
        if is_undone and wanted.echoed_at is not None:
            profile.learn_echo(capability, is_answered=True)


def _learn_times(progress: CommandProgress, profile: DeviceProfile, first: float) -> None:
    """Learn how long the part took; one that missed the message to its group, from when it was told by itself."""
    told_at, sendings = progress.transmission.told_at, progress.transmission.count
    since, sendings = (progress.given_at, sendings) if told_at is None else (told_at, sendings - 1)
    for name, wanted in progress.wanted.items():
        if wanted.met_at is not None:
            is_change = progress.last.get(name, NOTHING) != wanted.seen
            profile.learn_time(name, wanted.met_at - since, first, sendings=sendings, is_change=is_change)


def _learn_answers(progress: CommandProgress, profile: DeviceProfile) -> None:
    for capability, wanted in progress.wanted.items():
        seen, is_set = wanted.seen, capability in progress.order.settings
        if seen is not NOTHING and is_set and progress.known.get(capability, NOTHING) != seen:
            profile.learn_answer(capability, progress.order.settings[capability], seen)


def _learn_echoes(progress: CommandProgress, profile: DeviceProfile) -> None:
    order = progress.order
    if not progress.has_echo:
        return
    for capability, wanted in progress.wanted.items():
        if wanted.echoed_at is not None or capability in order.echoed:
            profile.learn_echo(capability, is_answered=wanted.seen is not NOTHING)
        if wanted.returned_after is not None and wanted.met_at is None:
            profile.learn_return(capability, wanted.returned_after, is_fast=True)


def _set_told_once(profile: DeviceProfile, *, is_told_once: bool) -> None:
    if profile.is_told_once is not is_told_once:
        profile.is_told_once, profile.is_changed = is_told_once, True
