"""The connection of one client from login to close. No I/O."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from homebot.mqtt.broker import login
from homebot.mqtt.broker.authentication import host_of
from homebot.mqtt.broker.client_packets import ClientPackets
from homebot.mqtt.broker.deadlines import Deadline
from homebot.mqtt.broker.outbound import Outbound, goodbye, unread_connect_answer
from homebot.mqtt.broker.ports import ConnectedClient, Transport
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.sessions import will_size
from homebot.mqtt.broker.state import BrokerState, short
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

_CONNECT = b"\x10"
_MAX_DEFERRED = 16 * 1024  # bytes waiting for a later turn
_CUT_BY_A_READ = 4096  # bytes: one read may leave about that much of a packet
_KEEP_ALIVE_GRACE = 1.5  # MQTT 5.0, section 3.1.2.10


@final
class Peer:
    """The state machine of one connection; it never raises because of a client's packets.

    Args:
        link: The transport for outgoing bytes; it passes on incoming ones.

    Attributes:
        client_id: The client id, once logged in.
        unread: The bytes of an incomplete packet.
        failure: The client's error that ended the connection, or None.
    """

    def __init__(self, state: BrokerState, link: Transport) -> None:
        self._state = state
        self._link = link
        self._reader = PacketReader(ProtocolVersion.V311, state.limits.max_connect_size)
        self._client: _Client | None = None
        self.client_id: str | None = None
        self._connect: Connect | None = None  # that has to wait
        self._retry: Deadline | None = None
        self._newcomer: ConnectedClient | None = None  # that takes over when all is done
        self.failure: PacketError | None = None
        self._started = False
        self._closed = False
        self._is_deferred = self._is_lost = False
        self._received_at = state.clock.monotonic()
        self._silence = state.deadlines.at(self._received_at + state.limits.connect_timeout, self._no_connect)
        self.unread = 0  # bytes of an incomplete packet, as counted
        self._unread_of_all = state.unread_logins
        state.waiting_logins.add(self)

    @property
    def address(self) -> str:
        """The peer's address."""
        return self._link.address

    @property
    def client_text(self) -> str:
        """The name of the client in the log."""
        return _client_text(self.client_id, self.address)

    @property
    def will_bytes(self) -> int:
        """The size of its will."""
        return 0 if self._client is None else will_size(self._client.will)

    def receive(self, data: bytes) -> None:
        """Handle bytes from the client."""
        if self._closed or not data:
            return
        self._received_at = self._state.clock.monotonic()
        try:
            if self._client is None:
                # Other protocols, such as a browser's, are refused without waiting for the rest of a packet.
                if not self._started and data[:1] != _CONNECT:
                    raise PacketError(
                        f"the first byte is 0x{data[0]:02x}, not that of CONNECT", code=ReasonCode.PROTOCOL_ERROR
                    )
                self._started = True
            self._reader.feed(data)
        except PacketError as error:
            self._fail(error)
            return
        if self._is_deferred:
            if self._reader.held >= _MAX_DEFERRED:
                self._link.pause_reading()
        elif self._state.turn.has_time():
            self._go_on()
        else:
            self._defer()

    def writable(self) -> None:
        """Continue writing: the link accepts bytes again."""
        if self._client is not None:
            self._client.session.pump()

    def lost(self) -> None:
        """End after the loss of the link; received packets are handled first."""
        if self._is_deferred:
            self._is_lost = True
        else:
            self._finish(publish_will=True)

    def end(self, reason: ReasonCode, *, publish_will: bool = True) -> None:
        """Close the connection from the broker's side: MQTT 5 clients get *reason*."""
        self._close(reason, "", publish_will=publish_will)

    def make_room(self) -> None:
        """End the connection before its login, because another one needs its place."""
        self._state.counters.logins_pushed_out += 1
        self._push_out()

    def make_way(self, newcomer: ConnectedClient) -> bool:
        """End the connection in favour of *newcomer* with the same client id; False if that has to wait."""
        self.end(ReasonCode.SESSION_TAKEN_OVER)
        if self._is_gone:
            return True
        if self._newcomer is not None:
            self._newcomer.end(ReasonCode.SESSION_TAKEN_OVER)
        self._newcomer = newcomer
        return False

    def log_in(self) -> None:
        """Handle the CONNECT that was delayed."""
        packet, self._connect = self._connect, None
        if packet is None:
            return
        self._link.resume_reading()
        try:
            self._login(packet)
        except PacketError as error:
            self._fail(error)
            return
        if not self._is_deferred and not self._closed:
            self._go_on()

    def _go_on(self) -> None:
        """Handle received packets; those for which this turn has no time wait for a later one."""
        try:
            if self._client is None and self._connect is None and (packet := self._reader.pop()) is not None:
                self._login(packet)
            if self._client is not None and not self._closed and not self._client.packets.handle_all(self._reader):
                self._defer()
                return
        except PacketError as error:
            self._fail(error)
            return
        if not self._closed and (self._reader.missing or self.unread or self._client is None):
            self._count_unread(self._reader.held)

    def _defer(self) -> None:
        self._is_deferred = True
        self._state.turn.defer(self._go_on_later)

    def _go_on_later(self) -> None:
        self._is_deferred = False
        if self._closed:
            return
        self._go_on()
        if self._is_deferred or self._closed:
            return
        if self._is_lost:
            self._finish(publish_will=True)
        elif self._connect is None and (self._client is None or self._client.packets.reading):
            self._link.resume_reading()

    def _login(self, packet: Packet) -> None:
        if not isinstance(packet, Connect):
            raise PacketError(f"{type(packet).__name__} came before CONNECT", code=ReasonCode.PROTOCOL_ERROR)
        state = self._state
        self._reader.version = packet.version
        until = login.may_try_at(packet, state, self.address)
        if until > state.clock.monotonic():
            self._state.counters.logins_slowed += 1  # after wrong passwords; ``connect_timeout`` still applies
            self._connect = packet
            self._link.pause_reading()
            self._retry = self._state.deadlines.at(until, self.log_in)
            return
        self._silence.cancel()
        verdict = login.refusal(packet, state, self.address)
        if verdict.failed:
            self._refuse(packet, verdict)
        else:
            self._welcome(packet)

    def _welcome(self, packet: Connect) -> None:
        """Open the client's session, after ending a connection with the same client id."""
        state = self._state
        self._reader.max_packet_size = state.limits.max_packet_size
        self._reader.max_control_size = state.limits.max_control_size
        wanted = login.accept(packet, state)
        other = state.peers.get(wanted.client_id)
        if other is not None and not other.make_way(self):
            self._connect = packet
            self._link.pause_reading()
            return
        session, present = state.sessions.open(
            wanted.client_id, clean_start=packet.clean_start, host=host_of(self.address)
        )
        session.expiry = wanted.expiry
        sizes = (wanted.max_packet_size, wanted.alias_maximum)
        outbound = Outbound(self._link, state.clock, state.counters, packet.version, self._warn_too_large, *sizes)
        packets = ClientPackets(state, session, outbound, self._leave, self._fail, is_bridge=packet.is_bridge)
        self._client = _Client(wanted, session, outbound, packets, packet.will)
        self.client_id = wanted.client_id
        state.peers[wanted.client_id] = self
        state.waiting_logins.discard(self)
        self._count_unread(0)
        self._unread_of_all = state.unread
        outbound.send(login.connack(wanted, state, session_present=present))
        self._expect_signs_of_life()
        session.resume(outbound, wanted.receive_maximum)

    def _refuse(self, packet: Connect, reason: ReasonCode) -> None:
        self._state.counters.connections_refused += 1
        self._warn(
            "broker.login_refused",
            f"the broker refused {_client_text(packet.client_id, self.address)}: {reason.text}",
            client_id=packet.client_id,
            reason=reason.name.lower(),
        )
        self._shut(encode(Connack(reason=reason), packet.version))

    def _expect_signs_of_life(self) -> None:
        client = self._client
        if client is None or not client.wanted.keep_alive:
            return
        limit = client.wanted.keep_alive * _KEEP_ALIVE_GRACE
        now = self._state.clock.monotonic()
        if not client.packets.reading:  # the silence is our own
            self._received_at = now
        due = self._received_at + limit
        if due <= now:
            self._fail(PacketError("keep-alive timeout", code=ReasonCode.KEEP_ALIVE_TIMEOUT))
        else:
            self._silence = self._state.deadlines.at(due, self._expect_signs_of_life)

    def _no_connect(self) -> None:
        if self._connect is not None:
            self._refuse(self._connect, ReasonCode.QUOTA_EXCEEDED)
            return
        self._fail(PacketError("no CONNECT was received in time", code=ReasonCode.KEEP_ALIVE_TIMEOUT))

    def refuse_unread(self) -> None:
        """End the connection: its incomplete packet needs too much room."""
        self._state.counters.unread_given_up += 1
        if self._client is None:
            self._push_out()
        else:
            self._fail(PacketError("a packet stayed incomplete for too long", code=ReasonCode.QUOTA_EXCEEDED))

    def _count_unread(self, size: int) -> None:
        if self._client is not None and size < _CUT_BY_A_READ:
            size = 0
        change, self.unread = size - self.unread, size
        self._unread_of_all.add(change)

    def _push_out(self) -> None:
        """Close without a reason: nobody has logged in, and many may have to be closed at once."""
        self._warn(
            "broker.login_pushed_out",
            f"the broker closed the connection of {self.address}, without CONNECT: too many are waiting to log in",
        )
        self._finish(publish_will=False)
        self._link.close(linger=False)

    def _leave(self, publish_will: bool) -> None:  # noqa: FBT001 - a callback
        """Handle a DISCONNECT of the client."""
        self._finish(publish_will=publish_will)
        self._link.close(linger=False)

    def _fail(self, error: PacketError) -> None:
        self._state.counters.connections_failed += 1
        self.failure = error
        self._warn_failure(error)
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

    def _warn_failure(self, error: PacketError) -> None:
        self._warn(
            "broker.connection_failed",
            f"the broker cut off {self.client_text}: {short(error.problem)}",
            code=error.code.name.lower(),
            problem=error.problem,
        )

    def _warn_too_large(self, topic: str, size: int, limit: int) -> None:
        self._warn(
            "broker.message_too_large",
            f"{self.client_text} missed a message on {short(topic)!r}: it has {size} bytes, "
            f"the client accepts at most {limit}",
            topic=topic,
            size=size,
            limit=limit,
        )

    def _warn(self, event: str, message: str, **facts: object) -> None:
        self._state.warn(event, message, **{"address": self.address, "client_id": self.client_id, **facts})

    def _finish(self, *, publish_will: bool) -> None:
        if self._closed:
            return
        client = self._client
        self._closed = True
        self._state.counters.connections_closed += 1
        self._silence.cancel()
        self._connect = None
        if self._retry is not None:
            self._retry.cancel()
        self._state.waiting_logins.discard(self)
        self._count_unread(0)
        self._reader = _NOTHING_MORE
        self._state.turn.forget(self._go_on_later)
        if client is not None:
            client.session.outbound = None
            client.packets.stop()
            self._state.turn.run(self._depart(client, client.will if publish_will else None))

    def _depart(self, client: _Client, will: Will | None) -> Iterator[None]:
        """Finish the work for *client*, which has left: held messages, will, session; then another may log in."""
        client.session.detach()
        try:
            for _ in client.packets.forward_held():
                yield
                if self._is_gone:
                    break
        except PacketError as error:
            self.failure = error
            self._warn_failure(error)
        if self._is_gone:  # with everything the broker knew
            return
        del self._state.peers[client.session.client_id]
        self._state.sessions.detach(client.session, will)
        if self._newcomer is not None:
            self._newcomer.log_in()

    @property
    def _is_gone(self) -> bool:
        return self.client_id is None or self._state.peers.get(self.client_id) is not self


_NOTHING_MORE = PacketReader()


@dataclass(slots=True)
class _Client:
    wanted: login.ConnectRequest
    session: BrokerSession
    outbound: Outbound
    packets: ClientPackets
    will: Will | None


def _client_text(client_id: str | None, address: str) -> str:
    """Return ``client 'lamp' (10.0.0.5:50000)``, or only the address before the login."""
    return address if client_id is None else f"client {short(client_id)!r} ({address})"
