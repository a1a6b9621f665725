"""Execution of commands: each is judged and sent, and what became of it is found out."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from functools import lru_cache, partial
from operator import attrgetter
from typing import Final, TypeAlias, final

import anyio

from homebot.control.client_commands import POLICY
from homebot.control.command import IssuedCommand, zero_as_off
from homebot.control.echoes import NO_ECHOES, EchoHistory, ExpectedEchoes
from homebot.control.gateway_watch import GatewayWatch, PartWatch, ReportWatch
from homebot.control.held_values import related
from homebot.control.journal import CommandJournal
from homebot.control.journal.given_codes import MAY_BE_CODE, without_codes
from homebot.control.judge import Judge
from homebot.control.late_answers import LateAnswers
from homebot.control.learnt_persistence import LearntPersistence
from homebot.control.leases import Leases
from homebot.control.meant_part import meant_part
from homebot.control.missing_part import missing_part
from homebot.control.pending import PendingCommand
from homebot.control.pending_commands import PendingCommands
from homebot.control.rehearsal import Rehearsal, rehearsed_result
from homebot.control.roundings import Roundings
from homebot.control.settings import ControlSettings
from homebot.control.settling import Settling
from homebot.control.transmission import Signal, Transmission
from homebot.control.value_text import value_text
from homebot.control.witnesses import WitnessVerification
from homebot.devices import FIND_DEVICES, Device, DevicePart, FindDevices
from homebot.devices.command_messages import CommandRequest, CommandResult, Setting
from homebot.devices.command_results import result_of
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, Gone, NoAnswer, Outcome, Refused
from homebot.devices.services import FindDevicesRequest
from homebot.devices.value import PlainValue
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.time_limits import TimeLimits

__all__ = ["CommandExecutor"]

_ECHOED = attrgetter("echoed")

WOULD_SEND = "control.would_send"

MOST_PENDING: Final = 10_000
"""Commands whose outcome is awaited at once; further ones are refused."""

_RECENT: Final = 60.0
"""Seconds for which a live report counts as how it is now, so that a command for the same is not sent."""

_REHEARSED: Final = 0.1
"""Seconds that a device is taken to need in a rehearsal: what is asked again at once is not asked without end."""

_MOST_UNSURE: Final = 10_000

_Place: TypeAlias = tuple[str, str, str]


@final
class CommandExecutor:
    """Carries commands out, any number at once.

    Args:
        node: The node that it is on the graph.
        settings: How long it waits.
        judge: Asks the policies.
        journal: Notes what becomes of each.
        leases: The values that somebody holds.
        rehearsal: Answers commands in place of the devices; None where they are sent.

    Attributes:
        leases: The same.
        rehearsal: The same.
        witnesses: Sensors that see what commands do.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings,
        judge: Judge,
        journal: CommandJournal,
        leases: Leases,
        rehearsal: Rehearsal | None = None,
    ) -> None:
        self._node = node
        self._settings = settings
        self._clock = node.graph.clock
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._judge = judge
        self._journal = journal
        self.leases = leases
        self.rehearsal = rehearsal
        self._watch = ReportWatch(node)
        self._gateways = GatewayWatch(node)
        self._transmission = Transmission(node, settings, judge, journal, leases, self._gateways)
        self._learnt = LearntPersistence(node, journal.store)
        self._echoes = EchoHistory(self._learnt.keeper("echo"))
        self._learnt.add("echo", self._echoes)
        self._roundings = Roundings()
        self._unsure_since: OrderedDict[_Place, float] = OrderedDict()
        self._pending = PendingCommands()
        self._limits = TimeLimits()
        self._late = LateAnswers(self._clock, self._limits, self._transmission.times)
        self._settling = Settling(node, self._settings.settle, journal, self._echoes, self._limits)
        self.witnesses = WitnessVerification(node, settings, self._learnt)
        for name, read in self.witnesses.counters.items():
            journal.add_counter(name, read)

    async def run(self) -> None:
        """Read what was learnt, and watch the devices of confirmed commands and what sensors see, until cancelled."""
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._learnt.load)
            tasks.start_soon(self.witnesses.run)
            await self._settling.run()

    async def perform(self, request: CommandRequest) -> CommandResult:
        """Carry a command out, and return what became of it."""
        asked_at, device, unanswered = self._clock.now(), None, ""
        try:
            device = await self.find_device(request.device)
        except ServiceError as exc:
            unanswered = str(exc)
        part = None if device is None else meant_part(device, request.part, request.settings)
        place, shown = (request.device, request.part if part is None else part.id), request.settings
        for one in request.settings:
            if one.capability in MAY_BE_CODE:
                shown = () if device is None or part is None else without_codes(request.settings, device, part)
                break
        name = self._journal.requested(request.issuer, place, shown, request.trigger, asked_at)
        if unanswered:
            result = result_of(NoAnswer(0.0, unanswered, command_id=name))
        elif device is None or part is None:
            result = missing_part(request.device, request.part, device, name)
        else:
            result = await self._carry_out(self._issued(name, request, device, part))
        self._journal.decided(name, request.issuer, place, result)
        return result

    async def find_device(self, device_id: str) -> Device | None:
        """Return a device by its id; None where there is none.

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
        """Note that *command* is sent as a text: nobody waits for its outcome, and older ones for the same are over."""
        if command.place in self.leases.parts:
            self.leases.note_stop(command.place, command.settings, self._clock.monotonic())
        self._judge.note_sent(command)
        if self.witnesses.doubted:
            self.witnesses.note_text(command)
        self._supersede(command)

    def _supersede(self, command: IssuedCommand) -> None:
        """End what goes on for older commands to what *command* sets; mostly nothing does."""
        if self._pending.newest:
            self._pending.supersede(command)
        if self._settling.watched:
            self._settling.supersede(command)
        if self._late.awaited:
            self._late.end(command.place)

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
        if command.is_client and (problem := self._judge.client_refusal(command)):
            return result_of(Refused(POLICY, problem, command_id=command.id))
        if len(self._pending.newest) >= MOST_PENDING:
            problem = f"{MOST_PENDING:,} commands wait for their outcome"
            return result_of(Refused("control", problem, command_id=command.id))
        refused = self.refusal(command)
        if refused is not None:
            return result_of(refused)
        if self._learnt.is_awaited:
            await self._learnt.load()
        echoes = self._expected_echoes(command)
        is_watched_on = False
        is_at_rest = not (self._pending.newest and self._pending.has_any(command.places))  # else it may be on its way
        expected: Mapping[str, PlainValue] = command.expected
        if self._roundings.known:
            expected = self._roundings.expected(command.target, expected)
        known, recent = self._known(command, expected, echoes)
        changed = Signal(self._limits)
        pending = PendingCommand(
            command, known, expected, self._clock.monotonic(), changed.set, echoes, self._judge.was_answered
        )
        watch = self._watch.watch(command.part.routes, partial(self._take, pending))
        self._gateways.expect(pending)
        self._supersede(command)
        self._pending.put(pending)
        try:
            if recent and is_at_rest and pending.was_so and not command.is_always_sent:
                return result_of(AlreadySo(command_id=command.id))
            if self.rehearsal is not None and (assumed := self.rehearsed(command)) is not None:
                await asyncio.sleep(_REHEARSED)
                return rehearsed_result(assumed, without_codes(pending.wanted, command.device, command.part))
            send = self._transmission.run if self.witnesses.are_none else self._send_and_verify
            outcome = await send(pending, changed)
            is_lost = isinstance(outcome, NoAnswer) or (isinstance(outcome, Refused) and outcome.policy == "gateway")
            if is_lost and await self._is_gone(command):
                return result_of(Gone(command_id=command.id))
            if echoes is not NO_ECHOES:
                self._note_echoes(pending, outcome)
            if isinstance(outcome, Confirmed):
                self._note_confirmed(pending, outcome)
                is_watched_on = self._settling.add(pending, watch)
            else:
                is_watched_on = self._note_failed(pending, outcome, watch)
        finally:
            self._pending.remove(pending)
            if not is_watched_on:
                watch.stop()
            self._gateways.forget(pending)
        return result_of(outcome, pending.reported)

    async def _is_gone(self, command: IssuedCommand) -> bool:
        """Return whether the device or its part was removed while its answer was awaited."""
        try:
            device = await self.find_device(command.device.id)
        except ServiceError:
            return False
        return device is None or device.part(command.part.id) is None

    def rehearsed(self, command: IssuedCommand) -> Outcome | None:
        """Return the outcome that a rehearsal assumes of *command*, and note it; None where it is to be sent."""
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

    async def _send_and_verify(self, pending: PendingCommand, changed: Signal) -> Outcome:
        """Send the command and wait for its outcome, by what the device reports and by what sensors see."""
        watch = self.witnesses.begin(pending.command, changed.set)
        try:
            outcome = await self._transmission.run(pending, changed)
            if watch is None and not self.witnesses.disproves(pending.command):
                return outcome
            return await self.witnesses.verify(watch, pending, outcome, changed.wait)
        finally:
            self.witnesses.end(pending.command)

    def _note_confirmed(self, pending: PendingCommand, outcome: Confirmed) -> None:
        if self._judge.watches_hands and outcome.evidence >= Evidence.REPORTED:
            self._judge.note_obeyed(pending.command)
        if outcome.evidence is Evidence.WITNESSED:
            pending.is_witnessed = True
        for place in pending.command.places if self._unsure_since else ():
            self._unsure_since.pop(place, None)
        pending.note_times(self._transmission.times)
        if self._roundings.known:
            self._note_answers(pending)

    def _note_failed(self, pending: PendingCommand, outcome: Outcome, watch: PartWatch) -> bool:
        """Note that the device did not do as it was told; return whether *watch* is taken for an answer to come."""
        if not isinstance(outcome, NoAnswer | Contradicted):
            return False
        self._note_unsure(pending.command)
        self._note_answers(pending)
        return self._late.add(pending, outcome, watch)

    def _note_answers(self, pending: PendingCommand) -> None:
        """Note which values the device took for those that it was told."""
        settings, target = pending.command.settings, pending.command.target
        for capability, seen in pending.answers():
            self._roundings.note(target, capability, settings.get(capability), seen)

    def _take(self, pending: PendingCommand, capability: str, value: PlainValue) -> None:
        if pending.take(capability, value, self._clock.monotonic()):
            self._journal.reported(pending.command, capability, value)

    def _note_unsure(self, command: IssuedCommand) -> None:
        """Note that what *command* sets may have changed, although nothing says so: older reports count no more."""
        now = self._clock.now()
        for place in [(*command.place, other) for one in command.settings for other in related(one)]:
            self._unsure_since[place] = now
            self._unsure_since.move_to_end(place)
        while len(self._unsure_since) > _MOST_UNSURE:
            self._unsure_since.popitem(last=False)

    def _expected_echoes(self, command: IssuedCommand) -> ExpectedEchoes:
        settings, capabilities = command.settings, command.part.part.capabilities
        if not self._echoes.known and not any(map(_ECHOED, capabilities)):  # as of most
            return NO_ECHOES
        declared = [one.name for one in capabilities if one.echoed and one.name in settings]
        if not declared and not self._echoes.known:
            return NO_ECHOES
        limit, _ = self._transmission.times.expected(command.target, settings)
        return self._echoes.expected(command.target, settings, frozenset(declared), limit + command.transition)

    def _note_echoes(self, pending: PendingCommand, outcome: Outcome) -> None:
        target = pending.command.target
        if not isinstance(outcome, Confirmed | Contradicted):
            return
        name = pending.command.id
        for capability, answered in pending.echo_answers():
            self._echoes.note_echo(target, capability, name, answered=answered)
        for capability, seconds in pending.taken_back:
            self._echoes.note_fast(target, capability, name, seconds, is_repeated=capability in pending.repeated)

    def _known(
        self, command: IssuedCommand, expected: Iterable[str], echoes: ExpectedEchoes
    ) -> tuple[dict[str, PlainValue], bool]:
        """Return the values that the part reported, and whether all that are wanted were reported live and lately.

        What a broker has kept is known of a device that is online, by its last will: many report only changes. What was
        reported before a command failed, or before one for something else that still waits, is not known, and what
        may be an echo, or was reported since a command failed, not lately: the next one is sent in any case.
        """
        now, known, is_recent = command.issued_at, {}, echoes is NO_ECHOES
        asked = {*command.settings, *expected}
        is_doubted = bool(self._pending.newest) and self._pending.wants_otherwise(command)
        is_doubted = is_doubted or (bool(self.witnesses.doubted) and self.witnesses.disproves(command))
        is_online = command.device.reachable.state == "yes"
        if is_doubted or not (is_online or command.device.freshness == "fresh"):
            return {}, False
        device, part = command.place
        for state in command.device.states:
            capability = state.capability
            if capability in asked and state.part == part and (state.live or is_online):
                told_at = state.told_at.to_seconds()
                unsure_since = self._unsure_since.get((device, part, capability))
                is_sure = state.live and unsure_since is None
                is_recent = is_recent and is_sure and abs(now - told_at) <= _RECENT
                if unsure_since is None or told_at > unsure_since:
                    known[capability] = state.value.plain()
        return known, is_recent


@lru_cache(maxsize=1024)
def _request_for(device_id: str) -> FindDevicesRequest:
    return FindDevicesRequest.of_checked(ids=(device_id,), service_type="", query=())


def _settings_text(command: IssuedCommand) -> str:
    wanted = tuple(Setting.of(name, value) for name, value in command.settings.items())
    shown = without_codes(wanted, command.device, command.part)
    return ", ".join(f"{one.capability} {value_text(one.value.plain())}" for one in shown)
