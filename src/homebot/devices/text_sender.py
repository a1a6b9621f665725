"""Sender of raw texts: to the first endpoint of a device that accepts commands and has a running gateway."""

from __future__ import annotations

from typing import NamedTuple

from homebot.devices.device import Device, Endpoint, check_gateway
from homebot.devices.gateway_messages import GatewayState, RawCommand
from homebot.devices.names import ONLY_OBSERVES, GatewayNames
from homebot.devices.text.address import command_address, others_at
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.errors import LinkError, RefusedError
from homebot.graph import Node, Publisher, qos_profile_latched

__all__ = ["GatewayOutput", "TextSender", "TextTarget"]

_DEPTH = 1000


class TextTarget(NamedTuple):
    """Destination of a text.

    Attributes:
        address: The address that the gateway sends it to.
        others: The names of the other parts that would accept the text too.
    """

    gateway: str
    address: str
    others: tuple[str, ...]


class TextSender:
    """Publishes texts for the gateways."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._gateways: dict[str, GatewayOutput] = {}

    def target(self, device: Device, payload: str) -> TextTarget:
        """Return where *payload* for *device* goes.

        Raises:
            RefusedError: The device accepts no commands, or its gateway only observes.
            LinkError: None of its gateways is running and reaches its network.
        """
        gateway = ""
        problem: RefusedError | None = None
        for endpoint in device.endpoints:
            if not endpoint.command_address:
                continue
            gateway = gateway or endpoint.gateway
            try:
                peer = self._output_to(endpoint)
            except RefusedError as exc:
                problem = exc
                continue
            if why_not := peer.refusal():
                raise RefusedError(f"a command to {device.id}", why_not)
            if not peer.unavailable and peer.out.reaches(peer.node):
                return _target(device, endpoint, payload)
        if problem is not None:
            raise problem
        if not gateway:
            raise RefusedError(f"a command to {device.id}", "it takes no commands")
        raise _away(gateway, self._gateways[gateway].unavailable)

    def _output_to(self, endpoint: Endpoint) -> GatewayOutput:
        if (known := self._gateways.get(endpoint.gateway)) is not None:
            return known
        check_gateway(endpoint)
        output = self._gateways[endpoint.gateway] = GatewayOutput(self._node, endpoint.gateway)
        return output

    async def send(
        self,
        payload: str,
        target: TextTarget,
        issuer: str,
        trigger: Trigger = NO_TRIGGER,
        command_id: str = "",
    ) -> RawCommand:
        """Send *payload* to *target*, which :meth:`target` returned; return when the gateway has queued it.

        Raises:
            LinkError: The gateway went away meanwhile.
        """
        peer = self._gateways[target.gateway]
        command = RawCommand(
            address=target.address, payload=payload, issuer=issuer, trigger=trigger, command_id=command_id
        )
        has_waited = await peer.out.send(command)
        if has_waited and not peer.out.reaches(peer.node):  # it went while its queue was full
            raise _away(target.gateway)
        return command


class GatewayOutput:
    """Publisher of texts to one gateway, with the last state that it reported.

    Attributes:
        unavailable: The reason why it does not reach its network, by the state that :meth:`refusal` read last; empty
            where it does.
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
        """Return why it sends no commands, by its last state; empty if it does, or reported none yet."""
        if self._states.mailbox.waiting and (state := self._states.take()) is not None:
            self._refusal = "" if state.acts else state.reason or ONLY_OBSERVES
            self.unavailable = (state.reason or "no reason is known") if state.state == "unavailable" else ""
        return self._refusal


def _target(device: Device, endpoint: Endpoint, payload: str) -> TextTarget:
    if len(device.parts) == 1 and len(device.parts[0].routes) == 1:
        return TextTarget(endpoint.gateway, endpoint.command_address, ())
    address = command_address(device, endpoint, payload)
    return TextTarget(endpoint.gateway, address, others_at(device, address, payload))


def _away(gateway: str, unavailable: str = "") -> LinkError:
    """Return an error that says nothing of the text, which may be a code."""
    return LinkError(f"its gateway {gateway} is {f'unavailable: {unavailable}' if unavailable else 'not running'}")
