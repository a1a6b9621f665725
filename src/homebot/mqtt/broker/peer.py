"""One client's connection from its beginning to its end, without a socket: login, silence, and how it is closed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from homebot.mqtt.broker import login
from homebot.mqtt.broker.client_packets import ClientPackets
from homebot.mqtt.broker.client_text import host_of
from homebot.mqtt.broker.deadlines import Deadline
from homebot.mqtt.broker.disconnect import goodbye, unread_connect_answer
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.peer_log import PeerLog
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.sessions import will_size
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.transport import Transport
from homebot.mqtt.broker.unread import UnreadMark
from homebot.mqtt.packets import (
    Connack,
    Connect,
    Packet,
    PacketError,
    PacketReader,
    ProtocolVersion,
    ReasonCode,
    Will,
    encode,
)

__all__ = ["Peer"]

_CONNECT = b"\x10"
_KEEP_ALIVE_GRACE = 1.5  # MQTT 5.0, section 3.1.2.10


@final
class Peer:
    """The state machine of one connection; nothing the client sends makes it raise.

    Args:
        hub: The broker.
        link: Where bytes go; tells this object what comes.

    Attributes:
        failure: What the client did or left undone that ended the connection; None while nothing has.
    """

    def __init__(self, hub: BrokerState, link: Transport) -> None:
        self._hub = hub
        self._link = link
        self._reader = PacketReader(ProtocolVersion.V311, hub.limits.max_connect_size)
        self._client: _Client | None = None
        self._log = PeerLog(hub, link)
        self._connect: Connect | None = None  # that has to wait
        self._retry: Deadline | None = None
        self.failure: PacketError | None = None
        self._started = False
        self._closed = False
        self._received_at = hub.clock.monotonic()
        self._silence = hub.deadlines.at(self._received_at + hub.limits.connect_timeout, self._no_connect)
        self._unread = UnreadMark(hub.unread_logins, self._give_up_unread)
        hub.waiting_logins.add(self)

    @property
    def client_id(self) -> str | None:
        """Client id, once logged in."""
        return self._log.client_id

    @property
    def address(self) -> str:
        """The far side's address."""
        return self._link.address

    @property
    def client_text(self) -> str:
        """Name of the client in the log."""
        return self._log.client_text

    @property
    def will_bytes(self) -> int:
        """The size of its will."""
        return 0 if self._client is None else will_size(self._client.will)

    def receive(self, data: bytes) -> None:
        """Bytes came from the client."""
        if self._closed or not data:
            return
        self._received_at = self._hub.clock.monotonic()
        try:
            if self._client is None:
                self._check_start(data)
                self._reader.feed(data)
                self._take_login()
            else:
                self._reader.feed(data)
                self._client.packets.take_all(self._reader)
                if self._closed:
                    return
        except PacketError as error:
            self._fail(error)
            return
        if self._reader.missing or self._unread.size or self._client is None:
            self._unread.note(self._reader.held)

    def writable(self) -> None:
        """The link is no longer choked."""
        if self._client is not None:
            self._client.session.pump()

    def lost(self) -> None:
        """The link is gone."""
        self._finish(publish_will=True)

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients are told *reason*.

        Args:
            reason: What DISCONNECT carries.
            publish_will: Whether the client's will is published.
        """
        self._close(reason, "", publish_will=publish_will)

    def make_room(self) -> None:
        """End the connection, which has not logged in, because another one needs its place."""
        self._hub.counters.logins_pushed_out += 1
        self._push_out()

    def _handle(self, packet: Packet) -> None:
        if self._client is None:
            self._login(packet)
        else:
            self._client.packets.take(packet)

    def _check_start(self, data: bytes) -> None:
        """Something else than MQTT, such as a browser, is not left waiting for the rest of a packet."""
        if not self._started and data[:1] != _CONNECT:
            raise PacketError(f"the first byte is 0x{data[0]:02x}, not that of CONNECT", code=ReasonCode.PROTOCOL_ERROR)
        self._started = True

    def _take_login(self) -> None:
        """Take the CONNECT, and what came with it unless the CONNECT has to wait."""
        while not self._closed and self._connect is None and (packet := self._reader.pop()) is not None:
            self._handle(packet)

    def _wait_to_log_in(self, packet: Connect, until: float) -> None:
        """Others of this host had wrong passwords; ``connect_timeout`` goes on."""
        self._hub.counters.logins_slowed += 1
        self._connect = packet
        self._link.pause_reading()
        self._retry = self._hub.deadlines.at(until, self._log_in_again)

    def _log_in_again(self) -> None:
        packet, self._connect = self._connect, None
        if packet is None:
            return
        self._link.resume_reading()
        try:
            self._handle(packet)
            self._take_login()
        except PacketError as error:
            self._fail(error)

    def _login(self, packet: Packet) -> None:
        if not isinstance(packet, Connect):
            raise PacketError(f"{type(packet).__name__} came before CONNECT", code=ReasonCode.PROTOCOL_ERROR)
        hub = self._hub
        self._reader.version = packet.version
        until = login.may_try_at(packet, hub, self.address)
        if until > hub.clock.monotonic():
            self._wait_to_log_in(packet, until)
            return
        self._silence.cancel()
        verdict = login.refusal(packet, hub, self.address)
        if verdict.failed:
            self._refuse(packet, verdict)
            return
        self._reader.max_packet_size = hub.limits.max_packet_size
        self._reader.max_control_size = hub.limits.max_control_size
        wanted = login.accept(packet, hub)
        other = hub.peers.get(wanted.client_id)
        if other is not None:
            other.end(ReasonCode.SESSION_TAKEN_OVER)
        session, present = hub.sessions.open(
            wanted.client_id, clean_start=packet.clean_start, host=host_of(self.address)
        )
        session.expiry = wanted.expiry
        outbound = Outbound(
            self._link,
            hub.clock,
            hub.counters,
            packet.version,
            self._log.too_large,
            wanted.max_packet_size,
            wanted.alias_maximum,
        )
        packets = ClientPackets(hub, session, outbound, self._leave, self._fail)
        self._client = _Client(wanted, session, outbound, packets, packet.will)
        self._log.client_id = wanted.client_id
        hub.peers[wanted.client_id] = self
        hub.waiting_logins.discard(self)
        self._unread.move(hub.unread)
        outbound.send(login.connack(wanted, hub, session_present=present))
        self._expect_signs_of_life()
        session.resume(outbound, wanted.receive_maximum)

    def _refuse(self, packet: Connect, reason: ReasonCode) -> None:
        self._hub.counters.connections_refused += 1
        self._log.refused(packet.client_id, reason)
        self._shut(encode(Connack(reason=reason), packet.version))

    def _expect_signs_of_life(self) -> None:
        client = self._client
        if client is None or not client.wanted.keep_alive:
            return
        limit = client.wanted.keep_alive * _KEEP_ALIVE_GRACE
        now = self._hub.clock.monotonic()
        if not client.packets.reading:  # the silence is ours
            self._received_at = now
        due = self._received_at + limit
        if due <= now:
            self._fail(PacketError("nothing came for too long", code=ReasonCode.KEEP_ALIVE_TIMEOUT))
        else:
            self._silence = self._hub.deadlines.at(due, self._expect_signs_of_life)

    def _no_connect(self) -> None:
        if self._connect is not None:
            self._refuse(self._connect, ReasonCode.QUOTA_EXCEEDED)
            return
        self._fail(PacketError("no CONNECT came", code=ReasonCode.KEEP_ALIVE_TIMEOUT))

    def _give_up_unread(self) -> None:
        self._hub.counters.unread_given_up += 1
        if self._client is None:
            self._push_out()
        else:
            self._fail(PacketError("its packet was incomplete for too long", code=ReasonCode.QUOTA_EXCEEDED))

    def _push_out(self) -> None:
        """Close without a word, because one who knows no password is not owed one, and many may have to go at once."""
        self._log.pushed_out()
        self._finish(publish_will=False)
        self._link.close(linger=False)

    def _leave(self, publish_will: bool) -> None:  # noqa: FBT001 - a callback
        """The client has sent DISCONNECT."""
        self._finish(publish_will=publish_will)
        self._link.close(linger=False)

    def _fail(self, error: PacketError) -> None:
        hub = self._hub
        hub.counters.connections_failed += 1
        self.failure = error
        self._log.failed(error)
        if self._client is None:
            self._shut(unread_connect_answer(error))
        else:
            self._close(error.code, error.problem, publish_will=True)

    def _close(self, reason: ReasonCode, reason_string: str, *, publish_will: bool) -> None:
        client = self._client
        last = b""
        if client is not None and client.outbound.version is ProtocolVersion.V5:
            wanted = client.wanted
            last = goodbye(reason, reason_string if wanted.problem_information else "", wanted.max_packet_size)
        self._shut(last, publish_will=publish_will)

    def _shut(self, last: bytes, *, publish_will: bool = False) -> None:
        if not self._closed:
            self._link.write(last)
        self._finish(publish_will=publish_will)
        self._link.close(linger=True)

    def _finish(self, *, publish_will: bool) -> None:
        if self._closed:
            return
        client = self._client
        self._closed = True
        self._hub.counters.connections_closed += 1
        self._silence.cancel()
        self._connect = None
        if self._retry is not None:
            self._retry.cancel()
        self._hub.waiting_logins.discard(self)
        self._unread.note(0)
        self._reader = _NOTHING_MORE
        if client is not None:
            error = client.packets.stop()
            if error is not None:
                self.failure = error
                self._log.failed(error)
            del self._hub.peers[client.session.client_id]
            self._hub.sessions.detach(client.session, client.will if publish_will else None)


_NOTHING_MORE = PacketReader()


@dataclass(slots=True)
class _Client:
    wanted: login.ConnectRequest
    session: BrokerSession
    outbound: Outbound
    packets: ClientPackets
    will: Will | None
