"""Updates of a device's profile after its commands. Pure."""

import math

from homebot.control.timeline.goal import NOTHING
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.obedience import fits
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, NoAnswer, Outcome


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
        progress.learns_late = not all(name in last and fits(name, one.value, last[name]) for name, one in wanted)
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
