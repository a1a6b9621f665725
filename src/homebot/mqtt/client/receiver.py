"""The received messages of any client: read, counted, stored until they are received, and acknowledged."""

import asyncio
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, final

from homebot.clock import Clock
from homebot.errors import LinkError, RefusedError
from homebot.log import LogLimit
from homebot.mqtt.client.login import SessionGrant
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import PacketError, ProtocolVersion
from homebot.mqtt.packets.publish import decode_publish
from homebot.support.counters import loss
from homebot.support.logger import get_logger

_PUBACK = b"\x40\x02"
_PUBREC = b"\x50\x02"
_PUBCOMP = b"\x70\x02"

_new = tuple.__new__  # makes a named tuple in half the time of its constructor
_log = get_logger()


class Frame(NamedTuple):
    """A control packet before decoding.

    Attributes:
        first: First byte: type in the upper four bits, flags in the lower.
        body: Everything after the fixed header; only the first 65,539 bytes of a packet over the limit.
        oversize: Length of the body if it is over the limit, else 0.
    """

    first: int
    body: bytes
    oversize: int = 0

    def packet_id(self) -> int:
        """Return the packet identifier of a PUBLISH, even if it is cut or invalid; 0 if it cannot be read."""
        if not self.first & 0x06:
            return 0
        start = 2 + int.from_bytes(self.body[:2], "big")
        raw = self.body[start : start + 2]
        return int.from_bytes(raw, "big") if len(raw) == 2 else 0


@dataclass(slots=True)
class MqttCounters:
    """Counters of one client, over all its links.

    Attributes:
        retained: Those of the received ones that the broker had stored and sent for a new subscription.
        dropped_overflow: Messages of QoS 0 dropped because the inbox was full.
        dropped_oversize: Packets dropped because they were larger than the limit.
    """

    received: int = 0
    retained: int = 0
    dropped_overflow: int = loss()
    dropped_oversize: int = loss()
    dropped_malformed: int = loss()


@final
class Receiver:
    """The receiving half of a client, over all its links.

    Args:
        clock: Limits the log lines about dropped messages.
    """

    def __init__(self, options: MqttOptions, clock: Clock) -> None:
        self._options = options
        self._limit = LogLimit(clock)
        self._ledger = DeliveryLedger()
        self._inbox = Inbox(options.inbox_messages, options.inbox_bytes)
        self._version = ProtocolVersion.V5
        self._read: list[MqttMessage] = []
        self.counters = MqttCounters()
        self.receive = self._inbox.receive
        self._write_acknowledgements: Callable[[bytes], object] | None = None  # on the current link

    def begin_link(self, session: SessionGrant, write_acknowledgements: Callable[[bytes], object]) -> None:
        """Begin a link, on which acknowledgements are sent by *write_acknowledgements*."""
        self._write_acknowledgements = write_acknowledgements
        self._ledger.begin_link(resumed=session.resumed)
        self._inbox.reopen(resumed=session.resumed)
        self._version = ProtocolVersion.V5 if session.protocol == "5" else ProtocolVersion.V311

    def end_link(self, reason: LinkError | RefusedError) -> None:
        """End a link: no more messages come before the next one."""
        self._write_acknowledgements = None
        self._inbox.end(reason)

    def publish(self, packet: Frame) -> bytes:
        """Handle a PUBLISH for the next :meth:`deliver`; return the response, usually empty. Never raises."""
        first, body, oversize = packet
        if oversize:
            self.counters.dropped_oversize += 1
            return self._drop(packet, f"{oversize} bytes, over the limit")
        try:  # without its flag DUP, which is wrong but harmless for QoS 0
            topic, payload, qos, retain, _, packet_id, properties = decode_publish(
                first & 7, body, 0, len(body), self._version
            )
        except PacketError as error:
            return self._drop_malformed(packet, error.problem)
        if not topic:
            return self._drop_malformed(packet, "its topic is an alias, which was not allowed")
        receipt, answer = 0, b""
        if packet_id is not None:
            admitted, answer = self._ledger.admit(qos, packet_id)
            if admitted is None:
                return answer
            receipt = admitted
        if retain:
            self.counters.retained += 1
        self._read.append(_new(MqttMessage, (topic, payload, qos, retain, properties, receipt)))
        return answer

    def deliver(self) -> None:
        """Make the messages available; called once for all packets received together."""
        if not self._read:
            return
        read, self._read = self._read, []
        self._inbox.put(*read)
        self.counters.received += len(read)
        if self._inbox.dropped != self.counters.dropped_overflow:
            self.counters.dropped_overflow = self._inbox.dropped
            self._say("the inbox is full; the oldest messages of QoS 0 are dropped")

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        """Acknowledge these messages to the broker.

        Ignores those of QoS 0, and those of an earlier link, which the broker sends again if it still has them.
        """
        data = self._ledger.settle(messages)
        if data and self._write_acknowledgements is not None:
            self._write_acknowledgements(data)

    def release(self, packet: Frame) -> bytes:
        """Handle a PUBREL; return the answer."""
        return self._ledger.release(int.from_bytes(packet.body[:2], "big"))

    def _drop_malformed(self, packet: Frame, problem: str) -> bytes:
        self.counters.dropped_malformed += 1
        return self._drop(packet, problem)

    def _drop(self, packet: Frame, problem: str) -> bytes:
        self._say(problem, start=packet.body[:64].hex())
        qos, packet_id = packet.first >> 1 & 3, packet.packet_id()
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


@final
class Inbox:
    """The bounded store between the link and the receiving task: only `receive` waits.

    Messages of QoS 0 are bounded in number and bytes; the oldest are dropped first. Messages of QoS 1 and 2 are never
    dropped here: the broker holds back further ones until some are acknowledged.

    Args:
        max_messages: Most messages of QoS 0.
        max_bytes: Most bytes of such messages, topics and payloads; a single message may exceed it.
    """

    def __init__(self, max_messages: int, max_bytes: int) -> None:
        self._max_messages = max_messages
        self._max_bytes = max_bytes
        self._messages: deque[MqttMessage] = deque()
        self._droppable = 0
        self._droppable_bytes = 0
        self._ended: LinkError | RefusedError | None = LinkError("not connected yet")
        self._wake: asyncio.Future[None] | None = None
        self.dropped = 0

    def put(self, *messages: MqttMessage) -> None:
        """Add messages, making room if necessary, and wake the reader."""
        self._messages.extend(messages)
        count = size = 0
        for topic, payload, qos, _, _, _ in messages:
            if qos == 0:
                count += 1
                size += len(topic) + len(payload)
        self._droppable += count
        self._droppable_bytes += size
        while self._droppable > 1 and (self._droppable > self._max_messages or self._droppable_bytes > self._max_bytes):
            index = next(index for index, message in enumerate(self._messages) if message.qos == 0)
            self._droppable -= 1
            self._droppable_bytes -= len(self._messages[index].topic) + len(self._messages[index].payload)
            del self._messages[index]
            self.dropped += 1
        wake, self._wake = self._wake, None
        if wake is not None and not wake.done():  # its task may be cancelled
            wake.set_result(None)

    async def receive(self) -> list[MqttMessage]:
        """Return all messages, oldest first; wait for the first.

        Raises:
            LinkError: The store is empty, and stays so until `reopen`.
        """
        while not self._messages:
            if self._ended is not None:
                raise LinkError(f"no more messages: {self._ended}") from self._ended
            self._wake = asyncio.get_running_loop().create_future()
            await self._wake
        taken = list(self._messages)
        self._messages.clear()
        self._droppable = self._droppable_bytes = 0
        return taken

    def end(self, reason: LinkError | RefusedError) -> None:
        """End for *reason*; stored messages can still be received."""
        self._ended = reason
        self.put()

    def reopen(self, *, resumed: bool) -> None:
        """Reopen; in a *resumed* session the broker repeats the stored messages of QoS 1."""
        self._ended = None
        if resumed:
            self._messages = deque(message for message in self._messages if message.qos != 1)


@final
class DeliveryLedger:
    """The acknowledgements of received messages, over all links of one client. Pure.

    QoS 1: PUBACK is sent when the message is settled, only on the link of the message, because on a later link its
    packet identifier may belong to another message.

    QoS 2: PUBREC is sent when the message is settled; until PUBREL the identifier is remembered for the session, so
    that a repeated PUBLISH is answered but not delivered again (method B of MQTT 5.0, section 4.3.3). A process that
    dies before that gets the message again.
    """

    def __init__(self) -> None:
        self._link = 0
        self._session = 0
        self._recorded: dict[int, bool] = {}  # open QoS 2 identifiers; True once settled

    def begin_link(self, *, resumed: bool) -> None:
        """Begin a new link; *resumed* is whether the broker still has the session."""
        self._link += 1
        if not resumed:
            self._session += 1
            self._recorded.clear()

    def admit(self, qos: int, packet_id: int) -> tuple[int | None, bytes]:
        """Record a received PUBLISH of QoS 1 or 2.

        Returns:
            The receipt for its delivery, or None for a repetition that must not be delivered; and the bytes to answer
            at once, usually empty.
        """
        if qos == 1:
            return self._link << 16 | packet_id, b""
        if packet_id in self._recorded:
            return None, _packet(_PUBREC, packet_id) if self._recorded[packet_id] else b""
        self._recorded[packet_id] = False
        return self._session << 16 | packet_id, b""

    def settle(self, messages: Iterable[MqttMessage]) -> bytes:
        """Return the acknowledgements for *messages*; expired receipts are skipped."""
        out = bytearray()
        for message in messages:
            if message.qos == 1:
                if message.receipt >> 16 == self._link:
                    out += _packet(_PUBACK, message.receipt & 0xFFFF)
            elif message.qos == 2 and message.receipt >> 16 == self._session:
                out += self._record(message.receipt & 0xFFFF)
        return bytes(out)

    def refuse(self, qos: int, packet_id: int) -> bytes:
        """Return the acknowledgement of a permanently dropped message, so that it is not repeated."""
        if qos == 1:
            return _packet(_PUBACK, packet_id)
        self._recorded[packet_id] = True
        return _packet(_PUBREC, packet_id)

    def release(self, packet_id: int) -> bytes:
        """Return the answer to a PUBREL, even for an unknown identifier, which the broker would repeat forever."""
        self._recorded.pop(packet_id, None)
        return _packet(_PUBCOMP, packet_id)

    def _record(self, packet_id: int) -> bytes:
        if self._recorded.get(packet_id, True):
            return b""
        self._recorded[packet_id] = True
        return _packet(_PUBREC, packet_id)


def _packet(head: bytes, packet_id: int) -> bytes:
    return head + packet_id.to_bytes(2, "big")
