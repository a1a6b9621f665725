"""What devices of a topic layout say in plain words, as reports for the graph."""

from __future__ import annotations

from homebot.devices.report import Reading
from homebot.devices.value import Value
from homebot.devices.words import heard
from homebot.gateways.mqtt.board import Board
from homebot.gateways.mqtt.channels import Channel
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.mqtt.message import MqttMessage

__all__ = ["PlainVoices"]

_LONGEST = 1000
"""Bytes of a payload that may be a word."""


class PlainVoices:
    """Reads words.

    Args:
        board: Where it is told.
        counters: Of the gateway.
    """

    def __init__(self, board: Board, counters: GatewayCounters) -> None:
        self._board = board
        self._counters = counters

    def hear(self, channel: Channel, message: MqttMessage) -> None:
        """Report what *message* on *channel* tells, if it is a word of what the device is taken for.

        To be called for a message that is not the last one over again.
        """
        part = channel.device.part
        if part is None or len(message.payload) > _LONGEST:
            return
        channel.said = message.payload
        try:
            told = heard(message.payload.decode(), part)
        except UnicodeDecodeError:
            return
        if told:
            readings = tuple(Reading(part=part.id, capability=name, value=Value.of(one)) for name, one in told.items())
            self._counters.reports += 1
            key, address = channel.device.key, message.topic
            self._board.report(key, readings, address, _stream(channel), retained=message.retain)

    def forget(self, channel: Channel) -> None:
        """Keep nothing of *channel* for late joiners any more."""
        if channel.device.part is not None:
            self._board.drop(_stream(channel))


def _stream(channel: Channel) -> str:
    return f"{channel.device.key} {channel.device.address}"
