"""Brings the commands of handles to the gateways."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from homebot.devices.command import Command, SendCommand, SendCommandResponse
from homebot.devices.device import Device, DevicePart
from homebot.devices.handles.plain import phrase
from homebot.devices.names import GatewayNames
from homebot.devices.value import PlainValue, Value
from homebot.errors import LinkError, RefusedError, ServiceError
from homebot.graph import Client, Node

__all__ = ["Commander", "Tell"]

Tell = Callable[[Device, str], Awaitable[None]]
"""Tells a device a plain word; see :meth:`homebot.devices.Devices.tell`."""


class Commander:
    """Sends commands by the best way that is there.

    Args:
        node: Who sends them.
        tell: How devices without parts are told.
    """

    def __init__(self, node: Node, tell: Tell) -> None:
        self._node = node
        self._tell = tell
        self._clients: dict[str, Client[Command, SendCommandResponse]] = {}

    async def send(self, device: Device, part: DevicePart, capability: str, value: PlainValue, fade: float) -> None:
        """Make *capability* become *value* within *fade* seconds; return when the network has the command.

        Raises:
            RefusedError: The gateway or the part says no, or the part is disputed.
            LinkError: No gateway of the part is there, or it does not reach its network; it may work later.
        """
        if not part.routes:
            why = "; ".join(device.conflicts) or "no way to it is known"
            raise RefusedError(f"a command to {device.id}", why)
        problem = f"its gateway {part.routes[0].gateway} is not running"
        for route in part.routes:
            client = self._client(route.gateway)
            if not client.service_is_ready():
                continue
            command = Command(
                key=route.key, part=route.part, capability=capability, value=Value.of(value), transition=fade
            )
            try:
                response = await client.call(command)
            except ServiceError as exc:
                problem = str(exc)
                continue
            if response.success:
                return
            problem = response.message
            if response.problem != "unreachable":
                raise RefusedError(f"{capability} of {device.id}", problem)
        raise LinkError(f"{device.id} was not told {capability}: {problem}")

    async def say(self, device: Device, capability: str, value: PlainValue) -> None:
        """Tell *device*, which has no parts, by a plain word.

        Raises:
            RefusedError: There is no word for that, it takes no commands, or its gateway only observes.
            LinkError: No gateway of it is there.
        """
        said = phrase(capability, value)
        if not said:
            raise RefusedError(f"{capability} of {device.id}", "there is no plain word for that")
        await self._tell(device, said)

    def _client(self, gateway: str) -> Client[Command, SendCommandResponse]:
        if gateway not in self._clients:
            self._clients[gateway] = self._node.create_client(SendCommand, GatewayNames(gateway).send_command)
        return self._clients[gateway]
