"""Findings of single sensors about a command, with what else was switched near them. Pure."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

from homebot.control.witnesses.command_watch import CommandWatch
from homebot.control.witnesses.effect import Effect
from homebot.control.witnesses.finding import Finding, WatchTimes, can_tell, finding_of, observe
from homebot.control.witnesses.home_state import HomeState
from homebot.control.witnesses.sensors import Sensor
from homebot.control.witnesses.witness_record import Expected, Observation, WitnessRecord

__all__ = ["SensorFinding", "observed", "patience", "sees", "was_silent"]

_SPARE: Final = 0.1
_LONGEST_SPARE: Final = 1.0  # seconds

_TOGETHER: Final = 1.0
"""Seconds within which a device tells its values one after the other."""


class SensorFinding(NamedTuple):
    """Answer of a trusted sensor.

    Attributes:
        sensor: The sensor.
        finding: What it shows.
        seen_at: When, in seconds of the monotonic clock.
        is_by_silence: Whether it reported nothing at all, and is taken to be alive.
        is_in_doubt: Whether it saw nothing, and may be stuck.
    """

    sensor: Sensor
    finding: Finding
    seen_at: float
    is_by_silence: bool = False
    is_in_doubt: bool = False


def would_see(
    watch: CommandWatch, sensor: Sensor, record: WitnessRecord, expected: Expected, effect: Effect, at: HomeState
) -> bool:
    """Return whether *sensor* would show it if the command had no effect."""
    times = _times(watch, sensor, at, expected.within)
    is_clear = not at.is_disturbed(watch, sensor)
    return is_clear and can_tell(record, sensor.history, expected, effect, times, sensor.capability)


def patience(
    watch: CommandWatch, sensor: Sensor, record: WitnessRecord, expected: Expected, effect: Effect, at: HomeState
) -> float:
    """Return for how many seconds after the device's report to wait for *sensor*.

    One that would show that there is no effect is waited for until that is sure; one that usually sees such effects for
    as long as that took so far; others not at all.
    """
    if would_see(watch, sensor, record, expected, effect, at):
        return expected.within + watch.command.transition
    before = sensor.history.value_at(watch.marks[sensor])
    if before is None or at.is_disturbed(watch, sensor) or not record.has_seen_as_hard(effect, before):
        return 0.0
    return min(expected.slowest + _SPARE, _LONGEST_SPARE)


def sees(
    watch: CommandWatch, sensor: Sensor, record: WitnessRecord, expected: Expected, effect: Effect, at: HomeState
) -> SensorFinding:
    """Return what *sensor* tells now; that it saw nothing only once its time is over and it is known to be alive.

    One that reports changes alone, and never missed one, is taken to be alive while nothing says otherwise.
    """
    if at.is_disturbed(watch, sensor):
        return SensorFinding(sensor, Finding.UNCLEAR, at.now)
    times = _times(watch, sensor, at, expected.within)
    finding = finding_of(sensor.history, expected, effect, times)
    if finding is Finding.SAW:
        changed = sensor.history.change(times.mark, at.now, rises=effect.rises)
        return SensorFinding(sensor, finding, at.now if changed is None else changed[1])
    is_over = at.now >= watch.reported + expected.within + watch.command.transition
    is_heard = at.is_alive(sensor.place, watch.reported + expected.slowest)
    is_sure = is_over and (is_heard or (record.is_unfailing and at.is_reachable(sensor.place)))
    if finding is Finding.NOTHING and is_sure and would_see(watch, sensor, record, expected, effect, at):
        if _is_in_doubt(watch, sensor):
            return SensorFinding(sensor, Finding.UNCLEAR, at.now, is_in_doubt=True)
        return SensorFinding(sensor, finding, at.now, is_by_silence=not is_heard)
    return SensorFinding(sensor, Finding.UNCLEAR, at.now)


def observed(watch: CommandWatch, sensor: Sensor, effect: Effect, at: HomeState, settle: float) -> Observation | None:
    """Return what there is to learn; None where something else changed, or nothing is known of the sensor."""
    if watch.command.transition or at.is_disturbed(watch, sensor):
        return None
    found = observe(sensor.history, effect, _times(watch, sensor, at, settle))
    if found is None:
        return None
    if not found.change:
        is_sound = at.is_alive(sensor.place, watch.reported) and not _is_in_doubt(watch, sensor)
        return found if is_sound else None  # else it may have been silent, or stuck
    return replace(found, fell_silent=not at.is_alive(sensor.place, watch.reported + found.delay + _TOGETHER))


def was_silent(watch: CommandWatch, sensor: Sensor, record: WitnessRecord, effect: Effect, at: HomeState) -> bool:
    """Return whether *sensor*, which is trusted, showed nothing of an effect that it would have shown."""
    expected = record.expected(rises=effect.rises)
    if expected is None or watch.command.transition or not would_see(watch, sensor, record, expected, effect, at):
        return False
    return finding_of(sensor.history, expected, effect, _times(watch, sensor, at, expected.within)) is Finding.NOTHING


def _times(watch: CommandWatch, sensor: Sensor, at: HomeState, settle: float) -> WatchTimes:
    quiet = at.quiet_since(watch, sensor, settle)
    return WatchTimes(quiet, watch.marks[sensor], watch.began, watch.reported, at.now)


def _is_in_doubt(watch: CommandWatch, sensor: Sensor) -> bool:
    """Return whether a sensor has not moved since it contradicted another part, or was found to be stuck.

    Two devices that lie at once are less likely than one sensor that is stuck.
    """
    target, count = sensor.accused
    accuses_others = target not in {"", watch.command.target} and sensor.history.count == count
    return accuses_others or sensor.stuck_at == sensor.history.count
