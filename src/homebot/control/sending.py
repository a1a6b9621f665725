"""Sending of commands, and their repetition if no answer comes."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar, Final, Protocol, TypeVar, final

from homebot.control import durations
from homebot.control.command import IssuedCommand
from homebot.control.gateway_feed import GatewayFeed
from homebot.control.journal.journal import CommandJournal
from homebot.control.leases import Leases
from homebot.control.policy_engine import PolicyEngine
from homebot.control.settings import ControlSettings
from homebot.control.shared_sending import SharedSending
from homebot.control.timeline.evidence import SendingPlan, next_step, outcome_of
from homebot.control.timeline.facts import Asked, LinkLost, Reported, ReportRole, SendingEnded, Sent, Withheld
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.command_sender import CommandSender
from homebot.devices.gateway_messages import Command
from homebot.devices.outcomes import NoAnswer, Outcome, Refused
from homebot.devices.value import Value
from homebot.devices.wording.journal_words import settings_text
from homebot.errors import LinkError, RefusedError, ServiceError, UnansweredError
from homebot.graph import Node
from homebot.support.time_limits import TimeLimits

_T = TypeVar("_T")

WOULD_SEND: Final = "control.would_send"

_MOST_RECORDED: Final = 20
"""The limit of reports of one command in the journal."""

_ON_THE_WAY: Final = frozenset({ReportRole.STEP, ReportRole.ASTRAY})


class Rehearsal(Protocol):
    """Answers commands instead of sending them.

    Attributes:
        is_live: Whether the devices are real, so a raw command has no effect; in a replay it has its recorded effect.
    """

    is_live: ClassVar[bool]

    def outcome(self, command: IssuedCommand) -> Outcome | None:
        """Return the assumed outcome of *command*; None to send it to a muted gateway."""
        ...


@dataclass(slots=True, eq=False)
class OpenCommand:
    """A command without an outcome.

    Its only task waits with a future and a shared timer: an event with a timeout would cost several times as much.

    Attributes:
        recorded: The last report of each capability in the journal, which does not record it twice.
        members: The timelines of the members of a group.
    """

    command: IssuedCommand
    timeline: PartTimeline
    progress: CommandProgress
    limits: TimeLimits
    recorded: dict[str, object] = field(default_factory=dict)
    members: tuple[PartTimeline, ...] = ()
    _acknowledging: asyncio.Timeout | None = None
    _waiter: asyncio.Future[None] | None = None

    def is_news(self, fact: Reported) -> bool:
        """Return whether a report differs from the last recorded one, and remember it; all steps on the way are one."""
        role = fact.attribution.role if fact.attribution.command == self.command.id else None
        news = (ReportRole.STEP, None) if role in _ON_THE_WAY else (role is ReportRole.ECHO, fact.value)
        if self.recorded.get(fact.capability) == news or len(self.recorded) >= _MOST_RECORDED:
            return False
        self.recorded[fact.capability] = news
        return True

    def wake(self) -> None:
        """Wake the task if it is waiting; a task that checks before it waits misses nothing."""
        limit, progress = self._acknowledging, self.progress
        if limit is not None and limit.when() is None and progress.wanted and progress.over_at == -math.inf:
            limit.reschedule(asyncio.get_running_loop().time() + durations.ACKNOWLEDGED_TOO)
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)

    async def wait(self, seconds: float) -> None:
        """Wait up to *seconds* for news."""
        self._waiter = asyncio.get_running_loop().create_future()
        limit = self.limits.set(seconds, self.wake)
        try:
            await self._waiter
        finally:
            self.limits.discard(limit)

    async def acknowledged(self, sending: Awaitable[_T]) -> _T | None:
        """Return the result of *sending*; None if it has none a second after the part reported what was wanted."""
        limit = self._acknowledging = asyncio.timeout(None)
        try:
            async with limit:
                return await sending
        except TimeoutError:
            if not limit.expired():
                raise
            return None
        finally:
            self._acknowledging = None


@final
class Sending:
    """Sends commands, and waits until the outcome of each is known.

    A command is sent again only if the last sending can have no effect any more: the network has dropped the copy that
    it stored for an unreachable device, and after a lost connection the device has to report another value first.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        policies: PolicyEngine,
        journal: CommandJournal,
        leases: Leases,
        feed: GatewayFeed,
        rehearsal: Rehearsal | None,
    ) -> None:
        self.rehearsal = rehearsal
        self._log = node.log
        self._settings = settings
        self._clock = node.graph.clock
        self._policies = policies
        self._journal = journal
        self._leases = leases
        self._feed = feed
        self._sender = CommandSender(node)

    async def run(self, sent: OpenCommand) -> Outcome:
        """Send a command, and again if no answer comes; return its outcome."""
        plan, command, progress, clock = self._plan(sent), sent.command, sent.progress, self._clock
        sendings = progress.transmission
        while (step := next_step(progress, plan, now := clock.monotonic())).kind != "done":
            if step.kind == "wait":
                await sent.wait(step.until - now)
            elif sendings.attempts > sendings.asked_after and (sent.members or command.shared):
                await self._ask(sent, plan)
            elif sendings.attempts == 0 or self._policies.check(command) is None:
                problem = await self._send(sent, plan)
                is_acknowledged = problem is None and not sendings.is_unacknowledged
                if is_acknowledged or (progress.wanted and progress.is_met):
                    route = sendings.routes[-1] if sendings.routes and problem is None else ""
                    self._journal.record("acknowledged", command, route.partition("/")[0])
                elif problem is not None and sendings.attempts == 1:
                    return problem
            else:
                sent.timeline.append(Withheld(command.id, now))
            if self._feed.losses:
                sent.timeline.append(LinkLost(command.id, self._feed.last_loss(command.part.routes).monotonic))
        return outcome_of(progress, clock.monotonic())

    def rehearse(self, command: IssuedCommand, timeline: PartTimeline) -> Outcome | None:
        """Record and return the outcome that a rehearsal assumes for *command*; None to send the command."""
        outcome = None if self.rehearsal is None else self.rehearsal.outcome(command)
        if outcome is not None:
            now = self._clock.monotonic()
            self._leases.record_stop(command, now)
            timeline.append(Sent(command.id, command.settings, now))
            self._journal.record("would", command)
            text = f"{command.issuer.removeprefix('/')} would set {command.label} → {settings_text(command.public())}"
            self._log.info(WOULD_SEND, message=text, device=command.device.id, command=command.id)
        return outcome

    def _plan(self, sent: OpenCommand) -> SendingPlan:
        command, order, profile = sent.command, sent.progress.order, sent.timeline.profile
        timeout = self._settings.timeout
        tries = 1 + self._settings.retries + (command.shared is not None)  # that is no try to reach this part alone
        tries = 1 if order.is_told_once or profile.is_told_once else tries
        limit, longest = profile.answer_time(command.settings, timeout)
        interval = max((limit + command.transition) / tries, longest + command.transition + durations.BETWEEN_SENDINGS)
        if order.moves and command.device.reachable.state != "no":
            timeout = max(timeout, durations.MOTOR_SILENCE)
        lasts = max(interval * tries, timeout + command.transition)
        echoes = order.echoed | sent.progress.suspected
        patience = math.inf
        if echoes:
            patience = max(profile.echo_patience(one, limit + command.transition) for one in echoes)
        return SendingPlan(tries, interval, lasts, interval - longest - command.transition, patience)

    async def _send(self, sent: OpenCommand, plan: SendingPlan) -> Outcome | None:
        """Send the settings in their order; return the outcome if that fails."""
        command, clock, profile = sent.command, self._clock, sent.timeline.profile
        ineffective = profile.ineffective if profile.failures else ()
        sendings = sent.progress.transmission
        began, is_repeated = clock.monotonic(), sendings.attempts > 0
        shared = None if is_repeated else command.shared
        if shared is None:
            self._journal.record("sent", command, "again" if is_repeated else "")
        for timeline in (sent.timeline, *(sent.members if is_repeated else ())):
            timeline.append(Sent(command.id, command.settings, began))  # before any wait: a check needs it
        if command.place in self._leases.parts:
            self._leases.record_stop(command, began)
        order_of = partial(
            Command,
            key="",
            part="",
            transition=command.transition,
            code=command.code,
            expires_after=plan.end(sendings) - began if is_repeated else plan.lasts,
            id=command.id,
            kept_for=plan.keeps_for if sendings.attempts + 1 < plan.tries else 0.0,
            repeated=is_repeated,
        )
        routes, is_unacknowledged = list[str](), False
        is_shared: bool | None = False
        try:
            if shared is not None and (is_shared := await self._share(sent, shared, order_of)) is not False:
                return None
            orders: Sequence[Command] = [
                order_of(capability=capability, value=Value.of(value)) for capability, value in command.in_order
            ]
            while orders:
                if command.place in self._leases.parts:  # a lease that began since the check or the previous message
                    refused = self._leases.refuse(command, clock.monotonic())
                    if refused is not None:
                        return refused
                sending = self._sender.send(command.device, command.part, orders, ineffective)
                if (accepted := await sent.acknowledged(sending)) is None:
                    is_unacknowledged, orders = True, orders[1:]
                    continue
                route, orders = accepted
                if len(command.part.routes) > 1:
                    routes.append(route.name)
        except UnansweredError:
            is_unacknowledged = True
        except (LinkError, RefusedError) as exc:
            return not_sent(exc, clock.monotonic() - began, command.id)
        finally:
            ended = SendingEnded(command.id, clock.monotonic(), tuple(routes), is_unacknowledged, bool(is_shared))
            sent.timeline.append(ended)
        return None

    async def _ask(self, sent: OpenCommand, plan: SendingPlan) -> None:
        """Have the part, or the members of a group, asked for their values before a message that may be needless."""
        command, clock, can_answer = sent.command, self._clock, await self._sender.refresh(sent.command.part)
        for _, part in () if can_answer else command.members:
            can_answer = await self._sender.refresh(part) or can_answer
        sent.timeline.append(Asked(command.id, clock.monotonic(), can_answer))
        until = clock.monotonic() + (min(plan.interval, durations.ANSWER_SPARE) if can_answer else 0.0)
        while (
            sent.progress.may_repeat and sent.progress.over_at == math.inf and (left := until - clock.monotonic()) > 0
        ):
            await sent.wait(left)

    async def _share(self, sent: OpenCommand, shared: SharedSending, order_of: Callable[..., Command]) -> bool | None:
        """Return whether *shared* was sent in place of a first sending; None if a newer command replaced this one.

        Raises:
            UnansweredError: It was sent, but not acknowledged.
        """
        command, sendings = sent.command, sent.progress.transmission
        sendings.echoed = shared.echoed
        orders = [order_of(capability=one, value=Value.of(value)) for one, value in command.in_order]
        on_sent = partial(self._journal.record, "sent", command, shared.name)
        if await sent.acknowledged(shared.carry(orders, sent.progress, on_sent)) is not False:
            sent.progress.fellows = shared.progress
            return True
        sendings.echoed = frozenset()
        if sent.progress.superseded_by:
            return None
        self._journal.record("sent", command)
        return False


def not_sent(error: LinkError | RefusedError | ServiceError, waited: float = 0.0, command_id: str = "") -> Outcome:
    """Return the outcome of a command that no gateway took because of *error*."""
    if isinstance(error, RefusedError):
        return Refused("gateway", error.reason, command_id=command_id)
    return NoAnswer(waited, str(error), command_id=command_id)
