"""A command whose effect sensors may see: how it was before, and the readings that count. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from homebot.control.command import IssuedCommand
from homebot.control.witnesses.effect import Effect, looks_of, strength_of
from homebot.control.witnesses.sensors import Sensor
from homebot.devices import Device
from homebot.devices.value import PlainValue

__all__ = ["CommandWatch", "wanted_strength", "watch_of"]

_ENOUGH = 50.0
"""Of 100: smaller changes of the strength are not watched."""

_FULL = 100.0


@dataclass(slots=True, eq=False)
class CommandWatch:
    """One command, and the sensors that may see what it does.

    Attributes:
        command: The command.
        given: When it was given, in seconds of the monotonic clock.
        began: From when on its effect is looked for: the same, or earlier where it repeats a contradicted command.
        before: How strong the part was, 0 to 100.
        looks: How it looked.
        marks: The sensors, each with its number of readings by then.
        wake: Called when one of them tells something.
        reported: When the device reported that it is so.
        is_contradicted: Whether a sensor saw nothing of it.
    """

    command: IssuedCommand
    given: float
    began: float
    before: float
    looks: str
    marks: dict[Sensor, int]
    wake: Callable[[], None]
    reported: float = 0.0
    is_contradicted: bool = False

    def effect(self, device: Device | None = None) -> Effect | None:
        """Return what the command changes; None where that is little or unknown.

        Args:
            device: The device after the command. Without it, a level that is not known yet is taken for the full one.
        """
        after = wanted_strength(self.command)
        if device is not None:
            part = self.command.part.id
            reported = _values(device, part, self.command.issued_at)
            after = strength_of({**reported, **self.command.settings}, _reported(device, part))
        if after is None or abs(after - self.before) < _ENOUGH:
            return None
        rises = after > self.before
        looks = looks_of(_values(device, self.command.part.id)) if rises and device is not None else self.looks
        return Effect(rises, abs(after - self.before), looks)


def watch_of(
    command: IssuedCommand, sensors: Iterable[Sensor], before: float | None, now: float, wake: Callable[[], None]
) -> CommandWatch | None:
    """Return the watch of *command*, which is given at *now*; None where no sensor could tell anything.

    Args:
        command: The command.
        sensors: The sensors that may see what it does.
        before: How strong the part is, where a witness saw that it is not as it reports.
        now: Seconds of the monotonic clock.
        wake: Called when one of the sensors tells something.
    """
    if command.device.freshness != "fresh":
        return None
    values = _values(command.device, command.part.id)
    if before is None:
        before = strength_of(values, _reported(command.device, command.part.id))
    if before is None:
        return None
    marks = {one: one.history.count for one in sensors if one.history.count}
    watch = CommandWatch(command, now, now, before, looks_of(values), marks, wake)
    return watch if marks and watch.effect() is not None else None


def wanted_strength(command: IssuedCommand) -> float | None:
    """Return how strong a part becomes by *command*, 0 to 100; full where it is turned on without a level."""
    after = strength_of(command.settings, ())
    return _FULL if after is None and command.settings.get("on_off") is True else after


def _reported(device: Device, part: str) -> frozenset[str]:
    """Return the capabilities that a part ever reported."""
    return frozenset([one.capability for one in device.states if one.part == part])


def _values(device: Device, part: str, since: float = 0.0) -> dict[str, PlainValue]:
    """Return the values that a part reported live, since a time in seconds since the Unix epoch."""
    return {
        one.capability: one.value.plain()
        for one in device.states
        if one.part == part and one.live and one.told_at.to_seconds() >= since
    }
