"""Beginning of a timeline: what the directory knows of the part. Pure."""

from __future__ import annotations

from homebot.control import durations
from homebot.control.timeline.facts import Reported
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices import Device, DevicePart, State

__all__ = ["seed"]


def seed(timeline: PartTimeline, device: Device, part: DevicePart, now: float, monotonic: float) -> None:
    """Take the live values of *part* into its *timeline*.

    No command explains a change from before the first command. The first value that the part reported is no change.

    Args:
        timeline: The timeline, new.
        device: The device.
        part: Its part.
        now: The time in seconds since the Unix epoch.
        monotonic: The same on the monotonic clock.
    """
    settable = {one.name for one in part.part.capabilities if one.settable}
    states = [one for one in device.states if one.part == part.id and one.live]
    for state in states:
        age = max(0.0, now - state.told_at.to_seconds())
        timeline.seed(state.capability, state.value.plain(), monotonic - age)
    changed = [one for one in states if one.capability in settable and _is_change(one, states)]
    newest = max(changed, key=lambda one: one.since.to_seconds(), default=None)
    if newest is not None:
        since = newest.since.to_seconds()
        at = monotonic - max(0.0, now - since)
        timeline.dropped_change = Reported(at, since, 0, newest.capability, newest.value.plain())


def _is_change(state: State, states: list[State]) -> bool:
    """Return whether *state* is a change, or a first value of a part that reported others long before."""
    since = state.since.to_seconds()
    return not state.is_first or any(since - one.since.to_seconds() > durations.FIRST_REPORTS for one in states)
