"""Reader of plain text states, of devices of a topic layout, as reports for the graph.

Most words speak for themselves. Of a thermostat a number may be the room's temperature or its target: it is the target
where it answers a command of ours with just that number.
"""

from __future__ import annotations

from homebot.conventions.bounded_dict import BoundedDict
from homebot.devices.part import Part
from homebot.devices.report import Reading
from homebot.devices.text.decode import Decoded
from homebot.devices.text.encode import decode_command
from homebot.devices.value import Value
from homebot.errors import RefusedError
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.mqtt.channels import Channel
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.mqtt.message import MqttMessage

__all__ = ["TextStateReader"]

_LONGEST = 1000
"""Bytes of a payload that may be a word."""

_MAX_TOLD = 1000
"""Commands that an answer is waited for; the oldest is forgotten."""


class TextStateReader:
    """Reads words.

    Args:
        board: Where it is told.
        counters: Of the gateway.
    """

    def __init__(self, board: DeviceReporter, counters: GatewayCounters) -> None:
        self._board = board
        self._counters = counters
        self._told: BoundedDict[str] = BoundedDict(_MAX_TOLD)

    def told(self, command_address: str, said: str) -> None:
        """Note that the device that listens on *command_address* was told *said*."""
        if len(said) <= _LONGEST:
            self._told.add(command_address, said)

    def hear(self, channel: Channel, message: MqttMessage) -> None:
        """Report what *message* on *channel* tells, if it is a word of what the device is taken for.

        To be called for a message that is not the last one over again.
        """
        ear, part = channel.decoder, channel.device.part
        if ear is None or part is None or len(message.payload) > _LONGEST:
            return
        channel.last_payload = message.payload
        told = ear.decode(message.payload)
        if told:
            told = self._meant(message.payload, told, part, channel.device.command_address)
            readings = tuple(Reading(part=part.id, capability=name, value=Value.of(one)) for name, one in told.items())
            self._counters.reports += 1
            key, address = channel.device.key, message.topic
            self._board.publish_report(key, readings, address, _stream(channel), retained=message.retain)

    def forget(self, channel: Channel) -> None:
        """Keep nothing of *channel* for late joiners any more."""
        if channel.device.part is not None:
            self._board.dispose(_stream(channel))

    def _meant(self, payload: bytes, told: Decoded, part: Part, command_address: str) -> Decoded:
        said = self._told.get(command_address)
        if said is None or said.encode(errors="replace") != payload:
            return told
        self._told.remove(command_address)
        try:
            name, value = decode_command(said, part)
        except RefusedError:
            return told
        return told if name in told else {name: value}


def _stream(channel: Channel) -> str:
    return f"{channel.device.key} {channel.device.address}"
