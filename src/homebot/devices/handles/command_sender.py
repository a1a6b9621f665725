"""Brings the commands of handles to the gateways."""

from __future__ import annotations

from homebot.devices.command import Command, SendCommand, SendCommandResponse
from homebot.devices.device import Device, DevicePart
from homebot.devices.names import GatewayNames
from homebot.devices.value import PlainValue, Value
from homebot.errors import InvalidNameError, LinkError, RefusedError, ServiceError
from homebot.graph import Client, Node

__all__ = ["CommandSender"]


class CommandSender:
    """Sends commands by the best way that is there.

    Args:
        node: Who sends them.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Client[Command, SendCommandResponse]] = {}

    async def send(
        self, device: Device, part: DevicePart, capability: str, value: PlainValue, fade: float, code: str = ""
    ) -> None:
        """Make *capability* become *value* within *fade* seconds; return when the network has the command.

        Where a way cannot do that, and sent nothing, the next one is tried; what a gateway refuses to do at all is not
        done by another way.

        Raises:
            RefusedError: The gateway or the part says no, or the part is disputed.
            LinkError: No gateway of the part is there, or it does not reach its network; it may work later.
        """
        if not part.routes:
            why = "; ".join(device.conflicts) or "no way to it is known"
            raise RefusedError(f"a command to {device.id}", why)
        routes = [route for route in part.routes if route.can(capability)] or part.routes
        problem, unable = f"its gateway {routes[0].gateway} is not running", ""
        is_away = False
        for route in routes:
            command = Command(
                key=route.key, part=route.part, capability=capability, value=Value.of(value), transition=fade, code=code
            )
            response = await self._call(route.gateway, command)
            if response.success:
                return
            if response.problem == "unreachable":
                is_away, problem = True, response.message or problem
            elif not response.unable:
                raise RefusedError(f"{capability} of {device.id}", response.message)
            else:
                unable = unable or response.message
        if unable and not is_away:
            raise RefusedError(f"{capability} of {device.id}", unable)
        raise LinkError(f"{device.id} was not told {capability}: {problem}")

    async def _call(self, gateway: str, command: Command) -> SendCommandResponse:
        try:
            client = self._client(gateway)
        except InvalidNameError as exc:
            return SendCommandResponse(success=False, message=str(exc), problem="refused", unable=True)
        if not client.service_is_ready():
            return SendCommandResponse(success=False, problem="unreachable")
        try:
            return await client.call(command)
        except ServiceError as exc:
            return SendCommandResponse(success=False, message=str(exc), problem="unreachable")

    def _client(self, gateway: str) -> Client[Command, SendCommandResponse]:
        if gateway not in self._clients:
            self._clients[gateway] = self._node.create_client(SendCommand, GatewayNames(gateway).send_command)
        return self._clients[gateway]
