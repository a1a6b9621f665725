"""Execution of commands: each is judged and sent, and what became of it is found out."""

from __future__ import annotations

import asyncio
import math
from collections import OrderedDict
from collections.abc import Iterable
from functools import partial
from typing import Final, TypeAlias, final

import anyio

from homebot.control.answer_watch import AnswerWatch
from homebot.control.client_commands import POLICY, client_refusal
from homebot.control.command import IssuedCommand
from homebot.control.echoes import NO_ECHOES, EchoHistory, ExpectedEchoes
from homebot.control.held_values import related
from homebot.control.journal import CommandJournal
from homebot.control.judge import Judge
from homebot.control.learnt_persistence import LearntPersistence
from homebot.control.leases import LEASE_POLICY, Leases
from homebot.control.pending import PendingCommand, PendingCommands, Signal
from homebot.control.rehearsal import Rehearsal, rehearsed_result
from homebot.control.report_watch import ReportWatch
from homebot.control.response_times import ResponseTimes
from homebot.control.settings import ControlSettings
from homebot.control.settling import Settling
from homebot.control.value_text import value_text
from homebot.control.witnesses import WitnessVerification
from homebot.devices import FIND_DEVICES, Device, DevicePart, FindDevices
from homebot.devices.command_messages import CommandRequest, CommandResult
from homebot.devices.command_results import result_of
from homebot.devices.command_sender import CommandSender
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, Gone, NoAnswer, Outcome, Refused
from homebot.devices.services import FindDevicesRequest
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, ServiceError
from homebot.graph import Node

__all__ = ["CommandExecutor"]

WOULD_SEND = "control.would_send"

MOST_PENDING: Final = 10_000
"""Commands whose outcome is awaited at once; further ones are refused."""

_RECENT: Final = 60.0
"""Seconds for which a live report counts as how it is now, so that a command for the same is not sent."""

_REHEARSED: Final = 0.1
"""Seconds that a device is taken to need in a rehearsal: what is asked again at once is not asked without end."""

_AT_ONCE: Final = 0.01
"""Seconds within which a gateway has sent a command whose network is there."""

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
        self._rehearsal = rehearsal
        self._sender = CommandSender(node)
        self._watch = ReportWatch(node)
        self._answers = AnswerWatch(node)
        self._times = ResponseTimes(self._settings.timeout)
        self._learnt = LearntPersistence(node, journal.store)
        self._echoes = EchoHistory(self._learnt.keeper("echo"))
        self._learnt.add("echo", self._echoes)
        self._unsure_since: OrderedDict[_Place, float] = OrderedDict()
        self._pending = PendingCommands()
        self._settling = Settling(node, self._settings.settle, journal, self._echoes)
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
        name = self._journal.next_id()
        self._journal.requested(name, request)
        result = await self._perform(name, request)
        self._journal.decided(name, request, result)
        return result

    async def find_device(self, device_id: str) -> Device | None:
        """Return a device by its id; None where there is none.

        Raises:
            ServiceError: The directory does not answer.
        """
        found = (
            await self._find.call(FindDevicesRequest.of_checked(ids=(device_id,), service_type="", query=()))
        ).devices
        return found[0] if found else None

    def refusal(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of *command* by a lease or a policy; None if it may be sent now."""
        return self._held(command) or self._judge.refusal(command)

    def preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        """Return the refusal that *request* would get now for want of a right or by a policy; nothing is noted."""
        if problem := client_refusal(request, device, part):
            return Refused(POLICY, problem)
        settings = {one.capability: one.value.plain() for one in request.settings}
        rights = self._judge.rights(request.issuer)
        command = IssuedCommand("", device, part, settings, request.issuer, rights, trigger=request.trigger)
        return self._judge.refusal(command, is_noted=False)

    def note_text(self, command: IssuedCommand) -> None:
        """Note that *command* is sent as a text: nobody waits for its outcome, and older ones for the same are over."""
        self.leases.note_stop(command.place, command.settings, self._clock.monotonic())
        self._judge.note_sent(command)
        if self.witnesses.doubted:
            self.witnesses.note_text(command)
        self._pending.supersede(command)
        self._settling.supersede(command.places)

    async def _perform(self, name: str, request: CommandRequest) -> CommandResult:
        try:
            device = await self.find_device(request.device)
        except ServiceError as exc:
            return result_of(NoAnswer(0.0, str(exc), command_id=name))
        part = None if device is None else next((one for one in device.parts if one.id == request.part), None)
        if device is None or part is None:
            return result_of(Gone(command_id=name))
        if problem := client_refusal(request, device, part):
            return result_of(Refused(POLICY, problem, command_id=name))
        command = IssuedCommand(
            id=name,
            device=device,
            part=part,
            settings={one.capability: one.value.plain() for one in request.settings},
            issuer=request.issuer,
            rights=self._judge.rights(request.issuer),
            cause=request.cause,
            trigger=request.trigger,
            issued_at=self._clock.now(),
            transition=request.transition,
            code=request.code,
        )
        return await self._carry_out(command)

    async def _carry_out(self, command: IssuedCommand) -> CommandResult:
        if len(self._pending) >= MOST_PENDING:
            problem = f"{MOST_PENDING:,} commands wait for their outcome"
            return result_of(Refused("control", problem, command_id=command.id))
        refused = self.refusal(command)
        if refused is not None:
            return result_of(refused)
        if self._learnt.is_awaited:
            await self._learnt.load()
        echoes = self._expected_echoes(command)
        places, is_settling = command.places, False
        is_at_rest = not self._pending.has_any(places)  # else the device may be about to change
        expected = command.expected
        known, recent = self._known(command, expected, echoes)
        changed = Signal()
        pending = PendingCommand(command, known, expected, self._clock.monotonic(), changed.set, echoes)
        watch = self._watch.watch(command.part.routes, partial(self._take, pending))
        self._answers.expect(pending)
        self._pending.put(pending)
        self._settling.supersede(places)
        try:
            if recent and is_at_rest and pending.was_so and not command.is_momentary:
                return result_of(AlreadySo(command_id=command.id))
            if (assumed := self.rehearsed(command)) is not None:
                await asyncio.sleep(_REHEARSED)
                return rehearsed_result(assumed, pending.wanted)
            outcome = await self._send_and_verify(pending, changed)
            is_lost = isinstance(outcome, NoAnswer) or (isinstance(outcome, Refused) and outcome.policy == "gateway")
            if is_lost and await self._is_gone(command):
                return result_of(Gone(command_id=command.id))
            if echoes is not NO_ECHOES:
                self._note_echoes(pending, outcome)
            if isinstance(outcome, NoAnswer | Contradicted):
                self._note_unsure(command)
            if isinstance(outcome, Confirmed):
                self._note_confirmed(pending, outcome)
                is_settling = self._settling.add(pending, watch)
        finally:
            self._pending.remove(pending)
            if not is_settling:
                watch.stop()
            self._answers.forget(pending)
        return result_of(outcome, pending.reported)

    async def _is_gone(self, command: IssuedCommand) -> bool:
        """Return whether the device or its part was removed while its answer was awaited."""
        try:
            device = await self.find_device(command.device.id)
        except ServiceError:
            return False
        return device is None or all(one.id != command.part.id for one in device.parts)

    def rehearsed(self, command: IssuedCommand) -> Outcome | None:
        """Return the outcome that a rehearsal assumes of *command*, and note it; None where it is to be sent."""
        outcome = None if self._rehearsal is None else self._rehearsal.outcome(command)
        if outcome is not None:
            self.leases.note_stop(command.place, command.settings, self._clock.monotonic())
            self._judge.note_sent(command)
            self._journal.would(command)
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
            outcome = await self._send_and_wait(pending, changed)
            if watch is None and not self.witnesses.disproves(pending.command):
                return outcome
            return await self.witnesses.verify(watch, pending, outcome, changed.wait)
        finally:
            self.witnesses.end(pending.command)

    def _note_confirmed(self, pending: PendingCommand, outcome: Confirmed) -> None:
        if outcome.evidence is Evidence.WITNESSED:
            pending.is_witnessed = True
        for place in pending.command.places if self._unsure_since else ():
            self._unsure_since.pop(place, None)
        for capability, seconds in pending.response_times():
            self._times.note(pending.command.target, capability, seconds, sendings=pending.sendings)

    async def _send_and_wait(self, pending: PendingCommand, changed: Signal) -> Outcome:
        """Send the command, again where no answer comes, and wait until its outcome is known."""
        command, clock = pending.command, self._clock
        began = clock.monotonic()
        limit = self._limit(command)
        tries = 1 if command.is_momentary else 1 + self._settings.retries
        for number in range(tries):
            is_refused = number > 0 and self._judge.refusal(command) is not None  # by what changed meanwhile
            if not is_refused:
                self._journal.sent(command, number)
                pending.note_sent(clock.monotonic())
                problem = await self._send(command, began + limit - clock.monotonic())
                if problem is None or pending.is_reported:
                    self._journal.acknowledged(command)
                elif number == 0:
                    return problem
                if number == 0:
                    began = clock.monotonic()  # a gateway may have had to connect before it was sent
            until = began + limit * (number + 1) / tries
            while not pending.is_over and (left := pending.waits_until(until, began) - clock.monotonic()) > 0:
                await changed.wait(left)
            if pending.is_over or pending.moved_at is not None or pending.gives_up(clock.monotonic()):
                break
        return await self._outcome(pending, changed, began + self._settings.timeout + command.transition)

    async def _outcome(self, pending: PendingCommand, changed: Signal, until: float) -> Outcome:
        """Return the outcome; a device that usually answers sooner may be slow for once, and fails at *until* only."""
        while True:
            now = self._clock.monotonic()
            outcome = pending.outcome(now)
            if isinstance(outcome, Confirmed | AlreadySo) or pending.is_over or now >= until:
                return outcome
            await changed.wait(until - now)

    async def _send(self, command: IssuedCommand, seconds: float) -> Outcome | None:
        """Send the settings in their order, to be done in so many *seconds*; return the outcome where that fails."""
        began = self._clock.monotonic()
        self.leases.note_stop(command.place, command.settings, began)
        self._judge.note_sent(command)  # before it waits: what is judged meanwhile must know of it
        try:
            for capability, value in command.settings.items():
                if (refused := self._held(command)) is not None:
                    return refused  # since it was judged, or the setting before was sent
                await self._sender.send(
                    command.device,
                    command.part,
                    capability,
                    value,
                    command.transition,
                    command.code,
                    seconds,
                    command.id,
                )
        except LinkError as exc:
            return NoAnswer(self._clock.monotonic() - began, str(exc), command_id=command.id)
        except RefusedError as exc:
            return Refused("gateway", exc.reason, command_id=command.id)
        if self._clock.monotonic() - began > _AT_ONCE:
            self._judge.note_sent(command)  # it may not have reached the device before
        return None

    def _held(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of a command that would change what somebody holds."""
        if command.place not in self.leases.parts:  # as nearly always
            return None
        reason = self.leases.refusal(command.place, command.settings, self._clock.monotonic())
        return Refused(LEASE_POLICY, reason, command_id=command.id) if reason else None

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

    def _limit(self, command: IssuedCommand) -> float:
        """Return for how many seconds to wait for the answer."""
        return max([self._times.limit(command.target, one) for one in command.settings]) + command.transition

    def _expected_echoes(self, command: IssuedCommand) -> ExpectedEchoes:
        settings = command.settings
        declared = frozenset(
            [one.name for one in command.part.part.capabilities if one.echoed and one.name in settings]
        )
        if not declared and self._echoes.is_empty:
            return NO_ECHOES
        return self._echoes.expected(command.target, settings, declared, self._limit(command))

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
        """Return the values that the part reported live, and whether all that are wanted were reported lately.

        What was reported before a command failed, or before one for something else that still waits, is not known, and
        what may be an echo, or was reported since a command failed, not lately: the next one is sent in any case.
        """
        now, known, ages = self._clock.now(), {}, [0.0]
        asked = {*command.settings, *expected}
        is_doubted = self._pending.wants_otherwise(command) or self.witnesses.disproves(command)
        if is_doubted or command.device.freshness != "fresh":
            return {}, False
        for state in command.device.states:
            if state.part == command.part.id and state.live and state.capability in asked:
                told_at = state.told_at.to_seconds()
                unsure_since = self._unsure_since.get((*command.place, state.capability))
                ages.append(math.inf if unsure_since is not None else abs(now - told_at))
                if unsure_since is None or told_at > unsure_since:
                    known[state.capability] = state.value.plain()
        return known, max(ages) <= _RECENT and echoes is NO_ECHOES


def _settings_text(command: IssuedCommand) -> str:
    return ", ".join(f"{name} {value_text(value)}" for name, value in command.settings.items())
