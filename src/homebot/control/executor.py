"""The steps of a command: resolve, rights, leases, policies, send, wait for evidence, journal."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple, TypeVar, final

from homebot.control import durations
from homebot.control.code_guesses import CodeGuesses
from homebot.control.command import IssuedCommand, commanded_part, device_settings, order_of, read_text, rounding_text
from homebot.control.group_batcher import GroupBatcher
from homebot.control.journal.given_codes import UNREAD, without_codes
from homebot.control.journal.journal import CommandJournal
from homebot.control.leases import Leases
from homebot.control.policies.rights import why_asked
from homebot.control.policy_engine import PolicyEngine
from homebot.control.questions import Questions
from homebot.control.sending import Sending, not_sent
from homebot.control.timeline.facts import Order
from homebot.control.timelines import Timelines
from homebot.devices import Device, DevicePart, RawCommand
from homebot.devices.always_ask import why_device_asks
from homebot.devices.client_rights import CLIENT_RIGHTS
from homebot.devices.command_messages import CommandRequest, SendTextRequest, SendTextResponse
from homebot.devices.command_sender import TextSender, TextTarget
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.outcomes import Outcome, Refused, no_such_part
from homebot.errors import LinkError, RefusedError, ServiceError
from homebot.graph import Node
from homebot.support.isolation import error_text

_T = TypeVar("_T")

_UNREADABLE: Final = "it always asks, and this text cannot be decoded as a command; command it by its handle"


class _Resolved(NamedTuple):
    """The resolved target of a command; *at* is when it was asked for, in seconds since the Unix epoch.

    Attributes:
        problem: Why it cannot be sent; None if it can.
        text: The text to send; None for values.
    """

    at: float
    device: Device | None
    part: DevicePart | None
    problem: Outcome | None = None
    text: TextTarget | None = None


@final
class CommandExecutor:
    """Carries out commands concurrently."""

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        policies: PolicyEngine,
        journal: CommandJournal,
        leases: Leases,
        timelines: Timelines,
        sending: Sending,
    ) -> None:
        self._clock = node.graph.clock
        self._lookup = lookup
        self._policies = policies
        self._journal = journal
        self.leases = leases
        self.timelines = timelines
        self._sending = sending
        self._texts = TextSender(node)
        self._together = GroupBatcher(node, lookup, policies, leases, timelines)
        self.codes = CodeGuesses(self._clock)
        self.questions = Questions(node, lookup, policies, journal)

    async def perform(self, request: CommandRequest) -> Outcome:
        """Carry out a command, and return its outcome."""
        asked_at, device, problem = self._clock.now(), None, None
        try:
            device = await self._lookup.device(request.device)
        except ServiceError as exc:
            problem = not_sent(exc)
        target = _Resolved(asked_at, device, commanded_part(device, request.part, request.settings), problem)
        return await self._carry_out(request, target, self._sending.send)

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
        target = _Resolved(asked_at, device, part, problem, text)
        outcome = await self._carry_out(command, target, partial(self._send_text, text))
        return SendTextResponse.of(outcome) if isinstance(outcome, Outcome) else outcome

    async def _carry_out(
        self, request: CommandRequest, target: _Resolved, send: Callable[[IssuedCommand], Awaitable[_T]]
    ) -> Outcome | _T:
        """Check a command, send it unless there is a problem, and return its outcome, which the journal records.

        Args:
            send: Sends the command; its result is no outcome if the journal has the end of the command already.
        """
        if self.timelines.learnt.is_awaited:  # the policies ask the timelines
            await self.timelines.learnt.load()
        asked_at, device, part, problem, text = target
        place = request.device, request.part if part is None else part.id
        shown = without_codes(request.settings, device, part)
        name = self._journal.record_request(request.issuer, place, shown, request.trigger, asked_at, device)
        outcome: Outcome | _T
        try:
            if problem is not None:
                outcome = replace(problem, command_id=name)
            elif device is None or part is None:
                outcome = no_such_part(request.device, request.part, device, name)
            else:
                command = self._issue(name, request, device, part, asked_at)
                command.text, command.has_code = text, shown is not request.settings
                if request.batch:
                    await self._together.join(command, request)
                refused: Outcome | None = None
                if request.ask_first or command.is_client or part.part.members:
                    refused, command = await self._agreed(command, ask_first=request.ask_first)
                outcome = refused or self.check(command) or await send(command)
                if isinstance(outcome, Outcome):
                    outcome = self._end(command, outcome)
        except BaseException as exc:
            is_cancelled = isinstance(exc, asyncio.CancelledError)
            why = "it was cancelled" if is_cancelled else f"homebot failed: {error_text(exc)}"
            self._journal.record_outcome(request.issuer, place, self._sending.break_off(name, why))
            raise
        finally:
            self._sending.open.pop(name, None)
        if isinstance(outcome, Outcome):
            self._journal.record_outcome(request.issuer, place, outcome)
        return outcome

    async def _agreed(self, command: IssuedCommand, *, ask_first: bool) -> tuple[Outcome | None, IssuedCommand]:
        """Return why *command* ends here, as a member or a person refuses it; and the command, once a person agreed."""
        if command.part.part.members:
            command.members = await self._lookup.members(command.device, command.part)
        refused: IssuedCommand | Outcome | None = self._together.refusal_of_members(command)
        if refused is None and (ask_first or self.questions.must_ask(command)):
            refused = self.check(command, is_preview=True) or await self.questions.ask_and_update(command)
        return (None, refused) if isinstance(refused, IssuedCommand) else (refused, command)

    def _end(self, command: IssuedCommand, outcome: Outcome) -> Outcome:
        """Return the outcome of a command with the warnings of its policies, and let its batch and its code know it."""
        if command.shared is not None:
            command.shared.leave(outcome)
        if command.nearest and outcome.succeeded:
            command.warnings["steps"] = command.nearest
        if command.transition and outcome.succeeded and not command.part.part.fades:
            command.warnings["transition"] = "it takes no transition"
        if command.code:
            self.codes.end(command, outcome)
        return replace(outcome, warning="; ".join(command.warnings.values())) if command.warnings else outcome

    def preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        """Return the refusal of *request* by the current rights and policies; nothing is recorded."""
        return self.check(self._issue("", request, device, part, self._clock.now()), is_preview=True)

    async def why_asked(self, request: CommandRequest, device: Device, part: DevicePart) -> str:
        """Return why a person must agree to *request*, by the part or one that it sets too; empty if none must."""
        command = self._issue("", request, device, part, self._clock.now())
        if self.check(command, is_preview=True) is not None or self.questions.must_ask(command):
            return ""  # it is refused, or asked of all, anyway
        values = {setting.capability: setting.value.plain() for setting in request.settings}
        members = await self._lookup.members(device, part) if part.part.members else ()
        reasons = (why_asked(its_device, its_part, values) for its_device, its_part in ((device, part), *members))
        return next(filter(None, reasons), "")

    def check(self, command: IssuedCommand, *, is_preview: bool = False) -> Refused | None:
        """Return the refusal of *command* by rights, leases, policies or its code; None if it may be sent now.

        Args:
            is_preview: Whether to ignore leases and codes, and not to record the verdicts in the journal.
        """
        if command.is_client and (problem := self._policies.client_refusal(command)):
            return Refused(CLIENT_RIGHTS, problem, command_id=command.id)
        if not is_preview and command.place in self.leases.parts:
            held = self.leases.refuse(command, self._clock.monotonic())
            if held is not None:
                return held
        refused = self._policies.check(command, is_recorded=not is_preview)
        return self.codes.begin(command) if refused is None and command.code and not is_preview else refused

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
        self._journal.record_sent(command.device.id, sent, self._clock.now(), is_code=command.has_code)
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

    def _issue(self, name: str, request: CommandRequest, device: Device, part: DevicePart, at: float) -> IssuedCommand:
        asked = {setting.capability: setting.value.plain() for setting in request.settings}
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
