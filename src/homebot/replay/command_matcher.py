"""Matching of commands with those of a recording. Pure."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable
from typing import Final, TypeAlias, final

from homebot.devices.capabilities import MOMENTARY
from homebot.devices.value import PlainValue
from homebot.recording.lines import RecordedCommand
from homebot.recording.recording import TimedCommand

__all__ = ["TOLERANCE", "CommandMatcher", "is_carried_out", "without_repeats"]

TOLERANCE: Final = 1.0
"""Seconds by which the same command may be earlier or later: a busy computer is late, and nobody in a room notices."""

_ROUNDED: Final = 1e-6

_Key: TypeAlias = "tuple[str, str, str, str, tuple[tuple[str, PlainValue], ...]]"


def is_carried_out(given: TimedCommand) -> bool:
    """Return whether a command was to be sent: no policy and no lease refused it."""
    result = given.result
    return result is None or result.outcome != "refused" or result.policy == "gateway"


def without_repeats(commands: Iterable[TimedCommand]) -> list[TimedCommand]:
    """Return *commands*, in the order of time, without those that say again what their app said within 1 s before.

    How often an app says so depends on how busy the computer was: a lamp may report the same three times while an app
    still acts upon the first. What does something each time, such as a button, and raw texts are no repeats.
    """
    kept: list[TimedCommand] = []
    latest: dict[tuple[str, str, str], TimedCommand] = {}
    for one in commands:
        command = one.command
        place = command.issuer, command.device, command.part
        before = latest.get(place)
        is_repeatable = not command.text and not any(each.capability in MOMENTARY for each in command.settings)
        is_same = before is not None and _key(before.command) == _key(command)
        if before is not None and is_same and is_repeatable and one.at <= before.at + TOLERANCE + _ROUNDED:
            continue
        latest[place] = one
        kept.append(one)
    return kept


@final
class CommandMatcher:
    """Finds a command among others: of the same issuer, to the same part, of the same values, at most 1 s away.

    Each is found once, the earliest first. Commands that a policy refused are none.

    Args:
        commands: The others, in the order of time.
    """

    def __init__(self, commands: Iterable[TimedCommand]) -> None:
        self._left: defaultdict[_Key, list[TimedCommand]] = defaultdict(list)
        for one in commands:
            if is_carried_out(one):
                self._left[_key(one.command)].append(one)

    def take(self, wanted: TimedCommand) -> TimedCommand | None:
        """Return the same command as *wanted*, and find it no more; None where there is none."""
        same = self._left.get(_key(wanted.command), [])
        number = bisect_left(same, wanted.at - TOLERANCE - _ROUNDED, key=lambda one: one.at)
        if number < len(same) and same[number].at <= wanted.at + TOLERANCE + _ROUNDED:
            return same.pop(number)
        return None

    @property
    def left(self) -> list[TimedCommand]:
        """The commands that were not found."""
        return [one for same in self._left.values() for one in same]


def _key(command: RecordedCommand) -> _Key:
    settings = tuple((one.capability, one.value.plain()) for one in command.settings)
    return command.issuer, command.device, command.part, command.text, settings
