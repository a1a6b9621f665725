"""Sender of commands: the best route to a part that accepts them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

from homebot.devices.capabilities import MOMENTARY
from homebot.devices.device import Device, DevicePart, Route
from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.names import OWNER, PREFER, GatewayNames
from homebot.devices.value import PlainValue, Value
from homebot.errors import (
    InvalidNameError,
    LinkError,
    RefusedError,
    ServiceError,
    ServiceGoneError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    UnansweredError,
)
from homebot.graph import Client, Node

__all__ = ["CommandSender"]


_ANSWERS_WITHIN: Final = 5.0
"""Seconds that a gateway has for its answer beyond the time in which it may carry the command out."""


class CommandSender:
    """Sends commands by the best route that accepts them."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Client[Command, SendCommandResponse]] = {}

    async def send(
        self,
        device: Device,
        part: DevicePart,
        capability: str,
        value: PlainValue,
        transition: float,
        code: str = "",
        expires_after: float = 0.0,
        command_id: str = "",
        kept_for: float = 0.0,
        *,
        repeated: bool = False,
        ineffective: Collection[str] = (),
    ) -> Route:
        """Set *capability* to *value* within *transition* seconds; return the route that accepted the command.

        A gateway that has not carried it out within *expires_after* seconds gives up. For a device that is away the
        network keeps it for *kept_for* seconds; *repeated* is a command that was sent before and had no effect: it
        begins with the second route, for the first accepted it. Routes named in *ineffective* come after those that
        work, unless the owner prefers their gateway.

        The next route is tried if one cannot do that, and sent nothing, or cannot reach the device; a command that a
        gateway refuses is not sent by another route. A button is not pressed by a second route if the first may have
        pressed it.

        Raises:
            RefusedError: The gateway or the part refuses, or the part is disputed.
            UnansweredError: A gateway sent it, and its network has not acknowledged it.
            LinkError: It was not sent: no gateway of the part is running and connected; it may work later.
        """
        routes = _routes(device, part, capability, ineffective, is_repeated=repeated)
        problem, unable, is_away, silence = f"its gateway {routes[0].gateway} is not running", "", False, ""
        for route in routes:
            command = Command(
                key=route.key,
                part=route.part,
                approved=route.approved,
                capability=capability,
                value=Value.of(value),
                transition=transition,
                code=code,
                expires_after=expires_after,
                id=command_id,
                kept_for=kept_for,
                repeated=repeated,
            )
            try:
                client = self._clients.get(route.gateway) or self._client(route.gateway)
                limit = expires_after + _ANSWERS_WITHIN
                response = await client.call(command, timeout=limit, cancel_with_caller=True)
            except (InvalidNameError, ServiceError) as exc:
                response = _failure(exc)
            if response.success:
                return route
            if response.problem in {"unreachable", "unanswered"}:
                is_away, problem = True, response.message or problem
                silence = problem if response.problem == "unanswered" else silence
                if capability in MOMENTARY and not response.unable:
                    break
            elif response.unable:
                unable = unable or response.message
            else:
                raise RefusedError(f"{capability} of {device.id}", response.message)
        if silence:
            raise UnansweredError(f"{capability} was sent to {device.id}: {silence}")
        if unable and not is_away:
            raise RefusedError(f"{capability} of {device.id}", unable)
        raise LinkError(f"{capability} was not sent to {device.id}: {problem}")

    def _client(self, gateway: str) -> Client[Command, SendCommandResponse]:
        client = self._clients[gateway] = self._node.create_client(SendCommand, GatewayNames(gateway).send_command)
        return client


def _failure(error: InvalidNameError | ServiceError) -> SendCommandResponse:
    """Return the answer in place of a gateway's; one that is not running is unreachable, and unable to send."""
    if isinstance(error, InvalidNameError):
        return SendCommandResponse(success=False, message=str(error), problem="refused", unable=True)
    if isinstance(error, ServiceTimeoutError | ServiceGoneError):
        return SendCommandResponse(success=False, message=str(error), problem="unanswered")
    is_away = isinstance(error, ServiceUnavailableError)
    message = "" if is_away else str(error)
    return SendCommandResponse(success=False, message=message, problem="unreachable", unable=is_away)


def _routes(
    device: Device, part: DevicePart, capability: str, ineffective: Collection[str], *, is_repeated: bool
) -> Sequence[Route]:
    """Return the routes by which *capability* is said to be set, those that work first; all if no route says so.

    A repeated command begins with the second. If the owner approved some routes, the others are not used: they were
    announced later, or changed.
    """
    if not part.routes:
        why = "; ".join(device.conflicts) or "it has no route for commands"
        raise RefusedError(f"a command to {device.id}", why)
    if len(part.routes) == 1:
        return part.routes
    approved = [route for route in part.routes if route.approved] or part.routes
    routes: Sequence[Route] = [route for route in approved if route.can(capability)] or approved
    if ineffective:
        routes = _working_first(routes, device, ineffective)
    return (*routes[1:], routes[0]) if is_repeated else routes


def _working_first(routes: Sequence[Route], device: Device, ineffective: Collection[str]) -> Sequence[Route]:
    """Return *routes*, the *ineffective* ones last, unless the owner prefers their gateway."""
    facts = [one.value.split(", ") for one in device.facts if (one.name, one.convention) == (PREFER, OWNER)]
    prefer = facts[0] if facts else ()
    return sorted(routes, key=lambda route: route.name in ineffective and route.gateway not in prefer)
