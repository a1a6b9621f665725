"""Actions that command devices and hold values. Loaded when used."""

from collections.abc import Callable
from typing import Final, Literal, TypeAlias, final

import anyio

from homebot.command_words.command_service import UNNAMED_CLIENT
from homebot.control.control_layer import ControlLayer
from homebot.control.lease_service import LeaseService
from homebot.devices.action_messages import (
    CommandDevicesAction,
    CommandDevicesFeedback,
    CommandDevicesGoal,
    CommandDevicesResult,
    HoldDevice,
    HoldDeviceFeedback,
    HoldDeviceGoal,
    HoldDeviceResult,
)
from homebot.devices.command_messages import CommandedPart
from homebot.devices.lease_messages import HolderRequest, HoldRequest, LeaseState
from homebot.devices.names import HOLD_DEVICE, PERFORM_COMMANDS
from homebot.devices.outcomes import Contradicted
from homebot.graph import Node
from homebot.graph.actions import ActionServer, ServerGoal

_FEEDBACK: Final = 1.0
"""Seconds between two feedback messages of a hold."""

_TTL: Final = 10.0
"""Seconds after which a lease ends unless it is renewed."""

CommandGoal: TypeAlias = ServerGoal[CommandDevicesGoal, CommandDevicesResult, CommandDevicesFeedback]
HoldGoal: TypeAlias = ServerGoal[HoldDeviceGoal, HoldDeviceResult, HoldDeviceFeedback]
Phase: TypeAlias = Literal["commanding", "held", "outranked"]


@final
class ControlActions:
    """Serves the actions of the control layer."""

    def __init__(self, node: Node, layer: Callable[[], ControlLayer]) -> None:
        self._node = node
        self._layer = layer

    def serve_commands(self) -> None:
        """Create the server of commands in words."""
        ActionServer(self._node, CommandDevicesAction, PERFORM_COMMANDS, self._perform)

    def serve_holds(self) -> None:
        """Create the server of holds."""
        ActionServer(self._node, HoldDevice, HOLD_DEVICE, self._hold)

    async def _perform(self, goal: CommandGoal) -> CommandDevicesResult:
        known: list[CommandedPart] = []

        def on_commanded(commanded: CommandedPart, waiting: int) -> None:
            known.append(commanded)
            goal.publish_feedback(CommandDevicesFeedback(commanded=commanded, waiting=waiting))

        try:
            response = await self._layer().words.serve(goal.request, on_commanded)
        except anyio.get_cancelled_exc_class():
            if goal.is_cancel_requested:
                goal.canceled(CommandDevicesResult(success=False, message="cancelled", results=tuple(known)))
            raise
        (goal.succeed if response.success else goal.abort)()
        return CommandDevicesResult(**dict(response))

    async def _hold(self, goal: HoldGoal) -> HoldDeviceResult:
        request, leases = goal.request, self._layer().leases
        issuer, lease = request.issuer or UNNAMED_CLIENT, goal.goal_id.uuid.hex()
        by = request.by.strip() or issuer.removeprefix("client:")[:100]
        _publish_phase(goal, "commanding", request.seconds)
        holder = HolderRequest(lease=lease, by=by, issuer=issuer)
        device, part, setting, scope = request.device, request.part, request.setting, request.scope
        wanted = HoldRequest(
            device=device,
            part=part,
            setting=setting,
            lease=lease,
            by=by,
            ttl=_TTL,
            is_open_ended=True,
            issuer=issuer,
            scope=scope,
        )
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(_renew, leases, holder)
                answer = await self._follow(goal, leases, holder, await leases.hold(wanted))
                tasks.cancel_scope.cancel()
        except anyio.get_cancelled_exc_class():
            if goal.is_cancel_requested:
                is_held = _phase(leases.renew(holder)) == "held"
                goal.canceled(HoldDeviceResult(success=is_held, message="released"))
            raise
        finally:
            leases.release(holder)
        (goal.succeed if answer.held else goal.abort)()
        return HoldDeviceResult(success=answer.held, message="" if answer.held else answer.outcome.text)

    async def _follow(
        self, goal: HoldGoal, leases: LeaseService, holder: HolderRequest, answer: LeaseState
    ) -> LeaseState:
        """Publish the state of a lease until its time is up or it ends; return its last state."""
        seconds, clock = goal.request.seconds, self._node.graph.clock
        until: float | None = None
        while answer.held:
            phase, now = _phase(answer), clock.monotonic()
            if until is None and phase == "held":
                until = now + seconds
            left = seconds if until is None else until - now
            if seconds and left <= 0:
                break
            _publish_phase(goal, phase, left if seconds else 0.0, answer.outcome.text)
            await anyio.sleep(min(left, _FEEDBACK) if seconds else _FEEDBACK)
            answer = leases.renew(holder)
        return answer


async def _renew(leases: LeaseService, holder: HolderRequest) -> None:
    """Renew a lease until cancelled, even while its first command is pending."""
    while True:
        await anyio.sleep(_TTL / 3)
        leases.renew(holder)


def _publish_phase(goal: HoldGoal, phase: Phase, seconds_left: float, message: str = "") -> None:
    goal.publish_feedback(HoldDeviceFeedback(phase=phase, seconds_left=seconds_left, message=message))


def _phase(answer: LeaseState) -> Phase:
    is_outranked = isinstance(answer.outcome, Contradicted)
    return "held" if answer.outcome.succeeded else "outranked" if is_outranked else "commanding"
