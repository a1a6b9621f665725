"""Confirmed commands whose devices may still go back: a while after, that is reported."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Final, TypeAlias, final

import anyio

from homebot.control.command import IssuedCommand
from homebot.control.echoes import EchoHistory
from homebot.control.fade_out import FadeOut, FadeSign
from homebot.control.gateway_watch import PartWatch
from homebot.control.held_values import changes, related
from homebot.control.journal import CommandJournal
from homebot.control.pending import PendingCommand
from homebot.devices.command_messages import CommandEvent
from homebot.devices.command_results import result_of
from homebot.devices.names import COMMAND_EVENTS
from homebot.devices.outcomes import Reverted
from homebot.devices.value import PlainValue
from homebot.graph import Node
from homebot.time_limits import TimeLimits
from homebot.timer_queue import TimerQueue

__all__ = ["Settling"]

_Place: TypeAlias = tuple[str, str, str]

REVERTED = "control.reverted"

_LATE: Final = 2.0
"""Seconds after a transition in which its last steps may be reported."""

_LEVEL_AFTER: Final = 1.0
"""Seconds within which a lamp that reports that it is on again tells its level as well."""

_LONGEST: Final = 300.0
"""Seconds from its confirmation for which a device is watched that moves on and on."""


@dataclass(slots=True, eq=False)
class _Settled:
    pending: PendingCommand
    confirmed_at: float
    watch: PartWatch
    until: float
    step: tuple[str, PlainValue] | None = None  # of a device that reports that it is still on its way
    stepped_at: float = 0.0
    fade: FadeOut | None = None  # of a lamp that was turned off
    is_fading: bool = False


@final
class Settling:
    """Watches the devices of confirmed commands for some seconds, one command for each part and capability.

    Args:
        node: The node that publishes what went back.
        seconds: How long.
        journal: Notes what went back.
        echoes: Learns which of the reports were echoes.
        limits: Ends what waits too long.

    Attributes:
        watched: What is watched, by device, part and capability; for reading.
    """

    def __init__(
        self, node: Node, seconds: float, journal: CommandJournal, echoes: EchoHistory, limits: TimeLimits
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._seconds = seconds
        self._journal = journal
        self._echoes = echoes
        self._limits = limits
        self._events = node.create_publisher(CommandEvent, COMMAND_EVENTS, 1000)
        self.watched: dict[_Place, _Settled] = {}
        self._deadlines: TimerQueue[_Place, None] = TimerQueue()
        self._added = anyio.Event()

    def add(self, pending: PendingCommand, watch: PartWatch) -> bool:
        """Go on to watch the device of *pending*, which was confirmed now; return whether *watch* is taken for it."""
        if not self._seconds or not pending.is_verified:
            return False
        now = self._clock.monotonic()
        settled = _Settled(pending, now, watch, now + self._seconds + pending.command.transition)
        if pending.command.settings.get("on_off") is False:
            settled.fade = FadeOut(pending.command)
        watch.take = partial(self._take, settled)
        for place in pending.command.places:
            self._end(place)
            self.watched[place] = settled
            self._deadlines.set(place, settled.until, None)
        self._added.set()
        return True

    def supersede(self, command: IssuedCommand) -> None:
        """Watch no more what a newer *command* is about, and what it changes: no device went back then."""
        watched = self.watched
        device, part = command.place
        for capability, value in command.settings.items():
            for other in related(capability):
                place = device, part, other
                if place not in watched:
                    continue
                older = watched[place].pending.command.settings[other]
                if other == capability or changes(other, older, capability, value):
                    self._end(place)

    async def run(self) -> None:
        """End each watch in its time, until cancelled."""
        while True:
            while (due := self._deadlines.pop(self._clock.monotonic())) is not None:
                self._end_in_time(due[0])
            following = self._deadlines.next()
            if following is None:
                self._added = anyio.Event()
                await self._added.wait()
            else:  # what is added meanwhile ends later
                await anyio.sleep(max(0.0, following - self._clock.monotonic()))

    def _take(self, settled: _Settled, capability: str, value: PlainValue) -> None:
        pending, fade = settled.pending, settled.fade
        if fade is not None and capability == "level":
            self._take_fade(settled, fade.take(value, self._clock.monotonic()))
            return
        if not pending.departs(capability, value):
            if settled.step is not None and settled.step[0] == capability:
                settled.step, settled.is_fading = None, False
            pending.note_again(capability, value, self._clock.monotonic())
            return
        may_fade = fade is not None and fade.is_possible
        if not (may_fade or self._is_fading(settled, capability) or pending.may_move_on(capability, value)):
            self._revert(settled, capability)
        elif settled.step != (capability, value):
            self._begin_step(settled, capability, value)

    def _begin_step(self, settled: _Settled, capability: str, value: PlainValue) -> None:
        """Watch on a device that may be on its way; a lamp that is on again is to tell its level soon."""
        now, fade = self._clock.monotonic(), settled.fade
        settled.step, settled.stepped_at = (capability, value), now
        self._wait_on(settled)
        if fade is not None and fade.is_possible and not self._is_fading(settled, capability):
            sign = fade.sign(now)
            self._take_fade(settled, sign)
            if sign == "unknown":
                self._limits.set(_LEVEL_AFTER, partial(self._end_step, settled, now))

    def _take_fade(self, settled: _Settled, sign: FadeSign) -> None:
        if settled.step is None:
            return  # it did not say that it is on again
        if sign == "back" and not self._is_fading(settled, settled.step[0]):
            self._revert(settled, settled.step[0])
        elif sign == "fading":
            settled.is_fading = True
            self._wait_on(settled)

    def _end_step(self, settled: _Settled, at: float) -> None:
        """Take the step at *at* for a reversal where no level has said since that the lamp fades."""
        is_watched = any(self.watched.get(place) is settled for place in settled.pending.command.places)
        if is_watched and settled.step is not None and settled.stepped_at == at and not settled.is_fading:
            self._revert(settled, settled.step[0])

    def _is_fading(self, settled: _Settled, capability: str) -> bool:
        """Return whether a lamp may still be on for the commanded transition, although it reported its end."""
        transition = settled.pending.command.transition
        if capability != "on_off" or not transition:
            return False
        return self._clock.monotonic() - settled.confirmed_at <= transition + _LATE

    def _wait_on(self, settled: _Settled) -> None:
        """Watch a device that moves for some seconds more."""
        until = min(self._clock.monotonic() + self._seconds, settled.confirmed_at + _LONGEST)
        settled.until = max(settled.until, until)
        for place in settled.pending.command.places:
            if self.watched.get(place) is settled:
                self._deadlines.set(place, settled.until, None)

    def _revert(self, settled: _Settled, capability: str) -> None:
        pending = settled.pending
        self._note_taken_back(pending, capability)
        command = pending.command
        for place in command.places:
            self._end(place)
        outcome = Reverted(self._clock.monotonic() - settled.confirmed_at, command_id=command.id)
        result = result_of(outcome)
        self._journal.note("reverted", command, results=(result,))
        self._events.publish(
            CommandEvent(device=command.device.id, part=command.part.id, issuer=command.issuer, result=result)
        )
        self._node.log.warning(
            REVERTED, message=f"{command.label}: {outcome.text}", device=command.device.id, command=command.id
        )

    def _end_in_time(self, place: _Place) -> None:
        """Watch *place* no more, as it kept its value; one that a newer command is about is not watched any more."""
        settled = self.watched.get(place)
        if settled is None:
            return
        if settled.step is not None:  # it got stuck there
            self._revert(settled, settled.step[0])
            return
        if place[2] in settled.pending.fast:
            self._note_fast(settled.pending, place[2], None)
        self._end(place)

    def _note_taken_back(self, pending: PendingCommand, capability: str) -> None:
        command = pending.command
        if (reported_at := pending.fast.get(capability)) is not None:
            seconds = self._clock.monotonic() - reported_at
            self._note_fast(pending, capability, None if pending.is_witnessed else seconds)
        if capability in pending.echoed:
            self._echoes.note_echo(command.target, capability, command.id, answered=True)

    def _note_fast(self, pending: PendingCommand, capability: str, taken_back_after: float | None) -> None:
        command, is_repeated = pending.command, capability in pending.repeated
        self._echoes.note_fast(command.target, capability, command.id, taken_back_after, is_repeated=is_repeated)

    def _end(self, place: _Place) -> None:
        """Watch *place* no more; its deadline stays, as that of a newer command mostly takes its place soon."""
        settled = self.watched.pop(place, None)
        if settled is None:
            return
        places = settled.pending.command.places
        if len(places) == 1 or all(self.watched.get(one) is not settled for one in places):
            settled.watch.stop()
