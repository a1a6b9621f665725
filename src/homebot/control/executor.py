"""Execution of commands: found, allowed, sent, and their outcome known."""

from __future__ import annotations

import asyncio
from functools import lru_cache
from typing import Final, final

from homebot.control import durations
from homebot.control.client_commands import POLICY
from homebot.control.command import IssuedCommand, order_of, zero_as_off
from homebot.control.commanded_part import commanded_part, no_part_result
from homebot.control.held_values import changes, related
from homebot.control.journal import CommandJournal
from homebot.control.journal.given_codes import MAY_BE_CODE, without_codes
from homebot.control.judge import Judge
from homebot.control.known_state import KnownState, known_state
from homebot.control.learnt_persistence import LearntPersistence
from homebot.control.leases import Leases
from homebot.control.rehearsal import Rehearsal, rehearsed_result
from homebot.control.reports import GatewayFeed
from homebot.control.sending import OpenCommand, Sending, Signal
from homebot.control.settings import ControlSettings
from homebot.control.timeline.facts import Commanded, Decided, Order, Reported
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.progress import CommandProgress
from homebot.control.timeline.roles import ReportRole
from homebot.control.timelines import Timelines
from homebot.control.undoings import Undoings
from homebot.control.value_text import value_text
from homebot.control.witnesses import Witnesses
from homebot.devices import FIND_DEVICES, Device, DevicePart, FindDevices
from homebot.devices.command_messages import CommandRequest, CommandResult, Setting
from homebot.devices.command_results import result_of
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, Gone, NoAnswer, Outcome, Refused
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.support.time_limits import TimeLimits

__all__ = ["CommandExecutor"]

WOULD_SEND = "control.would_send"

MOST_PENDING: Final = 10_000
"""Commands whose outcome is awaited at once; further ones are refused."""

_MOST_NOTED: Final = 20
"""Reports of one capability that the journal notes for one command."""

_ON_THE_WAY: Final = frozenset({ReportRole.STEP, ReportRole.ASTRAY})


@final
class CommandExecutor:
    """Carries commands out, any number at once.

    Args:
        node: The node that it is on the graph.
        settings: How long it waits.
        judge: Asks the policies.
        journal: Notes what becomes of each.
        leases: The values that are held.
        timelines: What is known of each part.
        feed: The messages of the gateways.
        learnt: Reads and saves what commands teach.
        rehearsal: Answers commands in place of the devices; None if they are sent.

    Attributes:
        leases: The same.
        rehearsal: The same.
        timelines: The same.
        witnesses: Sensors that observe the effects of commands.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        judge: Judge,
        journal: CommandJournal,
        leases: Leases,
        timelines: Timelines,
        feed: GatewayFeed,
        learnt: LearntPersistence,
        rehearsal: Rehearsal | None = None,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._judge = judge
        self._journal = journal
        self.leases = leases
        self.rehearsal = rehearsal
        self.timelines = timelines
        self._feed = feed
        self._learnt = learnt
        self._sending = Sending(node, settings, judge, journal, leases, feed)
        self._limits = TimeLimits()
        self._open: dict[str, OpenCommand] = {}
        timelines.on_report, timelines.on_end = self._on_report, self._on_end
        timelines.on_undone = Undoings(node, journal, is_watched=settings.settle > 0).publish
        feed.on_answer = self._on_answer
        self.witnesses = Witnesses(node, settings, feed)
        for name, read in self.witnesses.counters.items():
            journal.add_counter(name, read)

    async def run(self) -> None:
        """Read what was learnt."""
        await self._learnt.load()

    async def perform(self, request: CommandRequest) -> CommandResult:
        """Carry a command out, and return its result."""
        asked_at, device, unanswered = self._clock.now(), None, ""
        try:
            device = await self.find_device(request.device)
        except ServiceError as exc:
            unanswered = str(exc)
        part = None if device is None else commanded_part(device, request.part, request.settings)
        place = (request.device, request.part if part is None else part.id)
        name = self._journal.requested(request.issuer, place, _shown(request, device, part), request.trigger, asked_at)
        if unanswered:
            result = result_of(NoAnswer(0.0, unanswered, command_id=name))
        elif device is None or part is None:
            result = no_part_result(request.device, request.part, device, name)
        else:
            result = await self._carry_out(self._issued(name, request, device, part))
        self._journal.decided(name, request.issuer, place, result)
        return result

    async def find_device(self, device_id: str) -> Device | None:
        """Return a device by its id; None if there is none.

        Raises:
            ServiceError: The directory does not answer.
        """
        found = (await self._find.call(_request_for(device_id))).devices
        return found[0] if found else None

    def refusal(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of *command* by a lease or a policy; None if it may be sent now."""
        is_leased = command.place in self.leases.parts  # as hardly ever
        held = self.leases.refuse(command, self._clock.monotonic()) if is_leased else None
        return held or self._judge.refusal(command)

    def preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        """Return the refusal that *request* would get now for want of a right or by a policy; nothing is noted."""
        command = self._issued("", request, device, part)
        if command.is_client and (problem := self._judge.client_refusal(command)):
            return Refused(POLICY, problem)
        return self._judge.refusal(command, is_noted=False)

    def note_text(self, command: IssuedCommand) -> None:
        """Record that *command* is sent as a text: no outcome is awaited, and older commands for the same are over."""
        now = self._clock.monotonic()
        if command.place in self.leases.parts:
            self.leases.note_stop(command.place, command.settings, now)
        self._judge.note_sent(command)
        self.timelines.of(command.device, command.part).command(Commanded(now, order_of(command), is_raw=True))

    def rehearsed(self, command: IssuedCommand) -> Outcome | None:
        """Return the outcome that a rehearsal assumes of *command*, and note it; None if it is to be sent."""
        outcome = None if self.rehearsal is None else self.rehearsal.outcome(command)
        if outcome is not None:
            self.leases.note_stop(command.place, command.settings, self._clock.monotonic())
            self._judge.note_sent(command)
            self._journal.note("would", command)
            self._node.log.info(
                WOULD_SEND,
                message=f"{command.issuer.removeprefix('/')} would set {command.label}: {_settings_text(command)}",
                device=command.device.id,
                command=command.id,
            )
        return outcome

    def _issued(self, name: str, request: CommandRequest, device: Device, part: DevicePart) -> IssuedCommand:
        return IssuedCommand(
            name,
            device,
            part,
            zero_as_off({one.capability: one.value.plain() for one in request.settings}, part.part),
            request.issuer,
            self._judge.rights(request.issuer),
            cause=request.cause,
            trigger=request.trigger,
            issued_at=self._clock.now(),
            transition=request.transition,
            code=request.code,
            scope=request.scope,
        )

    async def _carry_out(self, command: IssuedCommand) -> CommandResult:
        """Carry a command out: rights, leases, policies, sending, evidence."""
        if (refused := self._refused(command)) is not None:
            return result_of(refused)
        if self._learnt.is_awaited:
            await self._learnt.load()
        timeline = self.timelines.of(command.device, command.part)
        is_at_rest = not any(_is_about_same(one, command) for one in timeline.open_commands())
        order = order_of(command)
        known = self._known(command, order, timeline)
        opened = self._begin(command, order, timeline, known)
        try:
            if known.is_recent and is_at_rest and _is_so(opened):
                return self._decided(opened, AlreadySo(command_id=command.id))
            if self.rehearsal is not None and (assumed := self.rehearsed(command)) is not None:
                return await self._rehearse(opened, assumed)
            outcome = await self._send_and_verify(opened)
            if _is_lost(outcome) and await self._is_gone(command):
                outcome = Gone(command_id=command.id)
            return self._decided(opened, outcome)
        finally:
            del self._open[command.id]

    def _refused(self, command: IssuedCommand) -> Refused | None:
        if command.is_client and (problem := self._judge.client_refusal(command)):
            return Refused(POLICY, problem, command_id=command.id)
        if len(self._open) >= MOST_PENDING:
            return Refused("control", f"{MOST_PENDING:,} commands wait for their outcome", command_id=command.id)
        return self.refusal(command)

    def _known(self, command: IssuedCommand, order: Order, timeline: PartTimeline) -> KnownState:
        """Return the certain values of the part: none while an older command or a witness contradicts them."""
        is_doubted = any(_wants_otherwise(one, command) for one in timeline.open_commands())
        if is_doubted or command.place in self.witnesses.contradicted:
            return KnownState({}, is_recent=False)
        lost_at = self._feed.last_loss(command.part.routes).wall
        asked = {*order.settings, *order.wanted}
        return known_state(command, asked, timeline.unsure_since, lost_at)

    def _begin(self, command: IssuedCommand, order: Order, timeline: PartTimeline, known: KnownState) -> OpenCommand:
        fact = Commanded(self._clock.monotonic(), order, known.values, command.last_reported)
        progress = timeline.command(fact)
        progress.must_answer = self._feed.is_answering(command.part.routes)
        opened = self._open[command.id] = OpenCommand(command, timeline, progress, Signal(self._limits))
        return opened

    async def _rehearse(self, opened: OpenCommand, assumed: Outcome) -> CommandResult:
        await asyncio.sleep(durations.REHEARSED)
        command = opened.command
        wanted = tuple(Setting.of(name, value) for name, value in opened.progress.wanted.items())
        self._decided(opened, AlreadySo(command_id=command.id))
        return rehearsed_result(assumed, without_codes(wanted, command.device, command.part))

    async def _send_and_verify(self, opened: OpenCommand) -> Outcome:
        """Send a command and return its outcome, by what the device reports and by what sensors observe."""
        witnesses = await self.witnesses.begin(opened)
        try:
            outcome = await self._sending.run(opened)
            return await self.witnesses.verify(opened, witnesses, outcome) if witnesses else outcome
        finally:
            self.witnesses.end(witnesses)

    def _decided(self, opened: OpenCommand, outcome: Outcome) -> CommandResult:
        """Record the outcome of a command, learn from it, and return its result."""
        command, timeline, progress = opened.command, opened.timeline, opened.progress
        if isinstance(outcome, Confirmed):
            progress.is_witnessed = outcome.evidence is Evidence.WITNESSED
            for capability in command.settings if timeline.unsure_since else ():
                timeline.unsure_since.pop(capability, None)
        elif isinstance(outcome, NoAnswer | Contradicted):  # it may have changed, although no report says so
            now = self._clock.now()
            timeline.unsure_since.update((other, now) for one in command.settings for other in related(one))
        timeline.decide(progress, Decided(self._clock.monotonic(), command.id, outcome))
        self.timelines.schedule(command.place, command.id)
        seen = progress.seen
        return result_of(outcome, tuple([Setting.of(one, seen[one]) for one in progress.fitting]))

    async def _is_gone(self, command: IssuedCommand) -> bool:
        """Return whether the device or its part was removed while its answer was awaited."""
        try:
            device = await self.find_device(command.device.id)
        except ServiceError:
            return False
        return device is None or device.part(command.part.id) is None

    def _on_report(self, progress: CommandProgress, fact: Reported) -> None:
        """Note a report for an open command, and wake the task that waits for it."""
        opened = self._open.get(progress.order.id)
        if opened is None or not progress.is_open:
            return
        capability, role = fact.capability, progress.roles[fact.number]
        if capability in progress.wanted:
            news = (ReportRole.STEP, None) if role in _ON_THE_WAY else (role is ReportRole.ECHO, fact.value)
            if opened.noted.get(capability) != news and len(opened.noted) < _MOST_NOTED:
                opened.noted[capability] = news
                self._journal.reported(opened.command, capability, fact.value)
        opened.changed.set()

    def _on_end(self, progress: CommandProgress) -> None:
        opened = self._open.get(progress.order.id)
        if opened is not None:
            opened.changed.set()

    def _on_answer(self, command: str, capability: str, problem: str) -> None:
        opened = self._open.get(command)
        if opened is not None:
            opened.timeline.accept(command, capability, problem, self._clock.monotonic())


def _is_so(opened: OpenCommand) -> bool:
    """Return whether the part is known to be as commanded, so that nothing is sent."""
    progress = opened.progress
    return progress.was_so and not progress.has_echo and not opened.command.is_always_sent


def _is_about_same(older: CommandProgress, command: IssuedCommand) -> bool:
    return not older.order.settings.keys().isdisjoint(command.settings)


def _wants_otherwise(older: CommandProgress, command: IssuedCommand) -> bool:
    """Return whether an older command would change what *command* sets."""
    settings = older.order.settings
    return any(one in settings and changes(one, settings[one], one, value) for one, value in command.settings.items())


def _is_lost(outcome: Outcome) -> bool:
    return isinstance(outcome, NoAnswer) or (isinstance(outcome, Refused) and outcome.policy == "gateway")


def _shown(request: CommandRequest, device: Device | None, part: DevicePart | None) -> tuple[Setting, ...]:
    """Return the settings as the journal may have them: without codes."""
    if not any(one.capability in MAY_BE_CODE for one in request.settings):
        return request.settings
    return () if device is None or part is None else without_codes(request.settings, device, part)


@lru_cache(maxsize=1024)
def _request_for(device_id: str) -> FindDevicesRequest:
    return FindDevicesRequest(ids=(device_id,), service_type="", query=())


def _settings_text(command: IssuedCommand) -> str:
    wanted = tuple(Setting.of(name, value) for name, value in command.settings.items())
    shown = without_codes(wanted, command.device, command.part)
    return ", ".join(f"{one.capability} {value_text(one.value.plain())}" for one in shown)
