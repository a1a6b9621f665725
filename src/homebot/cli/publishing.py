"""Publishing through a gateway, for the command line."""

from __future__ import annotations

from collections.abc import Mapping

import anyio

from homebot.cli.directory import entities
from homebot.cli.door_client import DoorClient
from homebot.devices import GatewayNames, GatewayState, RawCommand
from homebot.devices.gateway_state import ONLY_OBSERVES
from homebot.devices.health import HealthResponse
from homebot.errors import LinkError, RefusedError
from homebot.messages.json import message_from_json, message_to_json

__all__ = ["GatewayPublisher", "gateway_state"]

_STATE_TIMEOUT = 2.0
"""Seconds for a state that is kept for late joiners, and so comes at once where there is one."""

_OUTCOME = 5.0
_POLL = 0.02
_LOG_WAIT = 0.3
"""Seconds: for what became of a command, between two looks, and for the lines of the log that are kept."""


class GatewayPublisher:
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
        await self.send(gateway, message_to_json(RawCommand(address=topic, payload=payload, retain=retain)))

    async def send(self, gateway: str, command: Mapping[str, object]) -> None:
        """Send a command through *gateway*, and wait until it says what became of it.

        Raises:
            RefusedError: It only observes, or refused the command, or the command is no message of its topic.
            LinkError: It is not there, did not reach its network, or did not say what became of the command.
        """
        await self.check(gateway)
        before = await self._counts(gateway)
        await self._door.publish(GatewayNames(gateway).out, command)
        await self._door.settle()
        if before is not None:
            await self._wait_for_the_outcome(gateway, command, before)

    async def _wait_for_the_outcome(
        self, gateway: str, command: Mapping[str, object], before: Mapping[str, int]
    ) -> None:
        """Look at what the gateway counts: its topic has no way back."""
        what = f"the command to {command.get('address')}"
        with anyio.move_on_after(_OUTCOME):
            while True:
                now = await self._counts(gateway) or before
                if now.get("commands", 0) > before.get("commands", 0):
                    return
                if now.get("commands_refused", 0) > before.get("commands_refused", 0):
                    raise RefusedError(what, await self._reason(gateway, command))
                if now.get("commands_failed", 0) > before.get("commands_failed", 0):
                    raise LinkError(f"{what} could not be sent: {await self._reason(gateway, command)}")
                await anyio.sleep(_POLL)
        raise LinkError(f"gateway {gateway} did not report the result of {what} within {_OUTCOME:g} s")

    async def _counts(self, gateway: str) -> dict[str, int] | None:
        """Return what *gateway* counted so far; None where it does not count its commands."""
        service = GatewayNames(gateway).health
        if not await entities(self._door, kind="service", name=service):
            return None
        health = message_from_json(HealthResponse, await self._door.call(service))
        counts = {one.name: one.count for one in health.counts}
        return counts if "commands" in counts else None

    async def _reason(self, gateway: str, command: Mapping[str, object]) -> str:
        """Return what the gateway's log says of *command*; the last lines are kept for late joiners."""
        await self._door.subscribe("/rosout")
        beginning, reason = f"not sent to {command.get('address')}: ", "the gateway's log says why"
        with anyio.move_on_after(_LOG_WAIT):
            while True:
                delivery = await self._door.next()
                text = str(delivery.message.get("msg", ""))
                if delivery.message.get("name") == f"gateway.{gateway}" and text.startswith(beginning):
                    reason = text.removeprefix(beginning)
        return reason


async def gateway_state(door: DoorClient, gateway: str) -> GatewayState | None:
    """Return how *gateway* says it is; None where nobody says so."""
    topic = GatewayNames(gateway).state
    await door.subscribe(topic)
    with anyio.move_on_after(_STATE_TIMEOUT):
        while True:
            delivery = await door.next()
            if delivery.topic == topic:
                return message_from_json(GatewayState, delivery.message)
    return None
