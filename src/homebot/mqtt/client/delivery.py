"""Ledger of the acknowledgements of received messages, pure.

QoS 1: PUBACK is sent when the message is settled, and only on the link it came by, because on a later link its packet
identifier may stand for another message.

QoS 2: PUBREC is sent when the message is settled; until PUBREL the identifier is remembered for the whole session, so
that a repeated PUBLISH is answered and not delivered again (method B of MQTT Version 5.0, section 4.3.3). A process
that dies before it settled gets the message again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from homebot.mqtt.message import MqttMessage

__all__ = ["DeliveryLedger"]

_PUBACK = b"\x40\x02"
_PUBREC = b"\x50\x02"
_PUBCOMP = b"\x70\x02"


@final
class DeliveryLedger:
    """The books of one client over all its links."""

    def __init__(self) -> None:
        self._link = 0
        self._session = 0
        self._recorded: dict[int, bool] = {}  # open QoS 2 identifiers; True once settled

    def begin_link(self, *, resumed: bool) -> None:
        """A new link; *resumed* says whether the broker still has the session."""
        self._link += 1
        if not resumed:
            self._session += 1
            self._recorded.clear()

    def admit(self, qos: int, packet_id: int) -> tuple[int | None, bytes]:
        """Enter an arriving PUBLISH of QoS 1 or 2.

        Returns:
            The receipt to deliver it with, or None for a repetition that must not be delivered; and the bytes to
            answer at once, mostly none.
        """
        if qos == 1:
            return self._link << 16 | packet_id, b""
        if packet_id in self._recorded:
            return None, _packet(_PUBREC, packet_id) if self._recorded[packet_id] else b""
        self._recorded[packet_id] = False
        return self._session << 16 | packet_id, b""

    def settle(self, messages: Iterable[MqttMessage]) -> bytes:
        """The acknowledgements to send for *messages*; what cannot be acknowledged any more is passed over."""
        out = bytearray()
        for message in messages:
            if message.qos == 1:
                if message.receipt >> 16 == self._link:
                    out += _packet(_PUBACK, message.receipt & 0xFFFF)
            elif message.qos == 2 and message.receipt >> 16 == self._session:
                out += self._record(message.receipt & 0xFFFF)
        return bytes(out)

    def refuse(self, qos: int, packet_id: int) -> bytes:
        """The acknowledgement of a message that was dropped for good, so that it does not come again."""
        if qos == 1:
            return _packet(_PUBACK, packet_id)
        self._recorded[packet_id] = True
        return _packet(_PUBREC, packet_id)

    def release(self, packet_id: int) -> bytes:
        """The answer to a PUBREL; also to one for an unknown identifier, or the broker would ask for ever."""
        self._recorded.pop(packet_id, None)
        return _packet(_PUBCOMP, packet_id)

    def _record(self, packet_id: int) -> bytes:
        if self._recorded.get(packet_id, True):
            return b""
        self._recorded[packet_id] = True
        return _packet(_PUBREC, packet_id)


def _packet(head: bytes, packet_id: int) -> bytes:
    return head + packet_id.to_bytes(2, "big")
