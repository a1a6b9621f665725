"""What the command line publishes through a gateway."""

from __future__ import annotations

import anyio

from homebot.cli.door_client import DoorClient
from homebot.devices import GatewayNames, GatewayState, RawCommand
from homebot.devices.gateway_state import ONLY_OBSERVES
from homebot.errors import LinkError, RefusedError
from homebot.messages.json import message_from_json, message_to_json

__all__ = ["Outbox", "gateway_state"]

_PATIENCE = 2.0
"""Seconds for a state that is kept for late joiners, and so comes at once where there is one."""


class Outbox:
    """Publishes through the gateways of a running homebot.

    Args:
        door: The way to it.
    """

    def __init__(self, door: DoorClient) -> None:
        self._door = door
        self._checked: set[str] = set()

    async def check(self, gateway: str) -> None:
        """Make sure that *gateway* is there and sends what it is told.

        Raises:
            RefusedError: It only observes.
            LinkError: It is not there, or does not reach its network.
        """
        if gateway in self._checked:
            return
        state = await gateway_state(self._door, gateway)
        if state is None:
            raise LinkError(f"gateway {gateway} is not running")
        if not state.acts:
            raise RefusedError(f"publishing through {gateway}", state.reason or ONLY_OBSERVES)
        if state.state != "active":
            raise LinkError(f"gateway {gateway} is unavailable: {state.reason}")
        await self._door.advertise(GatewayNames(gateway).out, RawCommand.ros_type)
        await self._door.settle()
        self._checked.add(gateway)

    async def publish(self, gateway: str, topic: str, payload: str, *, retain: bool) -> None:
        """Publish through *gateway*.

        Raises:
            RefusedError, LinkError: As for :meth:`check`.
        """
        await self.check(gateway)
        command = RawCommand(address=topic, payload=payload, retain=retain)
        await self._door.publish(GatewayNames(gateway).out, message_to_json(command))
        await self._door.settle()


async def gateway_state(door: DoorClient, gateway: str) -> GatewayState | None:
    """Return how *gateway* says it is; None where nobody says so."""
    topic = GatewayNames(gateway).state
    await door.subscribe(topic)
    with anyio.move_on_after(_PATIENCE):
        while True:
            delivery = await door.next()
            if delivery.topic == topic:
                return message_from_json(GatewayState, delivery.message)
    return None
