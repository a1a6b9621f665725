"""What every adapter does with received packets: read, count, keep in books, put in the inbox; knows no library."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import final

import structlog

from homebot.errors import LinkError, RefusedError, WireError
from homebot.mqtt.client import MqttCounters, Session
from homebot.mqtt.delivery import DeliveryLedger
from homebot.mqtt.inbox import Inbox
from homebot.mqtt.incoming import Packet, PublishReader
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions

__all__ = ["Receiver"]

_LOG_EVERY = 10.0
"""Seconds between two lines about dropped packets: somebody else decides how many there are."""

_log = structlog.get_logger()


@final
class Receiver:
    """The receiving half of a client, over all its links.

    Args:
        options: The limits.
        now: Seconds of a clock that never goes back.

    Attributes:
        counters: What happened since this was made.
    """

    def __init__(self, options: MqttOptions, now: Callable[[], float]) -> None:
        self._options = options
        self._now = now
        self._ledger = DeliveryLedger()
        self._inbox = Inbox(options.inbox_messages, options.inbox_bytes)
        self._reader = PublishReader(has_properties=True)
        self._quiet_until = float("-inf")
        self.counters = MqttCounters()

    def begin_link(self, session: Session) -> None:
        """Messages of a new link follow."""
        self._ledger.begin_link(resumed=session.resumed)
        self._inbox.reopen(resumed=session.resumed)
        self._reader = PublishReader(has_properties=session.protocol == "5")

    def end_link(self, reason: LinkError | RefusedError) -> None:
        """No more messages before the next link."""
        self._inbox.end(reason)

    def publish(self, packet: Packet) -> bytes:
        """Take in one PUBLISH; returns what has to be answered at once, mostly nothing. Never raises."""
        qos = packet.first >> 1 & 3
        receipt: int | None = 0
        answer = b""
        if packet.oversize:
            self.counters.dropped_oversize += 1
            return self._drop(packet, f"{packet.oversize} bytes, over the limit")
        if qos:
            receipt, answer = self._ledger.admit(qos, self._reader.packet_id(packet))
            if receipt is None:
                return answer
        try:
            message = self._reader.read(packet, receipt or 0)
        except WireError as error:
            self.counters.dropped_malformed += 1
            return self._drop(packet, error.problem)
        self._inbox.put(message)
        self.counters.received += 1
        if self._inbox.dropped != self.counters.dropped_overflow:
            self.counters.dropped_overflow = self._inbox.dropped
            self._say("the inbox is full; the oldest messages of QoS 0 go")
        return answer

    def release(self, packet: Packet) -> bytes:
        """Take in one PUBREL; returns the answer."""
        return self._ledger.release(int.from_bytes(packet.body[:2], "big"))

    def settle(self, messages: Iterable[MqttMessage]) -> bytes:
        """The acknowledgements to send for *messages*."""
        return self._ledger.settle(messages)

    async def take(self) -> list[MqttMessage]:
        """All messages that are there; see `Inbox.take`."""
        return await self._inbox.take()

    def _drop(self, packet: Packet, problem: str) -> bytes:
        self._say(problem, start=packet.body[:64].hex())
        qos, packet_id = packet.first >> 1 & 3, self._reader.packet_id(packet)
        return self._ledger.refuse(qos, packet_id) if qos in {1, 2} and packet_id else b""

    def _say(self, reason: str, **facts: str) -> None:
        now = self._now()
        if now < self._quiet_until:
            return
        self._quiet_until = now + _LOG_EVERY
        _log.warning(
            "mqtt.messages_dropped",
            broker=self._options.url,
            reason=reason,
            malformed=self.counters.dropped_malformed,
            oversize=self.counters.dropped_oversize,
            overflow=self.counters.dropped_overflow,
            **facts,
        )
