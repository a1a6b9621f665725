"""Sending of commands, their repetition if no answer comes, and their outcomes."""

import asyncio
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Final, final

from homebot.control import durations
from homebot.control.command import IssuedCommand, certain_values, order_of
from homebot.control.journal.journal import CommandJournal
from homebot.control.journal.report_log import ReportLog
from homebot.control.leases import Leases
from homebot.control.open_command import OpenCommand, SimulatedExecution
from homebot.control.policy_engine import PolicyEngine
from homebot.control.settings import ControlSettings
from homebot.control.shared_sending import SharedSending
from homebot.control.timeline.evidence import SendingPlan, next_step, outcome_of
from homebot.control.timeline.facts import (
    NO_GROUP,
    Answered,
    Asked,
    Cause,
    Decided,
    LinkLost,
    Reported,
    SendingEnded,
    Sent,
    Withheld,
)
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.progress import CommandProgress, Undoing
from homebot.control.timelines import Timelines
from homebot.control.witnesses import Witness, Witnesses
from homebot.devices.command_messages import CommandEvent, CommandResult, Setting
from homebot.devices.command_sender import CommandSender
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.gateway_messages import Command
from homebot.devices.names import COMMAND_EVENTS
from homebot.devices.outcomes import AlreadySo, Gone, NoAnswer, Outcome, Refused, Reverted
from homebot.devices.value import PlainValue, Value
from homebot.devices.wording.journal_words import settings_text
from homebot.errors import LinkError, RefusedError, ServiceError, UnansweredError
from homebot.graph import Node
from homebot.support.time_limits import TimeLimits

MAX_PENDING: Final = 10_000
"""The limit of commands without an outcome; further ones are refused."""

REVERTED: Final = "control.reverted"
WOULD_SEND: Final = "control.would_send"


@final
class Sending:
    """Sends commands, and waits until the outcome of each is known.

    A command is sent again only if the last sending can have no effect any more: the network has dropped the copy that
    it stored for an unreachable device, and after a lost connection the device has to report another value first.

    Attributes:
        open: The commands without an outcome, by id; the caller removes those that have ended.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        lookup: DeviceLookup,
        policies: PolicyEngine,
        journal: CommandJournal,
        leases: Leases,
        timelines: Timelines,
        rehearsal: SimulatedExecution | None,
    ) -> None:
        self.rehearsal = rehearsal
        self._log = node.log
        self._settings = settings
        self._clock = node.graph.clock
        self._lookup = lookup
        self._policies = policies
        self._journal = journal
        self._leases = leases
        self._timelines = timelines
        self._feed = timelines.feed
        self._sender = CommandSender(node)
        self._events = node.create_publisher(CommandEvent, COMMAND_EVENTS, 1000)
        self._limits = TimeLimits()
        self.open: dict[str, OpenCommand] = {}
        timelines.on_news, timelines.on_undone = self._on_news, self._on_undone
        timelines.feed.on_answer = self._on_answer
        self.reports = ReportLog(journal, timelines)
        self.witnesses = Witnesses(node, settings, timelines.feed, lookup)

    async def send(self, command: IssuedCommand) -> Outcome:
        """Send a command unless its part is already so, and return its outcome by reports and witnesses."""
        if len(self.open) >= MAX_PENDING:
            reason = f"{MAX_PENDING:,} commands wait for their outcome"
            return Refused("control", reason, command_id=command.id)
        opened, is_so = self._begin(command)
        witnesses: list[Witness] = []
        try:
            if is_so:
                return self._decide(opened, AlreadySo(command_id=command.id))
            rehearsal = self.rehearsal
            if rehearsal is not None and (assumed := self.rehearse(command, opened.timeline)) is not None:
                await asyncio.sleep(durations.REHEARSED)
                self._decide(opened, AlreadySo(command_id=command.id))
                wanted = (
                    {name: wanted_value.value for name, wanted_value in opened.progress.wanted.items()}
                    if assumed.succeeded
                    else {}
                )
                reported = {setting.capability: setting.value.plain() for setting in command.public(wanted)}
                return replace(assumed, reported=reported)
            if command.members:
                members = self._timelines.command_members(opened.progress.order, command.members)
                opened.members, opened.progress.members = tuple(members), tuple(members.values())
                opened.progress.transmission.group = opened.progress.members[0].transmission.group
            witnesses = await self.witnesses.begin(opened)
            outcome = await self._run(opened)
            if witnesses:
                outcome = await self.witnesses.verify(opened, witnesses, outcome)
            if await self._is_gone(command, outcome):
                outcome = Gone(command_id=command.id)
            return self._decide(opened, outcome)
        finally:
            for witness in witnesses:
                witness.stop_watch()

    def break_off(self, name: str, why: str) -> Outcome:
        """Return the outcome of the command *name*, which is not sent again, and *why* if it was not sent at all."""
        opened = self.open.get(name)
        if opened is None:
            return NoAnswer(0.0, why, command_id=name)
        sendings = opened.progress.transmission
        waited, reason = self._clock.monotonic() - sendings.first_sent_at, "" if sendings.count else why
        return self._decide(opened, NoAnswer(waited, reason, command_id=name))

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

    async def _run(self, sent: OpenCommand) -> Outcome:
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
                is_taken = self._record_answer(sent, problem)
                if problem is not None and not is_taken and sendings.attempts == 1:
                    return problem
            else:
                sent.timeline.append(Withheld(command.id, now))
            if self._feed.losses:
                sent.timeline.append(LinkLost(command.id, self._feed.last_loss(command.part.routes).monotonic))
        return outcome_of(progress, clock.monotonic())

    def _begin(self, command: IssuedCommand) -> tuple[OpenCommand, bool]:
        """Append a command to its timeline; return it, and whether the part is already known to be as commanded.

        That is not known from recent values alone if a command failed since the last that was confirmed.
        """
        if self._leases.parts:
            self._leases.yield_to(command, self._clock.monotonic())
        timeline, order = self._timelines.of(command.device, command.part), order_of(command)
        is_at_rest = True
        for other in timeline.active:
            if other.is_open and not order.settings.keys().isdisjoint(other.order.settings):
                is_at_rest = False
        known, is_recent = dict[str, PlainValue](), False
        if command.place not in self.witnesses.contradicted:
            asked, lost = dict.fromkeys((*order.settings, *order.wanted)), self._feed.last_loss(command.part.routes)
            known, is_recent = certain_values(command, asked, timeline, lost.wall, self._clock)
        answers = not order.wanted and self._feed.is_answering(command.part.routes)
        progress = timeline.command(order, self._clock.monotonic(), known, command.values, answers=answers)
        opened = self.open[command.id] = OpenCommand(command, timeline, progress, self._limits)
        is_so = is_recent and is_at_rest and progress.was_so and not (progress.has_echo or order.is_always_sent)
        proofs = map(timeline.last_proved, (*order.settings, *order.wanted) if is_so else ())
        return opened, is_so and all(proof is None or proof.is_confirmed for proof in proofs)

    async def _is_gone(self, command: IssuedCommand, outcome: Outcome) -> bool:
        """Return whether the answer is missing because the device or its part was removed meanwhile."""
        if not (isinstance(outcome, NoAnswer) or (isinstance(outcome, Refused) and outcome.policy == "gateway")):
            return False
        await asyncio.sleep(0)  # the directory handles the messages that the gateway published before its answer
        try:
            device = await self._lookup.device(command.device.id)
        except ServiceError:
            return False
        return device is None or device.part(command.part.id) is None

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
            patience = max(profile.echo_patience(capability, limit + command.transition) for capability in echoes)
        return SendingPlan(tries, interval, lasts, interval - longest - command.transition, patience)

    async def _send(self, sent: OpenCommand, plan: SendingPlan) -> Outcome | None:
        """Send the settings in their order; return the outcome if that fails."""
        command, clock, profile = sent.command, self._clock, sent.timeline.profile
        ineffective = profile.ineffective if profile.failures else ()
        sendings = sent.progress.transmission
        began, is_repeated = clock.monotonic(), sendings.attempts > 0
        shared = None if is_repeated else command.shared
        self._record_sending(sent, began, shared)
        expires_after = plan.end(sendings) - began if is_repeated else plan.lasts
        kept_for = plan.keeps_for if sendings.attempts + 1 < plan.tries else 0.0
        orders: list[Command] = []
        for capability, value in command.in_order:
            orders += [
                Command(
                    key="",
                    part="",
                    capability=capability,
                    value=Value.of(value),
                    transition=command.transition,
                    code=command.code,
                    expires_after=expires_after,
                    id=command.id,
                    kept_for=kept_for,
                    repeated=is_repeated,
                )
            ]
        left: Sequence[Command] = orders
        routes, is_unacknowledged = list[str](), False
        is_shared: bool | None = False
        try:
            if shared is not None and (is_shared := await self._share(sent, shared, orders)) is not False:
                return None
            while left:
                if command.place in self._leases.parts:  # a lease that began since the check or the previous message
                    refused = self._leases.refuse(command, clock.monotonic())
                    if refused is not None:
                        return refused
                sending = self._sender.send(command.device, command.part, left, ineffective)
                if (accepted := await sent.acknowledged(sending)) is None:
                    is_unacknowledged, left = True, left[1:]
                    continue
                route, left = accepted
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

    def _record_sending(self, sent: OpenCommand, now: float, shared: SharedSending | None) -> None:
        """Record that a sending begins, before any wait: a check needs it."""
        command, is_repeated = sent.command, sent.progress.transmission.attempts > 0
        if shared is None:
            self._journal.record("sent", command, "again" if is_repeated else "")
        for timeline in (sent.timeline, *(sent.members if is_repeated else ())):
            timeline.append(Sent(command.id, command.settings, now))
        if command.place in self._leases.parts:
            self._leases.record_stop(command, now)

    def _record_answer(self, sent: OpenCommand, problem: Outcome | None) -> bool:
        """Record that the gateway or the device took the last sending; return whether one did."""
        progress, sendings = sent.progress, sent.progress.transmission
        is_acknowledged = problem is None and not sendings.is_unacknowledged
        if not (is_acknowledged or (progress.wanted and progress.is_met)):
            return False
        route = sendings.routes[-1] if sendings.routes and problem is None else ""
        self._journal.record("acknowledged", sent.command, route.partition("/")[0])
        return True

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

    async def _share(self, sent: OpenCommand, shared: SharedSending, orders: Sequence[Command]) -> bool | None:
        """Return whether *shared* was sent in place of a first sending; None if a newer command replaced this one.

        Raises:
            UnansweredError: It was sent, but not acknowledged.
        """
        command, sendings = sent.command, sent.progress.transmission
        sendings.group = shared.message
        on_sent = partial(self._journal.record, "sent", command, shared.name)
        if await sent.acknowledged(shared.send_with_group(orders, sent.progress, on_sent)) is not False:
            sent.progress.fellows = shared.progress
            return True
        sendings.group = NO_GROUP
        if sent.progress.superseded_by:
            return None
        self._journal.record("sent", command)
        return False

    def _decide(self, opened: OpenCommand, outcome: Outcome) -> Outcome:
        opened.timeline.append(Decided(opened.command.id, self._clock.monotonic(), outcome))
        self._timelines.schedule(opened.command.place)
        return outcome

    def _on_news(self, progress: CommandProgress, fact: Reported | None) -> None:
        """Record a report for a command, and wake the task that waits for it or for its end."""
        opened = self.open.get(progress.order.id)
        if fact is not None:
            self.reports.on_report(progress, fact, opened if progress.is_open else None)
        if opened is not None:
            opened.wake()

    def _on_undone(self, progress: CommandProgress, undoing: Undoing, value: PlainValue, cause: Cause) -> None:
        order = progress.order
        outcome = Reverted(undoing.after, cause.value, command_id=order.id)
        device, part = order.place
        self._journal.record_revert(order.issuer, order.place, outcome, Setting.of(undoing.capability, value))
        self._events.publish(
            CommandEvent(device=device, part=part, issuer=order.issuer, result=CommandResult.of(outcome))
        )
        self._log.warning(REVERTED, message=f"{order.label}: {outcome.text}", device=device, command=order.id)

    def _on_answer(self, command: str, capability: str, problem: str) -> None:
        opened = self.open.get(command)
        if opened is not None and capability in opened.command.settings:
            opened.timeline.append(Answered(command, self._clock.monotonic(), capability, problem))
            opened.wake()


def not_sent(error: LinkError | RefusedError | ServiceError, waited: float = 0.0, command_id: str = "") -> Outcome:
    """Return the outcome of a command that no gateway took because of *error*."""
    if isinstance(error, RefusedError):
        return Refused("gateway", error.reason, command_id=command_id)
    return NoAnswer(waited, str(error), command_id=command_id)
