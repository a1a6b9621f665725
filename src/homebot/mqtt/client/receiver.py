"""Treatment of received packets, the same for every adapter: read, count, record, put in the inbox."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from homebot.clock import Clock
from homebot.errors import LinkError, RefusedError, WireError
from homebot.log import LogLimit
from homebot.logger import get_logger
from homebot.mqtt.client.delivery import DeliveryLedger
from homebot.mqtt.client.inbox import Inbox
from homebot.mqtt.client.incoming import Frame, PublishReader
from homebot.mqtt.client.port import MqttCounters, SessionGrant
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions

__all__ = ["Receiver"]

_log = get_logger()


@final
class Receiver:
    """The receiving half of a client, over all its links.

    Args:
        options: The limits.
        clock: Paces the log lines about dropped messages: somebody else decides how many there are.

    Attributes:
        counters: What happened since this was made.
    """

    def __init__(self, options: MqttOptions, clock: Clock) -> None:
        self._options = options
        self._limit = LogLimit(clock)
        self._ledger = DeliveryLedger()
        self._inbox = Inbox(options.inbox_messages, options.inbox_bytes)
        self._reader = PublishReader(has_properties=True)
        self.counters = MqttCounters()

    def begin_link(self, session: SessionGrant) -> None:
        """Messages of a new link follow."""
        self._ledger.begin_link(resumed=session.resumed)
        self._inbox.reopen(resumed=session.resumed)
        self._reader = PublishReader(has_properties=session.protocol == "5")

    def end_link(self, reason: LinkError | RefusedError) -> None:
        """No more messages before the next link."""
        self._inbox.end(reason)

    def publish(self, packet: Frame) -> bytes:
        """Take in one PUBLISH; returns what has to be answered at once, mostly nothing. Never raises."""
        qos = packet.first >> 1 & 3
        receipt: int | None = 0
        answer = b""
        if packet.oversize:
            self.counters.dropped_oversize += 1
            return self._drop(packet, f"{packet.oversize} bytes, over the limit")
        if qos:
            packet_id = self._reader.packet_id(packet)
            if packet_id == 0 or qos == 3:
                self.counters.dropped_malformed += 1
                return self._drop(packet, "QoS 3, or no packet identifier")
            receipt, answer = self._ledger.admit(qos, packet_id)
            if receipt is None:
                return answer
        try:
            message = self._reader.read(packet, receipt or 0)
        except WireError as error:
            self.counters.dropped_malformed += 1
            return self._drop(packet, error.problem)
        self.accept(message)
        return answer

    def accept(self, message: MqttMessage) -> None:
        """Take in one message that is understood already; dropped are the oldest of QoS 0 where too many wait."""
        self._inbox.put(message)
        self.counters.received += 1
        if self._inbox.dropped != self.counters.dropped_overflow:
            self.counters.dropped_overflow = self._inbox.dropped
            self._say("the inbox is full; the oldest messages of QoS 0 go")

    def note_oversize(self, size: int) -> None:
        """Count a message that was dropped because it was larger than the limit."""
        self.counters.dropped_oversize += 1
        self._say(f"{size} bytes, over the limit")

    def note_malformed(self, problem: str) -> None:
        """Count a message that was dropped because it did not follow the protocol."""
        self.counters.dropped_malformed += 1
        self._say(problem)

    def release(self, packet: Frame) -> bytes:
        """Take in one PUBREL; returns the answer."""
        return self._ledger.release(int.from_bytes(packet.body[:2], "big"))

    def settle(self, messages: Iterable[MqttMessage]) -> bytes:
        """The acknowledgements to send for *messages*."""
        return self._ledger.settle(messages)

    async def take(self) -> list[MqttMessage]:
        """All messages that are there; see `Inbox.take`."""
        return await self._inbox.take()

    def _drop(self, packet: Frame, problem: str) -> bytes:
        self._say(problem, start=packet.body[:64].hex())
        qos, packet_id = packet.first >> 1 & 3, self._reader.packet_id(packet)
        return self._ledger.refuse(qos, packet_id) if qos in {1, 2} and packet_id else b""

    def _say(self, reason: str, **facts: str) -> None:
        if self._limit.allows("dropped") is None:
            return
        _log.warning(
            "mqtt.messages_dropped",
            message=f"{self._options.url}: messages were dropped, the last one because: {reason}",
            broker=self._options.url,
            reason=reason,
            malformed=self.counters.dropped_malformed,
            oversize=self.counters.dropped_oversize,
            overflow=self.counters.dropped_overflow,
            **facts,
        )
