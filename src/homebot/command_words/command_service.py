"""The service ``/devices/command``: commands in words, with an id, name or query."""

from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import closing
from typing import Final, Protocol, final

import anyio

from homebot.command_words.targets import CommandTargets, NoTargetError, Target
from homebot.devices import Device, DevicePart, KeyValue
from homebot.devices.batch import as_batch
from homebot.devices.command_messages import (
    MAX_TRANSITION_S,
    CommandDevicesRequest,
    CommandDevicesResponse,
    CommandedPart,
    CommandRequest,
    CommandResult,
    Setting,
)
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import APPLY_SCENE
from homebot.devices.outcomes import NoAnswer, Outcome, Refused
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, ServiceError, UsageError
from homebot.graph import Node
from homebot.units import parse_duration
from homebot.words.phrases import OVER, SCENE_TARGET
from homebot.words.suitable_parts import certain_values, part_name, settings_by_part
from homebot.words.tokens import MAX_QUERY

UNNAMED_CLIENT: Final = "client"
"""The issuer of a command that names none."""

_SCENE_WORDS: Final[Mapping[str, bool]] = {
    "apply": False,
    "activate": False,
    "on": False,
    "turn on": False,
    "undo": True,
}
"""Commands to scenes, and whether each is an undo."""

_MAX_WAIT_S: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""


class CommandPort(Protocol):
    """The port that carries out the command to each part."""

    def perform(self, request: CommandRequest) -> Awaitable[Outcome]:
        """Carry out a command to one part, and return its outcome."""

    def preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        """Return why the command would be refused now; None if it would not."""

    def why_asked(self, request: CommandRequest, device: Device, part: DevicePart) -> Awaitable[str]:
        """Return why a person must agree to the command; empty if none must, or it would be refused."""


@final
class CommandService:
    """Finds the target devices of a command in words, and commands all of them at once."""

    def __init__(self, node: Node, lookup: DeviceLookup, commands: CommandPort) -> None:
        self._node = node
        self._commands = commands
        self._lookup = lookup
        self._targets = CommandTargets(node, lookup, self._refusal)

    async def serve(
        self, request: CommandDevicesRequest, on_commanded: Callable[[CommandedPart, int], None] | None = None
    ) -> CommandDevicesResponse:
        """Carry out *request*; never raises.

        Args:
            on_commanded: Called with each outcome as soon as it is known, and the number of parts that still have none.
        """
        try:
            if (applied := await self._scene(request)) is not None:
                return applied
            words, comma, last = request.command.rpartition(",")
            if comma and len(last) < MAX_QUERY and (over := OVER.match(last)) is not None:
                transition = parse_duration(over["length"], "over", most=MAX_TRANSITION_S)
                request = request.model_copy(update={"command": words, "transition": transition})
            targets, request = await self._find_targets(request)
        except (NoTargetError, ServiceError, UsageError) as exc:
            return CommandDevicesResponse(success=False, message=str(exc))
        commanded: list[tuple[CommandedPart, Outcome]] = []
        parsed = [
            (device, *part_and_settings)
            for device, parts in targets
            for part_and_settings in settings_by_part(request, device, parts)
        ]
        readable = [
            (device, part, settings) for device, part, settings in parsed if not isinstance(settings, RefusedError)
        ]
        requests = [_part_request(request, *target) for target in readable]
        if request.unless_asks and (asks := await self._asks(readable, requests)):
            texts = ", ".join(f"{item.key} ({item.value})" for item in asks)
            return CommandDevicesResponse(success=False, message=f"a person must agree: {texts}", asks=asks)
        batch = iter(as_batch(requests))

        async def command(device: Device, part: DevicePart, wanted: CommandRequest | RefusedError) -> None:
            commanded.append(await self._command(device, part, wanted))
            if on_commanded is not None:
                on_commanded(commanded[-1][0], len(parsed) - len(commanded))

        async with anyio.create_task_group() as tasks:
            for device, part, settings in parsed:
                wanted = settings if isinstance(settings, RefusedError) else next(batch)
                tasks.start_soon(command, device, part, wanted)
        return CommandDevicesResponse.of(commanded)

    async def _asks(
        self, parts: Sequence[tuple[Device, DevicePart, object]], requests: Sequence[CommandRequest]
    ) -> tuple[KeyValue, ...]:
        """Return the parts for which a person must agree to the requests, each with the reason."""
        reasons = [
            (part_name(device, part), await self._commands.why_asked(request, device, part))
            for (device, part, _), request in zip(parts, requests, strict=True)
        ]
        return tuple([KeyValue(key=name, value=reason) for name, reason in reasons if reason])

    async def _scene(self, request: CommandDevicesRequest) -> CommandDevicesResponse | None:
        """Apply, or undo, the scene that *request* names as ``scene NAME``; None if it names none, or a device."""
        named, is_undo = SCENE_TARGET.match(request.target), _SCENE_WORDS.get(request.command.strip().casefold())
        if named is None or is_undo is None or request.values or await self._lookup.find_called(request.target.strip()):
            return None
        from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest  # noqa: PLC0415 - many homes have none

        asked = ApplySceneRequest(
            name=named["name"],
            transition=request.transition,
            undo=is_undo,
            issuer=request.issuer,
            scope=request.scope,
            ask_first=request.ask_first,
            trigger=request.trigger,
        )
        with closing(self._node.create_client(ApplyScene, APPLY_SCENE)) as client:
            return await client.call(asked, timeout=_MAX_WAIT_S)

    async def _find_targets(self, request: CommandDevicesRequest) -> tuple[list[Target], CommandDevicesRequest]:
        """Return the targets, and *request* with ``off`` or ``on`` for ``toggle``: off if any of them is on."""
        if request.command.strip().casefold() != "toggle":
            return await self._targets.find(request), request
        request = request.model_copy(update={"command": "on"})
        targets = await self._targets.find(request)
        parts = ((device, part) for device, own in targets for part, _ in settings_by_part(request, device, own))
        states = {certain_values(*device_and_part).get("on_off") for device_and_part in parts}
        if states <= {None}:
            raise NoTargetError(f"whether {request.target} is on is unknown; say on or off")
        return targets, request.model_copy(update={"command": "off"}) if True in states else request

    async def _command(
        self, device: Device, part: DevicePart, wanted: CommandRequest | RefusedError
    ) -> tuple[CommandedPart, Outcome]:
        if isinstance(wanted, RefusedError):
            outcome: Outcome = Refused("device", f"{wanted.what}: {wanted.reason}")
        else:
            outcome = await self._commands.perform(wanted)
        result = CommandResult.of(outcome)
        if isinstance(outcome, NoAnswer) and outcome.was_sent and (reason := await self._why_unreachable(device)):
            result = result.model_copy(update={"text": f"{result.text}; {reason}"})
        return CommandedPart(device=device.id, name=part_name(device, part), part=part.id, result=result), outcome

    def _refusal(self, request: CommandDevicesRequest, target: tuple[Device, tuple[DevicePart, ...]]) -> str:
        """Return why no part of *target* would get the command now; empty if one would."""
        device, parts = target
        problem = "it takes no commands"
        for part, parsed in settings_by_part(request, device, parts):
            if isinstance(parsed, RefusedError):
                problem = parsed.reason
                continue
            refused = self._commands.preview(_part_request(request, device, part, parsed), device, part)
            if refused is None:
                return ""
            problem = refused.reason
        return problem

    async def _why_unreachable(self, device: Device) -> str:
        """Return why *device* is unreachable now, perhaps only since the command; empty if it is reachable."""
        newest: Device | None = device
        newest = await self._lookup.known(device.id)
        return newest.reachable.why if newest is not None and newest.reachable.state == "no" else ""


def _part_request(
    request: CommandDevicesRequest, device: Device, part: DevicePart, settings: Mapping[str, PlainValue]
) -> CommandRequest:
    return CommandRequest(
        device=device.id,
        part=part.id,
        settings=tuple(map(Setting.of, settings, settings.values())),
        transition=request.transition,
        code=request.code,
        issuer=request.issuer or UNNAMED_CLIENT,
        scope=request.scope,
        ask_first=request.ask_first,
        override=request.override,
        cause=request.cause,
        trigger=request.trigger,
    )
