"""The messages sent to one client at QoS 1 and 2, until it has acknowledged them. No I/O.

A message is *in flight* from when it is written until then; their number is bounded by the client's Receive Maximum.
When the client resumes its session, everything in flight is sent again in the original order.
"""

from collections import deque
from collections.abc import Callable
from typing import Final, final

from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.queue import QueuedMessage
from homebot.mqtt.packets import PacketError, Pubrel, ReasonCode

_SMALL: Final = 1024  # bytes; smaller messages are not counted, because there are few


@final
class InFlight:
    """The messages that one client has not acknowledged.

    Attributes:
        messages: By packet id; None after PUBREC. Read-only, like the other attributes.
        size: The bytes of the large messages.
    """

    __slots__ = ("_count_bytes", "_last_id", "messages", "resend", "settled", "size", "window")

    def __init__(self, window: int, count: Callable[[int], None]) -> None:
        self.messages: dict[int, QueuedMessage | None] = {}
        self.resend: deque[int] = deque()
        self.window = window
        self.size = 0
        self.settled = 0
        self._count_bytes = count
        self._last_id = 0

    @property
    def full(self) -> bool:
        """True if nothing more can be sent until the client acknowledges something."""
        return len(self.messages) >= self.window

    def send(self, outbound: Outbound, queued: QueuedMessage) -> None:
        """Send a message with a new packet id; there must be room for it."""
        packet_id = self._last_id
        while True:
            packet_id = packet_id % 65_535 + 1
            if packet_id not in self.messages:
                break
        self._last_id = packet_id
        if outbound.publish(queued, packet_id):
            self.messages[packet_id] = queued
            if queued[0].size > _SMALL:
                self._count(queued, 1)

    def send_again(self, outbound: Outbound) -> None:
        """Send the next message that has to be repeated."""
        packet_id = self.resend.popleft()
        queued = self.messages[packet_id]
        if queued is not None and not outbound.publish(queued, packet_id, dup=True):
            del self.messages[packet_id]
            self._count(queued, -1)

    def resume(self, outbound: Outbound, window: int) -> None:
        """Repeat PUBREL to the connected client, and mark the other messages for repetition."""
        self.window = window
        self.resend.clear()
        for packet_id, queued in self.messages.items():
            if queued is None:
                outbound.send(Pubrel(packet_id))
            else:
                self.resend.append(packet_id)

    def acknowledged(self, packet_id: int) -> None:
        """Handle a PUBACK.

        Raises:
            PacketError: 0x82, the message was not sent at QoS 1.
        """
        if packet_id not in self.messages:
            return
        queued = self.messages[packet_id]
        if queued is None or queued[1] != 1:
            raise PacketError("PUBACK for a message at QoS 2", code=ReasonCode.PROTOCOL_ERROR)
        del self.messages[packet_id]
        self.settled += 1
        if queued[0].size > _SMALL:
            self._count(queued, -1)
        if self.resend:
            self._cancel_resend(packet_id)

    def received(self, packet_id: int, reason: ReasonCode) -> ReasonCode:
        """Handle a PUBREC; return the reason for PUBREL: 0, or 0x92 for an unknown id.

        Raises:
            PacketError: 0x82, the message was not sent at QoS 2.
        """
        if packet_id not in self.messages:
            return ReasonCode.PACKET_IDENTIFIER_NOT_FOUND
        queued = self.messages[packet_id]
        if queued is not None and queued.qos != 2:
            raise PacketError("PUBREC for a message at QoS 1", code=ReasonCode.PROTOCOL_ERROR)
        if reason.failed:
            self.completed(packet_id)
        else:
            self.messages[packet_id] = None
            if queued is not None:
                self._count(queued, -1)
            self._cancel_resend(packet_id)
        return ReasonCode.SUCCESS

    def completed(self, packet_id: int) -> None:
        """Handle a PUBCOMP, or a PUBREC that ends the exchange."""
        if packet_id in self.messages:
            self.settled += 1
            queued = self.messages.pop(packet_id)
            if queued is not None:
                self._count(queued, -1)
            self._cancel_resend(packet_id)

    def clear(self) -> list[QueuedMessage]:
        """Remove and return all messages that the client has not received."""
        messages = [message for message in self.messages.values() if message is not None]
        for queued in messages:
            self._count(queued, -1)
        self.messages.clear()
        self.resend.clear()
        return messages

    def _count(self, queued: QueuedMessage, sign: int) -> None:
        message = queued.message
        if message.size > _SMALL:
            self.size += sign * message.size
            (message.hold if sign > 0 else message.release)(self._count_bytes)

    def _cancel_resend(self, packet_id: int) -> None:
        if packet_id in self.resend:  # it was answered before its repetition
            self.resend.remove(packet_id)
