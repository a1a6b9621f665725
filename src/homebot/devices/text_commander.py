"""Raw texts of a node: through the control layer, which judges them; if there is none, straight to the gateway."""

from __future__ import annotations

from typing import Final

from homebot.devices.commander import NO_CONTROL
from homebot.devices.current_trigger import current_trigger
from homebot.devices.device import Device
from homebot.devices.names import RUNTIME_NODE, SEND_TEXT
from homebot.devices.text_messages import SendText, SendTextRequest
from homebot.devices.text_sender import TextSender
from homebot.errors import LinkError, RefusedError, ServiceError, ServiceUnavailableError
from homebot.graph import Node

__all__ = ["TextCommander"]

_LONGEST: Final = 900.0
"""Seconds that a text may wait for a gateway with a full queue."""


class TextCommander:
    """Sends texts in the name of a node, by the same ways as `Commander` gives commands.

    Args:
        node: The node, which is the issuer.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._control = node.create_client(SendText, SEND_TEXT)
        self._sender = TextSender(node)

    async def send(self, device: Device, payload: str) -> tuple[str, ...]:
        """Send *payload*; see :meth:`homebot.devices.Devices.tell`."""
        request = SendTextRequest(
            device=device.id, payload=payload, issuer=self._node.full_name, trigger=current_trigger()
        )
        try:
            response = await self._control.call(request, timeout=_LONGEST)
        except ServiceError as exc:
            if isinstance(exc, ServiceUnavailableError) and not self._control.service_is_ready():
                return await self._send_past_control(device, request)
            raise _not_sent(request, str(exc)) from exc
        if response.problem == "refused":
            raise RefusedError(f"a command to {device.id}", response.message)
        if not response.success:
            raise _not_sent(request, response.message)
        return response.others

    async def _send_past_control(self, device: Device, request: SendTextRequest) -> tuple[str, ...]:
        if self._node.graph.get_node(RUNTIME_NODE) is not None:
            raise LinkError(NO_CONTROL)
        try:
            target = self._sender.target(device, request.payload)
            await self._sender.send(request.payload, target, request.issuer, request.trigger)
        except LinkError as exc:
            raise _not_sent(request, str(exc)) from exc
        return target.others


def _not_sent(request: SendTextRequest, why: str) -> LinkError:
    return LinkError(f"{request.payload!r} was not sent to {request.device}: {why}")
