"""Transmission of one command after the other: sent, sent again where no answer comes, never obeyed twice unseen."""

from __future__ import annotations

import asyncio
from typing import Final, final

from homebot.control.command import IssuedCommand
from homebot.control.gateway_watch import GatewayWatch
from homebot.control.journal import CommandJournal
from homebot.control.judge import Judge
from homebot.control.leases import Leases
from homebot.control.pending import PendingCommand
from homebot.control.response_times import ResponseTimes
from homebot.control.settings import ControlSettings
from homebot.devices.command_sender import CommandSender
from homebot.devices.outcomes import AlreadySo, Confirmed, NoAnswer, Outcome, Refused
from homebot.errors import LinkError, RefusedError
from homebot.graph import Node
from homebot.time_limits import TimeLimits

__all__ = ["Signal", "Transmission"]

_AT_ONCE: Final = 0.01
"""Seconds within which a gateway has sent a command whose network is there."""

_MOTION: Final = 60.0
"""Seconds that a motor has: many blinds report nothing until they are there."""

_SPARE: Final = 1.5
"""Seconds from the longest known answer to the next sending: networks count whole seconds for which they keep it."""


@final
class Transmission:
    """Sends commands, and waits until the outcome of each is known.

    A command is sent again only while what was sent before can no longer be obeyed unseen: a network that keeps it for
    a device that is away forgets it before; and where the connection was lost since, the device first has to report
    something else.

    Args:
        node: The node that sends them.
        settings: How long it waits, and how often it sends.
        judge: Is asked again before each repetition.
        journal: Notes each sending.
        leases: The values that somebody holds.
        gateways: Knows who lost its connection.

    Attributes:
        times: How long the devices usually take.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        judge: Judge,
        journal: CommandJournal,
        leases: Leases,
        gateways: GatewayWatch,
    ) -> None:
        self.times = ResponseTimes(settings.timeout)
        self._settings = settings
        self._clock = node.graph.clock
        self._judge = judge
        self._journal = journal
        self._leases = leases
        self._gateways = gateways
        self._sender = CommandSender(node)

    async def run(self, pending: PendingCommand, changed: Signal) -> Outcome:
        """Send a command, again where no answer comes, and return its outcome once it is known."""
        command, clock = pending.command, self._clock
        is_single = command.is_momentary or command.target in self.times.silent
        tries = 1 if is_single else 1 + self._settings.retries
        limit, longest = self.times.expected(command.target, command.settings)
        answers_within = longest + command.transition
        interval = max((limit + command.transition) / tries, answers_within + _SPARE)
        patience = self._settings.timeout
        if command.moves and command.device.reachable.state != "no":
            patience = max(patience, _MOTION)
        lasts = max(interval * tries, patience + command.transition)
        end = clock.monotonic() + lasts
        for number in range(tries):
            if number > 0 and not await self._may_repeat(pending, changed, end):
                break
            is_refused = number > 0 and self._judge.refusal(command) is not None  # by what changed meanwhile
            if not is_refused:
                self._journal.sent(command, number)
                pending.note_sent(clock.monotonic())
                kept_for = interval - answers_within if number < tries - 1 else 0.0
                problem = await self._send(command, end - clock.monotonic(), kept_for, repeated=number > 0)
                if problem is None or (pending.is_verified and pending.is_met):
                    self._journal.note("acknowledged", command)
                elif number == 0:
                    return problem
                if number == 0:
                    end = clock.monotonic() + lasts  # a gateway may have had to connect before it was sent
            began, until = end - lasts, min(clock.monotonic() + interval, end)
            while not pending.is_over and (left := pending.waits_until(until, began) - clock.monotonic()) > 0:
                await changed.wait(left)
            is_on_its_way = pending.moved_at is not None and not pending.has_faded  # what stopped to fade is told again
            if pending.is_over or is_on_its_way or pending.gives_up(clock.monotonic()):
                break
        outcome = await self._outcome(pending, changed, clock.monotonic() if pending.has_stopped else end)
        if isinstance(outcome, NoAnswer) or is_single:
            self._note_silence(pending, outcome)
        return outcome

    def _note_silence(self, pending: PendingCommand, outcome: Outcome) -> None:
        """Note a dimmer that answered nothing: each repetition may have begun its ramp anew, so it is told once then.

        If it answers that, it is known how long it takes; else it is told three times again.
        """
        command = pending.command
        has_ramp = any(one.name == "level" and one.settable for one in command.part.part.capabilities)
        is_silent = isinstance(outcome, NoAnswer) and pending.sendings > 1 and has_ramp
        self.times.note_silence(command.target, is_silent=is_silent)

    async def _may_repeat(self, pending: PendingCommand, changed: Signal, end: float) -> bool:
        """Return whether to send it again, once that is known: where the connection was lost, it may have been obeyed.

        What a device reports after that says so, at the latest at *end*; one that reports nothing is told nothing.
        """
        lost_at = self._gateways.lost_at(pending.command.part.routes)
        while not pending.is_over and lost_at >= max(pending.first_sent_at, pending.told_otherwise_at):
            if (left := end - self._clock.monotonic()) <= 0:
                return False
            await changed.wait(left)
            lost_at = self._gateways.lost_at(pending.command.part.routes)
        return not pending.is_over

    async def _outcome(self, pending: PendingCommand, changed: Signal, until: float) -> Outcome:
        """Return the outcome; a device that usually answers sooner may be slow for once, and fails at *until* only."""
        while True:
            now = self._clock.monotonic()
            outcome = pending.outcome(now)
            if pending.is_over or isinstance(outcome, Confirmed | AlreadySo) or now >= until:
                return outcome
            await changed.wait(until - now)

    async def _send(self, command: IssuedCommand, seconds: float, kept_for: float, *, repeated: bool) -> Outcome | None:
        """Send the settings in their order, to be done in so many *seconds*; return the outcome where that fails."""
        began = self._clock.monotonic()
        if command.place in self._leases.parts:  # as hardly ever
            self._leases.note_stop(command.place, command.settings, began)
        self._judge.note_sent(command)  # before it waits: what is judged meanwhile must know of it
        try:
            for capability, value in command.settings.items():
                if command.place in self._leases.parts:  # since it was judged, or the setting before was sent
                    refused = self._leases.refuse(command, self._clock.monotonic())
                    if refused is not None:
                        return refused
                await self._sender.send(
                    command.device,
                    command.part,
                    capability,
                    value,
                    command.transition,
                    command.code,
                    seconds,
                    command.id,
                    kept_for,
                    repeated=repeated,
                )
        except LinkError as exc:
            return NoAnswer(self._clock.monotonic() - began, str(exc), command_id=command.id)
        except RefusedError as exc:
            return Refused("gateway", exc.reason, command_id=command.id)
        if self._clock.monotonic() - began > _AT_ONCE:
            self._judge.note_sent(command)  # it may not have reached the device before
        return None


@final
class Signal:
    """Wakes the one task that waits for news of a command; one that looks before it waits misses nothing.

    A future and a shared timer of the event loop: an event within a time limit would cost several times as much.

    Args:
        limits: Ends what waits too long.
    """

    def __init__(self, limits: TimeLimits) -> None:
        self._limits = limits
        self._waiter: asyncio.Future[None] | None = None

    def set(self) -> None:
        """Wake the task, if it waits."""
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)

    async def wait(self, seconds: float) -> None:
        """Wait until it is set, for so many seconds at most."""
        self._waiter = asyncio.get_running_loop().create_future()
        limit = self._limits.set(seconds, self.set)
        try:
            await self._waiter
        finally:
            self._limits.discard(limit)
