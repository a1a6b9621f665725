"""One run of a routine: its steps, one after the other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, Protocol, final

import anyio

from homebot.command_words.settings import SET
from homebot.devices import Devices, KeyValue
from homebot.devices.command_messages import CommandDevicesRequest, CommandDevicesResponse
from homebot.devices.current_trigger import current_trigger
from homebot.devices.device import State, target_of
from homebot.devices.value import PlainValue
from homebot.errors import HomebotError, ServiceError
from homebot.graph import Client, Node
from homebot.routines.conditions import Condition
from homebot.routines.program import Branch, Line, Skip
from homebot.routines.steps import Do, Notify, SendRobot, Undo, Wait, WaitUntil
from homebot.routines.watches import begun

__all__ = ["RoutineOwner", "RoutineRun"]

_LONGEST: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""

_SETTLES: Final = 10.0
"""Seconds after a command in which further changes are still its own, such as the last steps of a dimmer."""

_RESTORED: Final = (
    *("on_off", "level", "color", "color_temperature", "fan_speed", "volume"),
    *("position", "tilt", "movement", "heating_setpoint", "cooling_setpoint"),
)
"""What ``undo`` brings back, in this order. It opens nothing that was locked, and arms nothing."""


class RoutineOwner(Protocol):
    """The routine of a run."""

    node: Node
    devices: Devices
    commands: Client[CommandDevicesRequest, CommandDevicesResponse]

    def keep(self, place: int, until: float, before: dict[str, list[Any]]) -> None:
        """Store how far the run is, for a restart."""

    async def notify(self, message: str, *, title: str = "") -> bool:
        """Send people a message."""

    async def unmet(self, conditions: Sequence[tuple[str, Condition]]) -> str:
        """Return the first condition that does not hold; empty if all do."""

    def log_done(self, step: str) -> None:
        """Log that a step that no device's journal knows was done."""

    def log_failure(self, step: str, problem: str) -> None:
        """Log that a step failed."""


@final
class RoutineRun:
    """A run.

    Args:
        program: All steps of the routine.
        before: By part and capability, the value before the earlier steps, and when the command was given and ended, in
            seconds since the Unix epoch; it is updated.
    """

    def __init__(
        self, owner: RoutineOwner, program: tuple[Line, ...], before: dict[str, list[Any]] | None = None
    ) -> None:
        self._owner = owner
        self._program = program
        self._clock = owner.node.graph.clock
        self._before = {} if before is None else before
        self._is_undone = any(isinstance(one.step, Undo) for one in program)

    async def perform(self, first: int = 0, until: float = 0.0) -> None:
        """Perform the program from line *first* on; its wait ends at *until*, in seconds since the Unix epoch."""
        place = first
        while place < len(self._program):
            step = self._program[place].step
            match step:
                case Do():
                    await self._do(step)
                case SendRobot():
                    await self._drive(step)
                case Notify():
                    await self._owner.notify(step.text)
                case Wait():
                    await self._sleep(place, step.seconds, until)
                case WaitUntil():
                    await self._wait_until(place, step, until)
                case Undo():
                    await self._undo()
                case Branch():
                    place += step.over if await self._owner.unmet(step.conditions) else 0
                case Skip():
                    place += step.over
            place, until = place + 1, 0.0

    async def _do(self, step: Do) -> None:
        values = await self._states() if self._is_undone else {}
        given_at = self._clock.now()
        answer = await self._give(step.text, step.target, step.command, step.values)
        for one in answer.results:
            for capability in _RESTORED:
                if (state := values.get((one.device, one.part, capability))) is not None:
                    key = f"{target_of(one.device, one.part)} {capability}"
                    earlier = self._before.pop(key, None)  # of the run that this one takes the place of
                    was, since = earlier[:2] if earlier and _is_own(state, earlier) else (state.value.plain(), given_at)
                    self._before[key] = [was, since, self._clock.now()]

    async def _give(
        self, text: str, target: str, command: str, values: tuple[tuple[str, str], ...]
    ) -> CommandDevicesResponse:
        request = CommandDevicesRequest(
            target=target,
            command=command,
            values=tuple(KeyValue(key=name, value=value) for name, value in values),
            issuer=self._owner.node.full_name,
            trigger=current_trigger(),
        )
        try:
            answer = await self._owner.commands.call(request, timeout=_LONGEST)
        except ServiceError as exc:
            answer = CommandDevicesResponse(success=False, message=str(exc))
        if not answer.success:
            self._owner.log_failure(text, answer.message)
        return answer

    async def _drive(self, step: SendRobot) -> None:
        from homebot.routines.robot_drive import drive  # noqa: PLC0415 - few homes have a robot

        try:
            await drive(self._owner.node, step)
        except HomebotError as exc:
            self._owner.log_failure(step.text, str(exc))
        else:
            self._owner.log_done(step.text)

    async def _sleep(self, place: int, seconds: float, until: float) -> None:
        until = until or self._clock.now() + seconds
        self._owner.keep(place, until, self._before)
        await anyio.sleep(max(0.0, until - self._clock.now()))

    async def _wait_until(self, place: int, step: WaitUntil, until: float) -> None:
        until = until or self._clock.now() + step.most
        self._owner.keep(place, until, self._before)
        with anyio.move_on_after(max(0.0, until - self._clock.now())):
            await anext(begun(self._owner.node, step.state))

    async def _undo(self) -> None:
        """Bring back the values from before, of each part at once, where nothing else has changed them since."""
        states = await self._states()
        parts: dict[str, dict[str, PlainValue]] = {}
        for key, entry in self._before.items():
            target, _, capability = key.rpartition(" ")
            device, _, part = target.partition("#")
            now = states.get((device, part, capability))
            if now is not None and now.value.plain() != entry[0] and _is_own(now, entry):
                parts.setdefault(target, {})[capability] = entry[0]
        self._before.clear()
        async with anyio.create_task_group() as tasks:
            for target, values in parts.items():
                command = "off" if values.get("on_off") is False else SET
                given = () if command == "off" else tuple(_texts(values))
                tasks.start_soon(self._give, f"undo of {target}", target, command, given)

    async def _states(self) -> Mapping[tuple[str, str, str], State]:
        """Return the known values of the house."""
        devices = await self._owner.devices.find()
        return {(device.id, one.part, one.capability): one for device in devices for one in device.states}


def _is_own(state: State, entry: list[Any]) -> bool:
    """Return whether the command of *entry* brought about the value of *state*."""
    _, given_at, ended_at = entry
    return bool(given_at <= state.since.to_seconds() <= ended_at + _SETTLES)


def _texts(values: Mapping[str, PlainValue]) -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        text = " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
        yield name, {True: "on", False: "off"}[value] if isinstance(value, bool) else text
