"""Sending of commands, and their repetition if no answer comes."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass, field
from typing import final

from homebot.control import durations
from homebot.control.command import IssuedCommand
from homebot.control.gateway_feed import GatewayFeed
from homebot.control.journal.journal import CommandJournal
from homebot.control.leases import Leases
from homebot.control.policy_engine import PolicyEngine
from homebot.control.settings import ControlSettings
from homebot.control.timeline.evidence import SendingPlan, next_step, outcome_of
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.command_sender import CommandSender
from homebot.devices.outcomes import NoAnswer, Outcome, Refused
from homebot.errors import LinkError, RefusedError
from homebot.graph import Node
from homebot.support.time_limits import TimeLimits

__all__ = ["OpenCommand", "Sending", "Signal"]


@final
class Signal:
    """Wakes the one task that waits for news of a command; a task that looks before it waits misses nothing.

    A future and a shared timer of the event loop: an event within a time limit would cost several times as much.

    Args:
        limits: Ends waits that take too long.
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


@dataclass(slots=True, eq=False)
class OpenCommand:
    """A command without an outcome.

    Attributes:
        command: The command.
        timeline: The timeline of its part.
        progress: Its progress.
        changed: Wakes the task that waits for it.
        recorded: The last report of each capability in the journal, which does not get the same one again.
    """

    command: IssuedCommand
    timeline: PartTimeline
    progress: CommandProgress
    changed: Signal
    recorded: dict[str, object] = field(default_factory=dict)

    def outcome(self, now: float) -> Outcome:
        """Return the outcome as it is at *now*."""
        return outcome_of(self.progress, now)


@final
class Sending:
    """Sends commands, and waits until the outcome of each is known.

    A command is sent again only if the last sending cannot have an effect any more: the network has dropped its copy
    for an unreachable device, and after a lost connection the device has to report another value first.

    Args:
        node: The node that sends them.
        settings: The time limit and the number of repetitions.
        policies: Checks each repetition.
        journal: Records each sending.
        leases: The held values.
        feed: Knows lost connections.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        policies: PolicyEngine,
        journal: CommandJournal,
        leases: Leases,
        feed: GatewayFeed,
    ) -> None:
        self._settings = settings
        self._clock = node.graph.clock
        self._policies = policies
        self._journal = journal
        self._leases = leases
        self._feed = feed
        self._sender = CommandSender(node)

    async def run(self, sent: OpenCommand) -> Outcome:
        """Send a command, and again if no answer comes; return its outcome."""
        plan, progress, clock = self._plan(sent), sent.progress, self._clock
        while (step := next_step(progress, plan, now := clock.monotonic())).kind != "done":
            if step.kind == "wait":
                await sent.changed.wait(step.until - now)
            elif (problem := await self._attempt(sent, plan)) is not None:
                return problem
            plan.lost_at = self._feed.last_loss(sent.command.part.routes).monotonic
        return outcome_of(progress, clock.monotonic())

    def _plan(self, sent: OpenCommand) -> SendingPlan:
        command, profile, timeout = sent.command, sent.timeline.profile, self._settings.timeout
        tries = 1 if command.is_momentary or profile.is_told_once else 1 + self._settings.retries
        limit, longest = profile.answer_time(command.settings, timeout)
        interval = max((limit + command.transition) / tries, longest + command.transition + durations.BETWEEN_SENDINGS)
        if command.moves and command.device.reachable.state != "no":
            timeout = max(timeout, durations.MOTOR_SILENCE)
        lasts = max(interval * tries, timeout + command.transition)
        plan = SendingPlan(tries, interval, lasts, keeps_for=interval - longest - command.transition)
        if echoes := sent.progress.order.echoed | sent.progress.suspected:
            plan.echo_patience = max(profile.echo_patience(one, limit + command.transition) for one in echoes)
        return plan

    async def _attempt(self, sent: OpenCommand, plan: SendingPlan) -> Outcome | None:
        """Send a command, unless a policy refuses its repetition; return the outcome if it was never sent."""
        command, progress, clock = sent.command, sent.progress, self._clock
        number, plan.attempts = plan.attempts, plan.attempts + 1
        problem: Outcome | None = None
        if number == 0 or self._policies.check(command) is None:
            self._journal.sent(command, number)
            sent.timeline.send(progress, clock.monotonic())
            left = plan.began + plan.lasts - clock.monotonic() if number else plan.lasts
            kept_for = plan.keeps_for if plan.attempts < plan.tries else 0.0
            problem = await self._send(command, left, kept_for, repeated=number > 0)
            if problem is None or (progress.wanted and progress.is_met):
                self._journal.record("acknowledged", command)
                problem = None
        plan.asked_at = clock.monotonic()
        if plan.began == -math.inf:
            plan.began = plan.asked_at
        return problem if number == 0 else None

    async def _send(self, command: IssuedCommand, seconds: float, kept_for: float, *, repeated: bool) -> Outcome | None:
        """Send the settings in their order within *seconds*; return the outcome if that fails."""
        began = self._clock.monotonic()
        self._leases.record_stop(command, began)
        self._policies.record_sent(command)  # before it waits: a check meanwhile needs it
        try:
            for capability, value in command.settings.items():
                if command.place in self._leases.parts:  # since the check, or the setting before
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
        if self._clock.monotonic() - began > durations.SENT_AT_ONCE:
            self._policies.record_sent(command)  # it may not have reached the device before
        return None
