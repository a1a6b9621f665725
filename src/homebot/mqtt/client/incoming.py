"""The receiving half of a client, pure: a byte stream is cut into packets.

A bad packet must cost no more than itself: one over the size limit is skipped without being stored, and the packet
identifier of a malformed PUBLISH is read where it can be, so that it is acknowledged and does not come back for ever.
"""

from __future__ import annotations

from typing import NamedTuple, final

from homebot.errors import WireError

__all__ = ["Frame", "FrameReader"]

_HEAD = 2 + 65_535 + 2
"""Longest topic and packet identifier at the start of a PUBLISH: the kept part of an oversized one."""

_new = tuple.__new__
"""Makes a named tuple in half the time that its own call takes."""


class Frame(NamedTuple):
    """One control packet as it came, not yet understood.

    Attributes:
        first: First byte: type in the upper four bits, flags in the lower.
        body: Everything behind the fixed header; of a packet over the limit only the first 65,539 bytes.
        oversize: Length of the body if it is over the limit, else 0.
    """

    first: int
    body: bytes
    oversize: int = 0

    def packet_id(self) -> int:
        """Return the packet identifier of a PUBLISH, also of a cut or invalid one; 0 if it cannot be read."""
        if not self.first & 0x06:
            return 0
        start = 2 + int.from_bytes(self.body[:2], "big")
        raw = self.body[start : start + 2]
        return int.from_bytes(raw, "big") if len(raw) == 2 else 0


@final
class FrameReader:
    """Cuts a byte stream into packets; holds at most one incomplete packet within the limit.

    Args:
        maximum: Largest whole packet to keep, in bytes.

    Source: MQTT Version 5.0, section 2.1.
    """

    def __init__(self, maximum: int) -> None:
        self._maximum = maximum
        self._rest = bytearray()  # grows in place: copying a long packet for each of its pieces takes seconds
        self._needed = 0  # how long it has to be before a look at it is worth while
        self._skipping: Frame | None = None
        self._skip = 0

    def feed(self, data: bytes) -> list[Frame]:
        """Return the packets that *data* completes.

        Raises:
            WireError: A length has more than four bytes; the stream cannot be followed any further.
        """
        packets: list[Frame] = []
        if self._skipping is not None:
            data = self._skip_over(data, packets)
        buffer = data
        if self._rest:
            self._rest += data
            if len(self._rest) < self._needed:
                return packets
            buffer = bytes(self._rest)
        position, size, self._needed = 0, len(buffer), 0
        while size - position >= 2:
            length = buffer[position + 1]
            start = position + 2
            if length > 0x7F:
                read = _read_length(buffer, position + 1)
                if read is None:
                    break
                length, start = read
            end = start + length
            if end - position > self._maximum:
                position = self._start_skipping(buffer, position, start, length, packets)
                continue
            if end > size:
                self._needed = end - position
                break
            packets.append(_new(Frame, (buffer[position], buffer[start:end], 0)))
            position = end
        if self._rest or position < size:
            self._rest = bytearray(buffer[position:])
        return packets

    def _start_skipping(self, buffer: bytes, position: int, start: int, length: int, done: list[Frame]) -> int:
        self._skipping = Frame(buffer[position], b"", length)
        self._skip = length
        return len(buffer) - len(self._skip_over(buffer[start:], done))

    def _skip_over(self, data: bytes, done: list[Frame]) -> bytes:
        packet = self._skipping
        assert packet is not None  # noqa: S101 - private; the caller looked
        head = packet.body + data[: min(_HEAD - len(packet.body), self._skip)]
        self._skipping = packet._replace(body=head)
        skipped = min(len(data), self._skip)
        self._skip -= skipped
        if self._skip == 0:
            done.append(self._skipping)
            self._skipping = None
        return data[skipped:]


def _read_length(buffer: bytes, position: int) -> tuple[int, int] | None:
    """Return value and end of a variable byte integer; None while it is incomplete."""
    value = 0
    for index, byte in enumerate(buffer[position : position + 4]):
        value |= (byte & 0x7F) << (7 * index)
        if byte < 0x80:
            return value, position + index + 1
    if len(buffer) - position >= 4:
        raise WireError("a packet length of more than four bytes", buffer[position - 1 : position + 4])
    return None
