"""Judgement of one sensor about one command: it saw the effect, saw that there was none, or cannot tell. Pure."""

from __future__ import annotations

from enum import Enum
from typing import Final, NamedTuple

from homebot.control.witnesses.effect import Effect
from homebot.control.witnesses.sensor_history import SensorHistory
from homebot.control.witnesses.witness_record import Expected, Observation, WitnessRecord

__all__ = ["QUIET", "Finding", "WatchTimes", "can_tell", "finding_of", "observe"]

QUIET: Final = 60.0
"""Seconds before a command that show how the sensor moves by itself, at most."""

_SHARE: Final = 16


class Finding(Enum):
    """Answer of a sensor about a command."""

    SAW = "saw"
    NOTHING = "nothing"
    UNCLEAR = "unclear"


class WatchTimes(NamedTuple):
    """The times of one command, in seconds of the monotonic clock.

    Attributes:
        quiet_since: Since when nothing near the sensor was switched.
        mark: The number of readings that the sensor had told when it was sent.
        began: When it was sent.
        reported: When the device reported that it is so.
        until: The end of the time in which the sensor may see it.
    """

    quiet_since: float
    mark: int
    began: float
    reported: float
    until: float


def observe(history: SensorHistory, effect: Effect, times: WatchTimes) -> Observation | None:
    """Return what a sensor did at a command; None where its readings of that time are not known."""
    before = history.value_at(times.mark)
    changed = history.change(times.mark, times.until, rises=effect.rises)
    swing = _swing(history, times)
    if before is None or changed is None or swing is None:
        return None
    return Observation(effect, before, changed[0], max(0.0, changed[1] - times.reported), swing)


def can_tell(
    record: WitnessRecord,
    history: SensorHistory,
    expected: Expected,
    effect: Effect,
    times: WatchTimes,
    capability: str,
) -> bool:
    """Return whether, if the command has no effect, the sensor would show that.

    It does where its reading leaves room for the change and other light or load is weak beside it, where it saw as much
    under as hard conditions, where it moved little by itself, and where it reports changes that are finer.
    """
    before = history.value_at(times.mark)
    swing = _swing(history, times)
    if before is None or swing is None or times.began - times.quiet_since < expected.within:
        return False
    rest = before if effect.rises else before - expected.least  # what is there without the effect
    if not -expected.least / 4 <= rest <= expected.least / 2 or swing > expected.least / 8:
        return False
    if capability in {"illuminance", "power", "flow"} and not (
        _is_dark(expected, effect, before) or _is_fine(history, expected, before, capability, times.began)
    ):
        return False
    return record.has_seen_as_hard(effect, before)


def finding_of(history: SensorHistory, expected: Expected, effect: Effect, times: WatchTimes) -> Finding:
    """Return what the sensor shows until ``times.until``; that it saw nothing counts only where it can tell."""
    up = history.change(times.mark, times.until, rises=effect.rises)
    down = history.change(times.mark, times.until, rises=not effect.rises)
    swing = _swing(history, times)
    if up is None or down is None or swing is None or swing > expected.least / 4:
        return Finding.UNCLEAR
    if expected.least / 2 <= up[0] <= 2 * expected.most:
        return Finding.SAW
    nothing = max(swing, expected.least / _SHARE)
    return Finding.NOTHING if max(up[0], down[0]) <= nothing else Finding.UNCLEAR


def _swing(history: SensorHistory, times: WatchTimes) -> float | None:
    if times.quiet_since >= times.began:
        return None
    return history.swing(max(times.quiet_since, times.began - QUIET), times.mark)


def _is_dark(expected: Expected, effect: Effect, before: float) -> bool:
    """Return whether nothing but the part could be measured: from 0 on it can only be more than what was seen before.

    What a coarse sensor left out of its reports hides a fall, as the sun rises meanwhile, and no rise.
    """
    return effect.rises and abs(before) <= expected.least / _SHARE


def _is_fine(history: SensorHistory, expected: Expected, before: float, capability: str, now: float) -> bool:
    """Return whether half of the change would be reported too.

    What a sensor leaves out of its reports may hide a slow change. Daylight always makes one; a meter that has known
    two values alone measures one load.
    """
    is_alone = capability != "illuminance" and history.resolution.has_two_levels(expected.least)
    return is_alone or history.resolution.is_finer_than(expected.least / 2, before, now)
