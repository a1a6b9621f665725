"""Sits between the broker's sockets and its peers: writes the packet log and lets faults happen."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, final

from homebot.mqtt.broker import BrokerState, Peer, Transport
from homebot.mqtt.packets import Connect, Packet, PacketError, PacketReader, PacketType, ProtocolVersion, ReasonCode
from homebot.mqtt.packets.primitives import Cursor
from homebot.testing.mqtt.faults import Fault, FaultKind, FaultRules

_ACKS = (PacketType.PUBACK, PacketType.PUBREC, PacketType.PUBCOMP)


@dataclass(frozen=True, slots=True)
class TapDuties:
    """The state that every tap of one broker shares.

    Attributes:
        failed: Called with each connection ended by a violation of its client: client, text; not after injected faults.
        taps: Those of the connections that are open; they add and remove themselves.
    """

    rules: FaultRules
    record: Callable[[Literal["in", "out", "note"], str, Packet | str], None]
    failed: Callable[[str, PacketError], None]
    taps: set[Tap]


@final
class Tap:
    """One connection: an :class:`ConnectionHandler` for its carrier, and the :class:`Transport` of its peer.

    The bytes for a slow reader are bounded by ``limits.write_buffer``; beyond it the connection is closed.
    """

    def __init__(self, duties: TapDuties, state: BrokerState, link: Transport) -> None:
        self._duties = duties
        self._link = link
        self._limit = state.limits.write_buffer
        self._held = bytearray()
        self._cut = self._begun = self._fault_hit = self._reported = False
        self._in: PacketReader | None = PacketReader(ProtocolVersion.V311, state.limits.max_packet_size)
        self._version = ProtocolVersion.V311
        self._name = ""  # as the client gave it
        self._peer = Peer(state, self)
        duties.taps.add(self)

    @property
    def client_id(self) -> str | None:
        """Client id, once logged in."""
        return self._peer.client_id

    @property
    def client_text(self) -> str:
        """Name of the client in the log."""
        return self._peer.client_text

    @property
    def address(self) -> str:
        """The far side's address."""
        return self._link.address

    @property
    def write_blocked(self) -> bool:
        """True if nothing more should be written that can wait."""
        return self._stalled or self._link.write_blocked

    def receive(self, data: bytes) -> None:
        """Record received bytes and pass them on."""
        if self._in is not None and not self._begun and data[0] >> 4 != PacketType.CONNECT:
            self._in = None
            self._record("note", f"sent invalid MQTT: {data[:40]!r}")
        self._begun = True
        if self._in is not None:
            self._read(self._in, data)
        self._peer.receive(data)

    def writable(self) -> None:
        """Go on writing: the socket takes bytes again."""
        if not self._stalled:
            self._peer.writable()

    def lost(self) -> None:
        """Note that the socket is closed."""
        self._record("note", "connection closed")
        self._duties.taps.discard(self)
        self._peer.lost()
        self._report_failure()

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side."""
        self._peer.end(reason, publish_will=publish_will)

    def drop(self) -> None:
        """Close the connection without a DISCONNECT."""
        self._record("note", "fault: connection dropped")
        self._cut = True
        self._link.close(linger=False)

    def unstall(self) -> None:
        """Write the queued bytes to a reader that is fast again."""
        if self._stalled:
            return
        self._flush()
        if not self._link.write_blocked:
            self._peer.writable()

    def write(self, data: bytes) -> None:
        """Write all bytes that the active faults let through."""
        for piece in _split(data):
            if self._cut:
                return
            self._write_packet(piece)

    def pause_reading(self) -> None:
        """Take no more bytes from the client."""
        self._link.pause_reading()

    def resume_reading(self) -> None:
        """Take bytes again."""
        self._link.resume_reading()

    def close(self, *, linger: bool) -> None:
        """Send all written bytes, then close."""
        self._report_failure()  # first: a reader of the reason may ask for it at once
        self._flush()
        self._link.close(linger=linger)

    @property
    def _display_name(self) -> str:
        return self.client_id or self._name or self.address

    @property
    def _stalled(self) -> bool:
        return self._duties.rules.find(FaultKind.SLOW_READER, self.client_id) is not None

    def _read(self, reader: PacketReader, data: bytes) -> None:
        try:
            for packet in reader.feed(data):
                if isinstance(packet, Connect):
                    reader.version = self._version = packet.version
                    self._name = packet.client_id
                self._record("in", packet)
        except PacketError as error:
            self._in = None  # the peer finds the same
            self._record("note", f"sent invalid MQTT: {error.problem}")

    def _write_packet(self, piece: bytes) -> None:
        rules = self._duties.rules
        self._record("out", _read_own(piece, self._version))
        half = rules.find(FaultKind.HALF_PACKET, self.client_id)
        if half is not None:
            self._apply_fault(half)
            half.lift()
            self._put(piece[: len(piece) // 2])
            self._record("note", "fault: only half of that was sent")
            self.drop()
            return
        if piece[0] >> 4 in _ACKS:
            dropped = rules.find(FaultKind.DROPPED_ACKS, self.client_id)
            if dropped is not None:
                self._apply_fault(dropped)
                self._record("note", "fault: that acknowledgement was dropped")
                return
            delayed = rules.find(FaultKind.DELAYED_ACKS, self.client_id)
            if delayed is not None:
                self._apply_fault(delayed)
                self._record("note", f"fault: that acknowledgement is {delayed.seconds:g} s late")
                asyncio.get_running_loop().call_later(delayed.seconds, self._put, piece)
                return
        self._put(piece)

    def _put(self, piece: bytes) -> None:
        if self._cut:
            return
        slow = self._duties.rules.find(FaultKind.SLOW_READER, self.client_id)
        if slow is None and not self._held:
            self._link.write(piece)
            return
        if slow is not None:
            self._apply_fault(slow)
        self._held += piece
        if len(self._held) > self._limit:
            self._held.clear()
            self.drop()

    def _apply_fault(self, fault: Fault) -> None:
        fault.hits += 1
        self._fault_hit = True

    def _report_failure(self) -> None:
        failure = self._peer.failure
        if failure is not None and not self._fault_hit and not self._reported:
            self._reported = True
            self._duties.failed(self._display_name, failure)

    def _flush(self) -> None:
        if self._held:
            data = bytes(self._held)
            self._held.clear()
            self._link.write(data)

    def _record(self, direction: Literal["in", "out", "note"], what: Packet | str) -> None:
        self._duties.record(direction, self._display_name, what)


def _read_own(piece: bytes, version: ProtocolVersion) -> Packet | str:
    try:
        return next(PacketReader(version).feed(piece))
    except PacketError:  # the answer to a CONNECT that could not be read is in the version it seemed to have
        return f"0x{piece.hex()}"


def _split(data: bytes) -> Iterator[bytes]:
    cursor = Cursor(data)
    while (start := cursor.position) < len(data):
        cursor.position += 1
        size = cursor.varint()
        cursor.position += size
        yield data[start : cursor.position]
