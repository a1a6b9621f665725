"""The steps of a command: resolve, rights, leases, policies, send, wait for evidence, journal."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import Final, TypeVar, final

from homebot.control import durations
from homebot.control.code_guesses import CodeGuesses
from homebot.control.command import (
    IssuedCommand,
    certain_values,
    commanded_part,
    device_settings,
    order_of,
    read_text,
    rounding_text,
)
from homebot.control.gateway_feed import GatewayFeed
from homebot.control.journal.given_codes import UNREAD, without_codes
from homebot.control.journal.journal import CommandJournal
from homebot.control.journal.report_log import ReportLog
from homebot.control.learnt import LearntPersistence
from homebot.control.leases import Leases
from homebot.control.policies.rights import why_asked
from homebot.control.policy_engine import PolicyEngine
from homebot.control.questions import Questions
from homebot.control.sending import OpenCommand, Rehearsal, Sending, not_sent
from homebot.control.settings import ControlSettings
from homebot.control.timeline.facts import Answered, Cause, Decided, Order, Reported
from homebot.control.timeline.progress import CommandProgress, Undoing
from homebot.control.timelines import Timelines
from homebot.control.together import Together
from homebot.control.witnesses import Witness, Witnesses
from homebot.devices import Device, DevicePart, RawCommand
from homebot.devices.always_ask import why_device_asks
from homebot.devices.client_rights import CLIENT_RIGHTS
from homebot.devices.command_messages import (
    CommandEvent,
    CommandRequest,
    CommandResult,
    SendTextRequest,
    SendTextResponse,
)
from homebot.devices.command_sender import TextSender, TextTarget
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import COMMAND_EVENTS
from homebot.devices.outcomes import (
    AlreadySo,
    Gone,
    NoAnswer,
    Outcome,
    Refused,
    Reverted,
    no_such_part,
)
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, ServiceError
from homebot.graph import Node
from homebot.support.time_limits import TimeLimits

_T = TypeVar("_T")

REVERTED = "control.reverted"

_UNREADABLE: Final = "it always asks, and this text cannot be decoded as a command; command it by its handle"

_CANCELLED: Final = "it was cancelled"

MOST_PENDING: Final = 10_000
"""The limit of commands without an outcome; further ones are refused."""


@final
class CommandExecutor:
    """Carries out commands concurrently."""

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        lookup: DeviceLookup,
        policies: PolicyEngine,
        journal: CommandJournal,
        leases: Leases,
        timelines: Timelines,
        feed: GatewayFeed,
        learnt: LearntPersistence,
        rehearsal: Rehearsal | None = None,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._policies = policies
        self._journal = journal
        self.leases = leases
        self.timelines = timelines
        self._feed = feed
        self._learnt = learnt
        self._sending = Sending(node, settings, policies, journal, leases, feed, rehearsal)
        self._texts = TextSender(node)
        self._together = Together(node, lookup, policies, leases, timelines)
        self._events = node.create_publisher(CommandEvent, COMMAND_EVENTS, 1000)
        self._limits, self._open = TimeLimits(), dict[str, OpenCommand]()
        timelines.on_news, timelines.on_undone = self._on_news, self._on_undone
        feed.on_answer = self._on_answer
        self.reports = ReportLog(journal, timelines)
        self.witnesses = Witnesses(node, settings, feed, lookup)
        self.codes = CodeGuesses(self._clock)
        self.questions = Questions(node, lookup, policies, journal)

    async def perform(self, request: CommandRequest) -> Outcome:
        """Carry out a command, and return its outcome."""
        asked_at, device, problem = self._clock.now(), None, None
        try:
            device = await self._lookup.device(request.device)
        except ServiceError as exc:
            problem = not_sent(exc)
        part = commanded_part(device, request.part, request.settings)
        return await self._carry_out(request, asked_at, device, part, problem, self._send)

    async def send_text(self, request: SendTextRequest) -> SendTextResponse:
        """Carry out a command by a raw text, and return when its gateway has queued it; never raises."""
        asked_at, device, text, problem = self._clock.now(), None, TextTarget(request.payload), None
        try:
            device = await self._lookup.device(request.device)
            if device is not None:
                text = self._texts.target(device, request.payload)
        except (LinkError, RefusedError, ServiceError) as exc:
            problem = not_sent(exc)
        part, read = read_text(device, text)
        if read.capability == UNREAD and device is not None and why_device_asks(device):
            problem = problem or Refused("always_ask", _UNREADABLE)
        issuer, scope, trigger = request.issuer, request.scope, request.trigger
        command = CommandRequest(device=request.device, settings=(read,), issuer=issuer, scope=scope, trigger=trigger)
        send = partial(self._send_text, text)
        outcome = await self._carry_out(command, asked_at, device, part, problem, send, text)
        return SendTextResponse.of(outcome) if isinstance(outcome, Outcome) else outcome

    async def _carry_out(
        self,
        request: CommandRequest,
        asked_at: float,
        device: Device | None,
        part: DevicePart | None,
        problem: Outcome | None,
        send: Callable[[IssuedCommand], Awaitable[_T]],
        text: TextTarget | None = None,
    ) -> Outcome | _T:
        """Check a command, send it unless there is a *problem*, and return its outcome, which the journal records.

        Args:
            send: Sends the command; its result is no outcome if the journal has the end of the command already.
        """
        place = request.device, request.part if part is None else part.id
        shown = without_codes(request.settings, device, part)
        name = self._journal.requested(request.issuer, place, shown, request.trigger, asked_at, device)
        outcome: Outcome | _T
        try:
            if problem is not None:
                outcome = replace(problem, command_id=name)
            elif device is None or part is None:
                outcome = no_such_part(request.device, request.part, device, name)
            else:
                command = self._issued(name, request, device, part, asked_at)
                command.text, command.has_code = text, shown is not request.settings
                if part.part.members:
                    command.members = await self._lookup.members(device, part)
                if request.batch:
                    await self._together.join(command, request)
                is_checked = request.ask_first or command.is_client or command.members
                agreed = await self._agreed(command, ask_first=request.ask_first) if is_checked else command
                outcome = agreed if isinstance(agreed, Outcome) else self.check(agreed) or await send(agreed)
                if isinstance(outcome, Outcome):
                    outcome = self._ended(command, outcome)
        except asyncio.CancelledError:
            self._journal.decided(request.issuer, place, self._cancelled(name))
            raise
        finally:
            self._open.pop(name, None)
        if isinstance(outcome, Outcome):
            self._journal.decided(request.issuer, place, outcome)
        return outcome

    async def _agreed(self, command: IssuedCommand, *, ask_first: bool = False) -> IssuedCommand | Outcome:
        """Return *command* if no member refuses it, and once a person has agreed, if one must; else its outcome."""
        if (refused := self._together.refusal_of_members(command)) is not None:
            return refused
        if not (ask_first or self.questions.must_ask(command)):
            return command
        return self.check(command, is_preview=True) or await self.questions.agreed(command)

    def _ended(self, command: IssuedCommand, outcome: Outcome) -> Outcome:
        """Return the outcome of a command with the warnings of its policies, and let its batch and its code know it."""
        if command.shared is not None:
            command.shared.leave(outcome)
        if command.nearest and outcome.succeeded:
            command.warnings["steps"] = command.nearest
        if command.code:
            self.codes.end(command, outcome)
        return replace(outcome, warning="; ".join(command.warnings.values())) if command.warnings else outcome

    def preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        """Return the refusal of *request* by the current rights and policies; nothing is recorded."""
        return self.check(self._issued("", request, device, part, self._clock.now()), is_preview=True)

    async def why_asked(self, request: CommandRequest, device: Device, part: DevicePart) -> str:
        """Return why a person must agree to *request*, by the part or one that it sets too; empty if none must."""
        command = self._issued("", request, device, part, self._clock.now())
        if self.check(command, is_preview=True) is not None or self.questions.must_ask(command):
            return ""  # it is refused, or asked of all, anyway
        values = {one.capability: one.value.plain() for one in request.settings}
        members = await self._lookup.members(device, part) if part.part.members else ()
        reasons = (why_asked(its_device, its_part, values) for its_device, its_part in ((device, part), *members))
        return next(filter(None, reasons), "")

    def check(self, command: IssuedCommand, *, is_preview: bool = False) -> Refused | None:
        """Return the refusal of *command* by rights, leases or policies; None if it may be sent now.

        Args:
            is_preview: Whether to ignore leases and not to record the verdicts in the journal.
        """
        if command.is_client and (problem := self._policies.client_refusal(command)):
            return Refused(CLIENT_RIGHTS, problem, command_id=command.id)
        if not is_preview and command.place in self.leases.parts:
            held = self.leases.refuse(command, self._clock.monotonic())
            if held is not None:
                return held
        return self._policies.check(command, is_recorded=not is_preview)

    async def _send_text(self, text: TextTarget, command: IssuedCommand) -> Outcome | SendTextResponse:
        """Send a text, which supersedes older commands for the same; no report is awaited."""
        if self._sending.rehearsal is not None:
            assumed = self._sending.rehearse(command, self.timelines.of(command.device, command.part))
            if assumed is not None:
                return assumed
        self._record_text(command, order_of(command), self._clock.monotonic())
        try:
            sent = await self._texts.send(text, command.issuer, command.trigger, command.id, command.part.routes)
        except LinkError as exc:
            return not_sent(exc, command_id=command.id)
        self._journal.published(command.device.id, sent, self._clock.now(), is_code=command.has_code)
        return SendTextResponse(success=True, others=text.others, command_id=command.id)

    async def record_raw(self, name: str, device: Device, gateway: str, raw: RawCommand) -> None:
        """Record that another program had *gateway* send a text to *device*; *name* is the new id of the command."""
        part, read = read_text(device, TextTarget(raw.payload, gateway, raw.address))
        rights, settings = self._policies.rights(raw.issuer), {read.capability: read.value.plain()}
        command = IssuedCommand(name, device, part, settings, raw.issuer, rights, raw.trigger, self._clock.now())
        order = replace(order_of(command), is_foreign=True)
        self._record_text(command, order, self._clock.monotonic() - durations.OVERTAKEN)
        if part.part.members:
            self.timelines.command_members(order, await self._lookup.members(device, part))

    def _record_text(self, command: IssuedCommand, order: Order, at: float) -> None:
        """Record that *command* is sent as a text, which is for all parts of its device if it is not understood."""
        device = command.device
        is_for_all = UNREAD in command.settings and device.parts
        parts = device.parts if is_for_all else (command.part,)
        if self.leases.parts:
            for part in parts:
                self.leases.yield_to(replace(command, part=part), at)
            self.leases.record_stop(command, at)
        for part in parts:
            self.timelines.of(device, part).command(order, at, is_raw=True)
        if command.members:
            self.timelines.command_members(order, command.members)

    def _issued(self, name: str, request: CommandRequest, device: Device, part: DevicePart, at: float) -> IssuedCommand:
        asked = {one.capability: one.value.plain() for one in request.settings}
        settings = device_settings(asked, part.part)
        return IssuedCommand(
            name,
            device,
            part,
            settings,
            request.issuer,
            self._policies.rights(request.issuer),
            request.trigger,
            at,
            request.scope,
            transition=request.transition,
            override=request.override,
            code=request.code,
            nearest="" if settings is asked else rounding_text(asked, settings),
        )

    async def _send(self, command: IssuedCommand) -> Outcome:
        """Send a command unless its part is already so, and return its outcome by reports and witnesses."""
        if len(self._open) >= MOST_PENDING:
            reason = f"{MOST_PENDING:,} commands wait for their outcome"
            return Refused("control", reason, command_id=command.id)
        if command.code and (refused := self.codes.begin(command)) is not None:
            return refused
        if self._learnt.is_awaited:
            await self._learnt.load()
        opened, is_so = self._begin(command)
        witnesses: list[Witness] = []
        try:
            if is_so:
                return self._decided(opened, AlreadySo(command_id=command.id))
            rehearsal = self._sending.rehearsal
            if rehearsal is not None and (assumed := self._sending.rehearse(command, opened.timeline)) is not None:
                return await self._rehearsed(opened, assumed)
            if command.members:
                members = self.timelines.command_members(opened.progress.order, command.members)
                opened.members, opened.progress.members = tuple(members), tuple(members.values())
            witnesses = await self.witnesses.begin(opened)
            outcome = await self._sending.run(opened)
            if witnesses:
                outcome = await self.witnesses.verify(opened, witnesses, outcome)
            if await self._is_gone(command, outcome):
                outcome = Gone(command_id=command.id)
            return self._decided(opened, outcome)
        finally:
            for witness in witnesses:
                witness.stop_watch()

    def _cancelled(self, name: str) -> Outcome:
        """Return the outcome of the command *name*, which its issuer cancelled: it is not sent again."""
        opened = self._open.get(name)
        if opened is None:
            return NoAnswer(0.0, _CANCELLED, command_id=name)
        sendings = opened.progress.transmission
        waited, reason = self._clock.monotonic() - sendings.first_sent_at, "" if sendings.count else _CANCELLED
        return self._decided(opened, NoAnswer(waited, reason, command_id=name))

    def _begin(self, command: IssuedCommand) -> tuple[OpenCommand, bool]:
        """Append a command to its timeline; return it, and whether the part is already known to be as commanded."""
        if self.leases.parts:
            self.leases.yield_to(command, self._clock.monotonic())
        timeline, order = self.timelines.of(command.device, command.part), order_of(command)
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
        opened = self._open[command.id] = OpenCommand(command, timeline, progress, self._limits)
        is_so = is_recent and is_at_rest and progress.was_so
        return opened, is_so and not (progress.has_echo or order.is_always_sent)

    async def _rehearsed(self, opened: OpenCommand, assumed: Outcome) -> Outcome:
        await asyncio.sleep(durations.REHEARSED)
        command = opened.command
        self._decided(opened, AlreadySo(command_id=command.id))
        wanted = {name: one.value for name, one in opened.progress.wanted.items()} if assumed.succeeded else {}
        reported = {one.capability: one.value.plain() for one in command.public(wanted)}
        return replace(assumed, reported=reported)

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

    def _decided(self, opened: OpenCommand, outcome: Outcome) -> Outcome:
        opened.timeline.append(Decided(opened.command.id, self._clock.monotonic(), outcome))
        self.timelines.schedule(opened.command.place)
        return outcome

    def _on_news(self, progress: CommandProgress, fact: Reported | None) -> None:
        """Record a report for a command, and wake the task that waits for it or for its end."""
        opened = self._open.get(progress.order.id)
        if fact is not None:
            self.reports.on_report(progress, fact, opened if progress.is_open else None)
        if opened is not None:
            opened.wake()

    def _on_undone(self, progress: CommandProgress, undoing: Undoing, cause: Cause) -> None:
        order, by = progress.order, "device" if cause is Cause.DEVICE else "unknown"
        outcome = Reverted(undoing.after, by, command_id=order.id)
        device, part = order.place
        self._journal.decided(order.issuer, order.place, outcome, "reverted")
        self._events.publish(
            CommandEvent(device=device, part=part, issuer=order.issuer, result=CommandResult.of(outcome))
        )
        self._node.log.warning(REVERTED, message=f"{order.label}: {outcome.text}", device=device, command=order.id)

    def _on_answer(self, command: str, capability: str, problem: str) -> None:
        opened = self._open.get(command)
        if opened is not None and capability in opened.command.settings:
            opened.timeline.append(Answered(command, self._clock.monotonic(), capability, problem))
            opened.wake()
