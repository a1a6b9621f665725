"""One run of a routine: its steps, one after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from contextvars import ContextVar
from datetime import datetime
from functools import cached_property, partial
from random import Random
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, final

import anyio

from homebot.apps import AppContext
from homebot.command_words.undo_record import UndoRecord, known_states
from homebot.devices import Devices, KeyValue
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest, ChangeRoutineResponse
from homebot.devices.batch import perform_all
from homebot.devices.command_messages import (
    CommandDevicesRequest,
    CommandDevicesResponse,
    CommandRequest,
    PerformCommand,
)
from homebot.devices.current_trigger import current_trigger
from homebot.devices.device import Device, DeviceChange, StateChange, target_of
from homebot.devices.names import CHANGE_ROUTINE, PERFORM_COMMAND
from homebot.devices.outcomes import NoAnswer, Outcome
from homebot.devices.wording.values import value_text
from homebot.errors import HomebotError, ServiceError, UsageError
from homebot.features.routines.program import Back, Branch, ForEach, Line, NextTurn, Skip, conditions_of
from homebot.features.routines.watches import fitting, follow_matches, holds_for, value_of
from homebot.graph import Client, Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.support.folding import fold
from homebot.words.commands import SET
from homebot.words.conditions import Condition
from homebot.words.message_values import MessageValue
from homebot.words.steps import (
    EXAMPLES,
    Dim,
    Do,
    Notify,
    SendRobot,
    Step,
    Stop,
    SwitchRoutine,
    Undo,
    Wait,
    WaitFor,
    WaitUntil,
    in_turn,
    read_step,
)
from homebot.words.tokens import quoted
from homebot.words.triggers import Becomes, Trigger

if TYPE_CHECKING:
    from homebot.features.routines.checks import HouseChecks

_MAX_WAIT_S: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""


_CHAIN: Final[ContextVar[frozenset[str]]] = ContextVar("homebot.routine_chain", default=frozenset())
"""The routines of which each ran the next one, the last of which is this one."""


class RoutineOwner(Protocol):
    """The routine of a run."""

    title: str
    node: Node
    context: AppContext
    devices: Devices
    commands: Client[CommandDevicesRequest, CommandDevicesResponse]

    async def keep(self, run: RoutineRun, place: RunPlace, before: dict[str, list[Any]]) -> None:
        """Store how far *run* is, for a restart."""

    def now(self) -> datetime:
        """Return the date and time in the home's zone."""

    async def notify(self, message: str, *, title: str = "") -> bool:
        """Send people a message."""

    async def unmet(self, conditions: Sequence[tuple[str, Condition]], facts: RoutineRunFacts) -> str:
        """Return the first condition that does not hold in the run; empty if all do."""

    async def wait_for(self, triggers: Sequence[Trigger]) -> int:
        """Wait for the next of *triggers*, and return its place."""

    def sun_angle(self, is_azimuth: bool) -> float:  # noqa: FBT001 - values of the sun call it
        """Return the azimuth of the sun now, else its elevation, in degrees."""

    async def fitting(self, devices: str) -> tuple[str, ...]:
        """Return the ids of the devices that the query *devices* finds now."""

    def log_done(self, step: str) -> None:
        """Log that a step that no device's journal knows was done."""

    def log_failure(self, step: str, problem: str) -> None:
        """Log that a step failed."""


class RoutineRunFacts(NamedTuple):
    """Facts about a run for its conditions.

    Attributes:
        started_by: The text of its trigger; empty for a start by hand.
        value_before: The value before the change that started it, in words.
        has_timed_out: Whether its last wait was too long.
        ended_by: The text of the trigger that ended it; empty for none.
        turns: In a loop over devices, the ids of that in turn and those that follow.
    """

    started_by: str = ""
    value_before: str = "unknown"
    has_timed_out: bool = False
    ended_by: str = ""
    turns: tuple[str, ...] = ()


class RunPlace(NamedTuple):
    """The step that a run takes.

    Attributes:
        line: The line of the program.
        until: The end of a wait, in seconds since the Unix epoch; else 0.
        may_repeat: Whether to take the step again after a restart is known to change nothing more.
    """

    line: int
    until: float
    may_repeat: bool


@final
class RoutineRun:
    """A run.

    Args:
        program: All steps of the routine; without it, an app calls :meth:`execute`.
        before: The values before the earlier steps, as :class:`UndoRecord` has them; it is updated.

    Attributes:
        facts: The facts for its conditions.
    """

    def __init__(
        self,
        owner: RoutineOwner,
        program: tuple[Line, ...] = (),
        before: dict[str, list[Any]] | None = None,
        facts: RoutineRunFacts = RoutineRunFacts(),  # noqa: B008 - it is frozen
    ) -> None:
        self.facts = facts
        self._owner = owner
        self._program = program
        self._clock = owner.node.graph.clock
        self._before = UndoRecord(before)
        self._is_undone = not program or any(isinstance(line.step, Undo) for line in program)

    async def perform(self, first: int = 0, until: float = 0.0) -> None:
        """Perform the program from line *first* on; its wait ends at *until*, in seconds since the Unix epoch."""
        place = first
        while place < len(self._program):
            text, step = self._program[place]
            match step:
                case Branch():
                    conditions = conditions_of((text for text, _ in step.conditions), self.turn)
                    place += step.over if await self._owner.unmet(conditions, self.facts) else 0
                case Skip():
                    place += step.over
                case Back():
                    place -= step.over + 1
                case ForEach():
                    self.facts = self.facts._replace(turns=await self._owner.fitting(step.devices))
                    place += 0 if self.facts.turns else step.over
                case NextTurn():
                    self.facts = self.facts._replace(turns=self.facts.turns[1:])
                    place -= step.over + 1 if self.facts.turns else 0
                case _:
                    step = read_step(in_turn(text, "step", self.turn)) if self.turn else step
                    if not await self.execute(step, place, until):
                        return
            place, until = place + 1, 0.0

    @property
    def turn(self) -> str:
        """The device in turn, as a query; empty outside of a loop over devices."""
        return f"id={quoted(self.facts.turns[0])}" if self.facts.turns else ""

    async def execute(self, step: Step, line: int = 0, until: float = 0.0) -> bool:
        """Execute one *step*, and return whether the run goes on.

        A wait ends at *until*, in seconds since the Unix epoch, if that is given.
        """
        step = await self._with_numbers(step)
        place = await self._place_of(step, line, until)
        await self._owner.keep(self, place, self._before.entries)
        match step:
            case Do():
                await self._do(step)
            case Dim():
                await self._dim(step)
            case SendRobot():
                await self._drive(step)
            case Notify():
                text = await self._message(step)
                is_sent = await self._owner.notify(text) or self._owner.context.rehearse is not None
                if not is_sent:
                    self._owner.log_failure(f"notify {text}", "nobody was told; [notify] and the log say why")
            case Wait():
                await anyio.sleep(self._left(max(step.seconds, step.most), place.until))
            case WaitFor() | WaitUntil():
                ended_by = ""
                with anyio.move_on_after(self._left(step.most, place.until)) as wait:
                    if isinstance(step, WaitFor):
                        ended_by = step.texts[await self._owner.wait_for(step.triggers)]
                    else:
                        await self._until(step.states)
                self.facts = self.facts._replace(has_timed_out=wait.cancelled_caught, ended_by=ended_by)
                return not (step.stops and wait.cancelled_caught)
            case Undo():
                await self._undo()
            case SwitchRoutine():
                await self._switch(step)
            case Stop():
                return False
        return True

    async def _until(self, states: Sequence[Becomes]) -> None:
        """Wait until all of *states* are at one time."""
        is_so = False
        while not is_so:
            for state in states:
                await anext(follow_matches(self._owner.node, state))
            devices, now = await self._owner.devices.find(), self._clock.now()
            is_so = len(states) == 1 or all(holds_for(state, devices, now, is_none=state.is_none) for state in states)

    async def _place_of(self, step: Step, line: int, until: float) -> RunPlace:
        """Return the place of *step*, with the end of a wait that begins now unless it ends at *until*."""
        match step:
            case Do() if self._program:
                return RunPlace(line, until, await self._checks.may_repeat(step))
            case Wait(seconds=length, most=most):
                share = Random(f"{self._owner.title} {self._clock.now()}").random()  # noqa: S311 - no secret
                length += share * max(0.0, most - length)
            case WaitFor(most=length) | WaitUntil(most=length):
                pass
            case _:
                is_run = isinstance(step, SwitchRoutine) and step.change == "run"
                return RunPlace(line, until, isinstance(step, Undo | Stop | SwitchRoutine) and not is_run)
        return RunPlace(line, until or self._clock.now() + length, may_repeat=True)

    @cached_property
    def _checks(self) -> HouseChecks:
        from homebot.features.routines.checks import HouseChecks  # noqa: PLC0415 - it reads routines

        return HouseChecks(self._owner.node, lambda *_: ("", ""))

    async def _do(self, step: Do) -> bool:
        node, devices = self._owner.node, self._owner.devices
        states = await known_states(node, await devices.find()) if self._is_undone else {}
        request = CommandDevicesRequest(
            target=step.target,
            command=step.command,
            values=tuple(KeyValue(key=name, value=value) for name, value in step.values),
            issuer=node.full_name,
            transition=step.transition,
            trigger=current_trigger(),
        )
        try:
            answer = await self._owner.commands.call(request, timeout=_MAX_WAIT_S)
        except ServiceError as exc:
            answer = CommandDevicesResponse(success=False, message=str(exc))
        if not answer.success:
            self._owner.log_failure(step.text, answer.message)
        self._before.add(states, answer.results)
        return answer.success

    async def _dim(self, step: Dim) -> None:
        from homebot.features.routines.dimming import dim  # noqa: PLC0415 - few routines dim

        async def set_level(level: float) -> bool:
            return await self._do(Do(step.text, step.target, SET, (("level", f"{level:.0f}"),)))

        await dim(self._owner.node, step, await self._owner.devices.find(), set_level)

    async def _drive(self, step: SendRobot) -> None:
        from homebot.robots.drive import drive  # noqa: PLC0415 - few homes have a robot

        if (rehearse := self._owner.context.rehearse) is not None:
            rehearse(self._owner.node.name, step.text)
            self._owner.log_done(f"{step.text} (only recorded)")
            return
        try:
            await drive(self._owner.node, step)
        except HomebotError as exc:
            self._owner.log_failure(step.text, str(exc))
        else:
            self._owner.log_done(step.text)

    async def _switch(self, step: SwitchRoutine) -> None:
        chain = _CHAIN.get() | {fold(self._owner.title)}
        if step.change == "run" and fold(step.name) in chain:
            self._owner.log_failure(step.text, "it would run again and again; start it by a trigger")
            return
        _CHAIN.set(chain)
        request = ChangeRoutineRequest(name=step.name, change=step.change)
        with closing(self._owner.node.create_client(ChangeRoutine, CHANGE_ROUTINE)) as client:
            try:
                answer = await client.call(request)
            except ServiceError as exc:
                answer = ChangeRoutineResponse(success=False, message=str(exc))
        if answer.success:
            self._owner.log_done(step.text)
        else:
            self._owner.log_failure(step.text, answer.message)

    async def _message(self, step: Notify) -> str:
        """Return the text of a message with the values of now."""
        if not step.pieces:
            return step.text
        devices, change = await self._owner.devices.find(), CURRENT_CAUSE.get()
        by = change.device if isinstance(change, StateChange | DeviceChange) else ""
        cause = next((device for device in devices if device.id == by), None) if isinstance(by, str) else by
        texts = [piece if isinstance(piece, str) else self._piece(piece, devices, cause) for piece in step.pieces]
        return "".join(texts)

    def _piece(self, value: MessageValue, devices: Sequence[Device], cause: Device | None) -> str:
        """Return a value of now in words; *cause* is the device that started the run."""
        match value.kind:
            case "name" | "room":
                device = next(iter(fitting(value.words, devices)), None) if value.words else cause
                if value.kind == "room":
                    return "unknown" if device is None else device.area or "unknown"
                return device.name or device.id if device else "nothing" if value.words else "a time"
            case "routine":
                return self._owner.title
            case "time":
                return f"{self._owner.now():%H:%M}"
            case "now":
                return f"{self._owner.now():%Y-%m-%d %H:%M:%S}"
            case "before":
                return self.facts.value_before
            case "names":
                return ", ".join(_names(value, devices)) or "none"
            case _:
                return value_text(value.capability, value_of(value, devices, self._owner.sun_angle))

    async def _with_numbers(self, step: Step) -> Step:
        """Return *step* with the numbers of now, or as no wait at all while one of them is unknown."""
        if not isinstance(step, Do | Wait) or not step.pieces:
            return step
        devices = await self._owner.devices.find()
        sun = self._owner.sun_angle
        values = [
            piece
            if isinstance(piece, str)
            else self._piece(piece, devices, None)
            if piece.kind in EXAMPLES
            else value_of(piece, devices, sun)
            for piece in step.pieces
        ]
        text = "".join(f"{value:.12g}" if isinstance(value, float) else str(value) for value in values)
        try:
            if None not in values:
                return read_step(text)
            problem = "one of its values is unknown"
        except UsageError as exc:
            problem = str(exc)
        self._owner.log_failure(text, problem)
        return Wait(0.0)

    def _left(self, seconds: float, until: float) -> float:
        """Return how long a wait of *seconds* still lasts; the clock may have been set back since it began."""
        return min(seconds, max(0.0, until - self._clock.now()))

    async def _undo(self) -> None:
        """Bring back the values from before, of each part at once, where they have not changed since."""
        devices = [device for device in await self._owner.devices.find() if device.id in self._before.devices]
        due = self._before.due(await known_states(self._owner.node, devices, from_journal=True))
        requests = [
            CommandRequest(
                device=device,
                part=part,
                settings=settings,
                issuer=self._owner.node.full_name,
                trigger=current_trigger(),
            )
            for (device, part), settings in due.items()
        ]
        with closing(self._owner.node.create_client(PerformCommand, PERFORM_COMMAND)) as client:
            outcomes = await perform_all(partial(_outcome, client), requests)
        for place, outcome in zip(due, outcomes, strict=True):
            if not outcome.succeeded:
                self._owner.log_failure(f"undo of {target_of(*place)}", outcome.text)


def _names(value: MessageValue, devices: Sequence[Device]) -> Iterator[str]:
    """Yield the names of the devices of *value*, with the value of each."""
    for device in fitting(value.words, devices):
        told = value_text(value.capability, value_of(value, [device])) if value.capability else ""
        yield f"{device.name or device.id} {told}".rstrip()


async def _outcome(client: Client[CommandRequest, Outcome], request: CommandRequest) -> Outcome:
    try:
        return await client.call(request, timeout=_MAX_WAIT_S)
    except ServiceError as exc:
        return NoAnswer(0.0, str(exc))
