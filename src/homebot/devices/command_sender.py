"""Sender of commands and texts by the best route to a part that accepts them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from contextlib import closing, suppress
from typing import Final, NamedTuple

from homebot.devices.always_ask import why_it_asks
from homebot.devices.capabilities import is_told_once
from homebot.devices.command_messages import Setting
from homebot.devices.device import Device, DevicePart, Endpoint, Route, check_gateway
from homebot.devices.gateway_messages import (
    Command,
    GatewayState,
    RawCommand,
    RefreshPart,
    RefreshRequest,
    SendCommand,
    SendCommandResponse,
)
from homebot.devices.names import ONLY_OBSERVES, OWNER, PREFER, GatewayNames
from homebot.devices.text.commands import command_address, others_at
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.errors import (
    HomebotError,
    InvalidNameError,
    LinkError,
    RefusedError,
    ServiceError,
    ServiceGoneError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    UnansweredError,
)
from homebot.graph import Client, Node, Publisher, qos_profile_latched

_HUES: Final = frozenset({"color", "color_temperature"})

_ANSWERS_WITHIN: Final = 5.0
"""Seconds that a gateway has to answer, beyond the time that it may take to carry out the command."""


class CommandSender:
    """Sends commands by the best route that accepts them."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Client[Command, SendCommandResponse]] = {}

    async def send(
        self, device: Device, part: DevicePart, orders: Sequence[Command], ineffective: Collection[str] = ()
    ) -> tuple[Route, Sequence[Command]]:
        """Send the first of *orders*, with the others that its gateway can send in the same message.

        Return the route that accepted it, which fills in its key, part and approval, and the orders that are left.

        The next route is tried if one is unable to send the command, or cannot reach the device; a command that a
        gateway refuses is not sent by another route, nor one that is told once, if the first route may have sent it.
        A repeated command begins with the second route, because the first accepted it before.

        Args:
            ineffective: Names of routes to try last, unless the owner prefers their gateway.

        Raises:
            RefusedError: The gateway or the part refuses it, or the part is disputed.
            UnansweredError: A gateway sent it, but its network has not acknowledged it.
            LinkError: It was not sent, because no gateway of the part is running and connected; it may work later.
        """
        command, failures = orders[0], list[SendCommandResponse]()
        capability, routes = command.capability, part.routes
        if len(routes) != 1:
            routes = _routes(device, part, capability, ineffective, is_repeated=command.repeated)
        if len(orders) > 1 and not command.code:
            command = command.model_copy(update={"also": _along(orders, routes)})
        for route in routes:
            by_route = {"key": route.key, "part": route.part, "approved": route.approved, "topics": route.topics}
            try:
                client = self._clients.get(route.gateway) or self._client(route.gateway)
                response = await client.call(
                    command.model_copy(update=by_route),
                    timeout=command.expires_after + _ANSWERS_WITHIN,
                    cancel_with_caller=True,
                )
            except (InvalidNameError, ServiceError) as exc:
                response = _failure(exc, route.gateway)
            if response.success:
                return route, _left(orders, response.along) if len(orders) > 1 else ()
            failures.append(response)
            if not response.unable and (response.problem == "refused" or _is_told_once(device, part, command)):
                break
        is_left_out = routes[0].approved and not all(route.approved for route in part.routes)
        raise _error(
            capability,
            device.id,
            failures,
            f"; `homebot approve {device.id}` lets another route take it" if is_left_out else "",
        )

    async def refresh(self, part: DevicePart) -> bool:
        """Have a part asked for its values, and a group those of its members; return whether a route can."""
        for route in part.routes:
            client = self._node.create_client(RefreshPart, GatewayNames(route.gateway).refresh)
            with closing(client), suppress(InvalidNameError, ServiceError):
                request = RefreshRequest(key=route.key, part=route.part)
                if client.service_is_ready() and (await client.call(request, timeout=_ANSWERS_WITHIN)).success:
                    return True
        return False

    def _client(self, gateway: str) -> Client[Command, SendCommandResponse]:
        client = self._clients[gateway] = self._node.create_client(SendCommand, GatewayNames(gateway).send_command)
        return client


def _along(orders: Sequence[Command], routes: Iterable[Route]) -> tuple[Setting, ...]:
    """Return the further settings that all *routes* take; a white and a colour are never sent at once."""
    hues = [order.capability for order in orders if order.capability in _HUES]
    return tuple(
        Setting(capability=order.capability, value=order.value)
        for order in orders[1:]
        if order.capability not in hues[1:] and all(route.can(order.capability) for route in routes)
    )


def _left(orders: Sequence[Command], along: Collection[str]) -> Sequence[Command]:
    """Return the orders without the first and those *along*; a repetition at their end follows any that is left."""
    sent = {orders[0].capability, *along}
    left = [order for order in orders if order.capability not in sent]
    last = orders[-1]
    is_repeated = last.capability in sent and [order.capability for order in orders].count(last.capability) > 1
    return [*left, last] if left and is_repeated else left


def _is_told_once(device: Device, part: DevicePart, command: Command) -> bool:
    names = [command.capability, *(setting.capability for setting in command.also)]
    is_undone = is_told_once(part.part.service_type, names)
    return is_undone or bool(command.code or why_it_asks(device, part))


def _error(capability: str, device: str, failures: Sequence[SendCommandResponse], hint: str) -> HomebotError:
    """Return the error of a command that no route accepted.

    Args:
        hint: Ends the reason of routes that were unable.
    """
    last = failures[-1]
    if last.problem == "refused" and not last.unable:
        return RefusedError(f"{capability} of {device}", last.message)
    if silent := [failure.message for failure in failures if failure.problem == "unanswered"]:
        return UnansweredError(f"{capability} was sent to {device}: {silent[-1]}")
    if away := [failure for failure in failures if failure.problem == "unreachable"]:
        lost = [failure for failure in away if not failure.unable] or away[:1]  # a gateway that runs knows more
        return LinkError(f"{capability} of {device}: {lost[-1].message}")
    return RefusedError(f"{capability} of {device}", failures[0].message + hint)


def _failure(error: InvalidNameError | ServiceError, gateway: str) -> SendCommandResponse:
    """Return the answer on behalf of a gateway; if it is not running, it is unreachable and unable to send."""
    if isinstance(error, InvalidNameError):
        return SendCommandResponse(success=False, message=str(error), problem="refused", unable=True)
    if isinstance(error, ServiceTimeoutError | ServiceGoneError):
        return SendCommandResponse(success=False, message=str(error), problem="unanswered")
    is_away = isinstance(error, ServiceUnavailableError)
    message = f"its gateway {gateway} is not running" if is_away else str(error)
    return SendCommandResponse(success=False, message=message, problem="unreachable", unable=is_away)


def _routes(
    device: Device, part: DevicePart, capability: str, ineffective: Collection[str], *, is_repeated: bool
) -> tuple[Route, ...]:
    """Return the routes that declare to set *capability*, working ones first; all routes if none declares it.

    A repeated command begins with the second. If the owner approved some routes, the others are not used, because they
    were announced later or changed.
    """
    if not part.routes:
        why = "; ".join(device.conflicts) or "it has no route for commands"
        raise RefusedError(f"a command to {device.id}", why)
    approved = [route for route in part.routes if route.approved] or part.routes
    routes: Sequence[Route] = [route for route in approved if route.can(capability)] or approved
    if ineffective:
        facts = [fact.value.split(", ") for fact in device.facts if (fact.name, fact.convention) == (PREFER, OWNER)]
        prefer = facts[0] if facts else ()
        routes = sorted(routes, key=lambda route: route.name in ineffective and route.gateway not in prefer)
    return (*routes[1:], routes[0]) if is_repeated else tuple(routes)


_DEPTH = 1000


class TextTarget(NamedTuple):
    """A text and its destination.

    Attributes:
        payload: The text, which may be a code.
        address: The address that the gateway sends it to; empty, like the gateway, before it is known.
        others: The names of the other parts that would also accept the text.
    """

    payload: str
    gateway: str = ""
    address: str = ""
    others: tuple[str, ...] = ()


class TextSender:
    """Publishes texts for the gateways."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._gateways: dict[str, GatewayOutput] = {}

    def target(self, device: Device, payload: str) -> TextTarget:
        """Return the target of *payload* for *device*.

        Raises:
            RefusedError: The device accepts no commands, or its gateway only observes.
            LinkError: None of its gateways is running and reaches its network.
        """
        gateway = ""
        problem: RefusedError | None = None
        for endpoint in device.endpoints:
            if not endpoint.command_address:
                continue
            try:
                peer = self._gateways.get(endpoint.gateway) or self._output_to(endpoint)
            except RefusedError as exc:
                problem = exc
                continue
            if why_not := peer.refusal():
                problem = RefusedError(f"a command to {device.id}", why_not)
                if why_not == ONLY_OBSERVES:
                    continue
                raise problem
            if not peer.unavailable and peer.out.reaches(peer.node):
                if len(device.parts) == 1 and len(device.parts[0].routes) == 1:
                    return TextTarget(payload, endpoint.gateway, endpoint.command_address)
                address = command_address(device, endpoint, payload)
                return TextTarget(payload, endpoint.gateway, address, others_at(device, address, payload))
            gateway = gateway or endpoint.gateway
        if gateway:
            raise _away(gateway, self._gateways[gateway].unavailable)
        raise problem or RefusedError(f"a command to {device.id}", "it takes no commands")

    def _output_to(self, endpoint: Endpoint) -> GatewayOutput:
        check_gateway(endpoint)
        output = self._gateways[endpoint.gateway] = GatewayOutput(self._node, endpoint.gateway)
        return output

    async def send(
        self,
        target: TextTarget,
        issuer: str,
        trigger: Trigger = NO_TRIGGER,
        command_id: str = "",
        routes: Sequence[Route] = (),
    ) -> RawCommand:
        """Send the text to *target*, which :meth:`target` returned; return once the gateway has queued it.

        Args:
            routes: The ways to the part at *target*, the first of which was checked.

        Raises:
            LinkError: The gateway disconnected meanwhile.
        """
        peer = self._gateways[target.gateway]
        command = RawCommand(
            address=target.address,
            payload=target.payload,
            issuer=issuer,
            trigger=trigger,
            command_id=command_id,
            approved=routes[0].approved if routes else "",
            topics=routes[0].topics if routes else (),
        )
        has_waited = await peer.out.send(command)
        if has_waited and not peer.out.reaches(peer.node):  # it disconnected while its queue was full
            raise _away(target.gateway)
        return command


class GatewayOutput:
    """Publisher of texts to one gateway, with the gateway's last reported state.

    Attributes:
        unavailable: The reason why it does not reach its network, by the state that :meth:`refusal` last read; empty if
            it does.
    """

    def __init__(self, sender: Node, gateway: str) -> None:
        names = GatewayNames(gateway)
        self.node = names.node
        self.out: Publisher[RawCommand] = sender.create_publisher(RawCommand, names.out, _DEPTH)
        self._states = sender.create_subscription(
            GatewayState, names.state, qos_profile=qos_profile_latched, from_node=names.node
        )
        self._refusal = ""
        self.unavailable = ""

    def refusal(self) -> str:
        """Return why it sends no commands, by its last state; empty if it does, or has reported no state yet."""
        if self._states.mailbox.waiting and (state := self._states.take()) is not None:
            self.unavailable = (state.reason or "no reason is known") if state.state == "unavailable" else ""
            self._refusal = "" if state.acts else ONLY_OBSERVES if self.unavailable else state.reason or ONLY_OBSERVES
        return self._refusal


def _away(gateway: str, unavailable: str = "") -> LinkError:
    """Return an error that does not show the text, which may be a code."""
    return LinkError(f"its gateway {gateway} is {f'unavailable: {unavailable}' if unavailable else 'not running'}")
