"""Publishing through a gateway for the command line."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, cast

from homebot.cli.door_client import DoorClient
from homebot.cli.graph_queries import entities
from homebot.devices.names import ONLY_OBSERVES, GatewayNames
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import LinkError, RefusedError

if TYPE_CHECKING:
    from homebot.devices import GatewayState
    from homebot.devices.health import HealthResponse

_RAW_COMMAND = "homebot/msg/RawCommand"

_STATE_TIMEOUT = 2.0
"""Seconds to wait for the state of a gateway that has not been published yet."""

_STATE_WITHIN = 10.0
"""Seconds to wait for a published state: it is latched, and arrives at once unless the computer is busy."""

_OUTCOME = 10.0
_POLL = 0.02
_LOG_WAIT = 0.3
"""Seconds: for the outcome of a command, between two checks, and for the latched log lines."""


class GatewayPublisher:
    """Publishes through the gateways of a running homebot."""

    def __init__(self, door: DoorClient) -> None:
        self._door = door
        self._checked: set[str] = set()

    def check(self, gateway: str) -> None:
        """Check that *gateway* is running and sends commands.

        Raises:
            RefusedError: The gateway only observes.
            LinkError: The gateway is not running, or does not reach its network.
        """
        if gateway in self._checked:
            return
        state = gateway_state(self._door, gateway)
        if state is None:
            raise LinkError(f"gateway {gateway} is not running")
        if not state.acts:
            raise RefusedError(f"publishing through {gateway}", state.reason or ONLY_OBSERVES)
        if state.state != "active":
            raise LinkError(f"gateway {gateway} is unavailable: {state.reason}")
        self._door.advertise(GatewayNames(gateway).out, _RAW_COMMAND)
        self._door.settle()
        self._checked.add(gateway)

    def publish(self, gateway: str, topic: str, payload: str) -> None:
        """Publish a retained message through *gateway*, and wait until it reports the outcome.

        Raises:
            RefusedError: The gateway only observes, or refused the message.
            LinkError: The gateway is not running, did not reach its network, or did not report the outcome.
        """
        self.check(gateway)
        before = self._counts(gateway)
        self._door.publish(GatewayNames(gateway).out, {"address": topic, "payload": payload, "retain": True})
        self._door.settle()
        if before is None:
            return
        what = f"the command to {topic}"
        deadline = time.monotonic() + _OUTCOME
        while time.monotonic() < deadline:  # of the counters, because the gateway's topic has no answers
            now = self._counts(gateway) or before
            if now.get("commands", 0) > before.get("commands", 0):
                return
            if now.get("commands_refused", 0) > before.get("commands_refused", 0):
                raise RefusedError(what, self._reason(gateway, topic))
            if now.get("commands_failed", 0) > before.get("commands_failed", 0):
                raise LinkError(f"{what} could not be sent: {self._reason(gateway, topic)}")
            time.sleep(_POLL)
        raise LinkError(f"gateway {gateway} did not report the result of {what} within {_OUTCOME:g} s")

    def _counts(self, gateway: str) -> dict[str, int] | None:
        service = GatewayNames(gateway).health
        if not entities(self._door, kind="service", name=service):
            return None
        health = cast("HealthResponse", JsonMessage(self._door.call(service)))
        counts = {count.name: count.count for count in health.counts}
        return counts if "commands" in counts else None

    def _reason(self, gateway: str, topic: str) -> str:
        """Return the reason in the gateway's log lines about *topic*; the last lines are latched."""
        self._door.subscribe("/rosout")
        beginning, reason = f"not sent to {topic}: ", "see the gateway's log"
        for message in self._door.until(_LOG_WAIT):
            text = str(message.message.get("msg", ""))
            if message.message.get("name") == f"gateway.{gateway}" and text.startswith(beginning):
                reason = text.removeprefix(beginning)
        return reason


def gateway_state(door: DoorClient, gateway: str) -> GatewayState | None:
    """Return the reported state of *gateway*; None without a report."""
    topic = GatewayNames(gateway).state
    door.subscribe(topic)
    is_published = entities(door, kind="publisher", name=topic)
    for message in door.until(_STATE_WITHIN if is_published else _STATE_TIMEOUT):
        if message.topic == topic:
            return cast("GatewayState", JsonMessage(message.message))
    return None
