"""Responses of devices to commands, by the request and response of MQTT 5.

A command carries a topic for the response, and data by which the response is matched with it; and its id in the
journal, for debugging.

Source: MQTT Version 5.0, section 4.10.
"""

from __future__ import annotations

import math
import secrets
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, final

from homebot.clock import Clock
from homebot.conventions.payload import clean_text, parse_object
from homebot.devices.gateway_messages import Command, CommandAnswer
from homebot.errors import WireError
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.packets import NO_PROPERTIES, Properties
from homebot.support.bounded_map import BoundedMap

__all__ = ["COMMAND_ID", "ResponseCounters", "Responses", "problem_of"]

COMMAND_ID: Final = "command"
"""The user property with the id of a command."""

MOST_AWAITED: Final = 1000
"""Commands with awaited responses at once; the oldest is forgotten, and its response is then unknown."""

_TOKEN: Final = 8  # bytes, written as 16 hexadecimal digits: scripts can repeat them, and they are hard to guess
_LONGEST: Final = 4096  # bytes of a response
_LONGEST_REASON: Final = 200


@dataclass(slots=True)
class ResponseCounters:
    """Counters of responses.

    Attributes:
        responses_late: Those that came after the command had expired.
        responses_unknown: Those to no known command.
    """

    responses: int = 0
    responses_late: int = 0
    responses_unknown: int = 0


@final
class Responses:
    """Asks devices for responses, and publishes the answers."""

    def __init__(self, gateway: str, topic: str, clock: Clock, publish: Callable[[CommandAnswer], object]) -> None:
        self.counters = ResponseCounters()
        self.topic = topic
        self._gateway = gateway
        self._clock = clock
        self._publish = publish
        self._awaited: BoundedMap[bytes, tuple[Command, float]] = BoundedMap(MOST_AWAITED)

    def request(self, command: Command, properties: Properties) -> Properties:
        """Return *properties* of a message with *command*, which ask for a response if a caller waits for it."""
        if not command.id:
            return properties
        token = secrets.token_hex(_TOKEN).encode()
        until = self._clock.monotonic() + (command.expires_after or math.inf)
        self._awaited[token] = command, until
        return replace(self.named(command.id, properties), response_topic=self.topic, correlation_data=token)

    @staticmethod
    def named(command_id: str, properties: Properties = NO_PROPERTIES) -> Properties:
        """Return *properties* of a message with the id of the command that it carries; the same where it has none."""
        return replace(properties, user_properties=((COMMAND_ID, command_id),)) if command_id else properties

    def on_response(self, message: MqttMessage) -> None:
        """Match a message on :attr:`topic` with its command, and publish the answer."""
        awaited = self._awaited.pop(message.properties.correlation_data or b"", None)
        if awaited is None or message.retain:
            self.counters.responses_unknown += 1
            return
        command, until = awaited
        if self._clock.monotonic() > until:
            self.counters.responses_late += 1
            return
        self.counters.responses += 1
        problem = problem_of(message.payload)
        self._publish(
            CommandAnswer(
                gateway=self._gateway,
                key=command.key,
                part=command.part,
                capability=command.capability,
                command_id=command.id,
                success=not problem,
                message=problem,
            )
        )


def problem_of(response: bytes) -> str:
    """Return the reason of a refusing response; empty for any other.

    No standard defines them: one with an error, as of Zigbee2MQTT and Shelly, is a refusal; any other accepts the
    command.
    """
    try:
        fields = parse_object(response[:_LONGEST])
    except WireError:
        return ""
    error = fields.get("error")
    if not (error or fields.get("status") == "error" or fields.get("success") is False):
        return ""
    text = error.get("message") if isinstance(error, dict) else error or fields.get("message")
    return clean_text(text, _LONGEST_REASON) if isinstance(text, str) and text.strip() else "the device refuses"
