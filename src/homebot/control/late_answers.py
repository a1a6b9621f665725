"""Answers that come after the outcome of a command: that of a device which is slower than anybody knew."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Final, TypeAlias, final

from homebot.clock import Clock
from homebot.control.command import IssuedCommand
from homebot.control.gateway_watch import PartWatch
from homebot.control.pending import PendingCommand
from homebot.control.response_times import ResponseTimes
from homebot.control.tolerance import fits
from homebot.devices.outcomes import Contradicted, NoAnswer
from homebot.devices.value import PlainValue
from homebot.time_limits import TimeLimits

__all__ = ["LateAnswers"]

_Part: TypeAlias = tuple[str, str]

_LONGEST: Final = 60.0
"""Seconds after the outcome for which a late answer is waited for; later a hand is likelier."""


@dataclass(slots=True, eq=False)
class _Listened:
    pending: PendingCommand
    watch: PartWatch
    limit: int = 0


@final
class LateAnswers:
    """Listens for a minute to devices that did not answer in time, to know the next time how long they take.

    Args:
        clock: The clock.
        limits: Ends what waits too long.
        times: Is told how long they took.

    Attributes:
        awaited: The newest such command of each part, by the ids of its device and the part; for reading.
    """

    def __init__(self, clock: Clock, limits: TimeLimits, times: ResponseTimes) -> None:
        self._clock = clock
        self._limits = limits
        self._times = times
        self.awaited: dict[_Part, _Listened] = {}

    def add(self, pending: PendingCommand, outcome: NoAnswer | Contradicted, watch: PartWatch) -> bool:
        """Wait on for the answer to *pending*, whose *outcome* came now; return whether *watch* is taken for it."""
        was_sent = not (isinstance(outcome, NoAnswer) and outcome.reason)
        if not was_sent or pending.is_over or not pending.is_verified or pending.command.is_momentary:
            return False
        if _was_so(pending.command):
            return False
        place = pending.command.place
        self.end(place)
        awaited = self.awaited[place] = _Listened(pending, watch)
        awaited.limit = self._limits.set(_LONGEST, partial(self.end, place))
        watch.take = partial(self._take, awaited)
        return True

    def end(self, place: _Part) -> None:
        """Wait no more for the part *place*, as when a newer command to it is given."""
        awaited = self.awaited.pop(place, None)
        if awaited is not None:
            self._limits.discard(awaited.limit)
            awaited.watch.stop()

    def _take(self, awaited: _Listened, capability: str, value: PlainValue) -> None:
        pending, times = awaited.pending, self._times
        pending.take(capability, value, self._clock.monotonic())
        if pending.is_met:
            pending.note_times(times)
            times.note_silence(pending.command.target, is_silent=True)  # told once, it shows how long it takes
            self.end(pending.command.place)


def _was_so(command: IssuedCommand) -> bool:
    """Return whether the part had last reported what was commanded: a deaf one says it again, which is no answer."""
    last = command.last_reported
    return all(name in last and fits(name, value, last[name]) for name, value in command.expected.items())
