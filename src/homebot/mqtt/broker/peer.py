"""One client's connection from CONNECT to its end, without a socket.

Order: packets are handled one after the other as they come. While a publisher is held back for a slow subscriber,
its acknowledgements and pings are still handled, everything else waits in its order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, final

from homebot.mqtt.broker import login
from homebot.mqtt.broker.deadlines import Deadline
from homebot.mqtt.broker.farewell import goodbye, unread_connect_answer
from homebot.mqtt.broker.filter_requests import FilterRequests
from homebot.mqtt.broker.holding import Holding
from homebot.mqtt.broker.hub import Hub
from homebot.mqtt.broker.inbound import Inbound
from homebot.mqtt.broker.link import Link
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.peer_log import PeerLog
from homebot.mqtt.broker.session import Session
from homebot.mqtt.broker.sessions import will_size
from homebot.mqtt.broker.unread import UnreadMark
from homebot.mqtt.broker.words import host_of
from homebot.mqtt.packets import (
    Auth,
    Connack,
    Connect,
    Disconnect,
    Packet,
    PacketError,
    PacketReader,
    Pingreq,
    Pingresp,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
    Subscribe,
    Unsubscribe,
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

    def __init__(self, hub: Hub, link: Link) -> None:
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
        self._holding = Holding(hub, link, self._go_on)
        self._heard_at = hub.clock.monotonic()
        self._silence = hub.deadlines.at(self._heard_at + hub.limits.connect_timeout, self._no_connect)
        self._unread = UnreadMark(hub.unread_logins, self._give_up_unread)
        hub.waiting_logins.add(self)

    @property
    def client_id(self) -> str | None:
        """Who it is, once logged in."""
        return self._log.client_id

    @property
    def address(self) -> str:
        """The far side's address."""
        return self._link.address

    @property
    def words(self) -> str:
        """How the log calls it."""
        return self._log.words

    @property
    def will_bytes(self) -> int:
        """The size of its will."""
        return 0 if self._client is None else will_size(self._client.will)

    def receive(self, data: bytes) -> None:
        """Bytes came from the client."""
        if self._closed or not data:
            return
        self._heard_at = self._hub.clock.monotonic()
        try:
            if self._client is None:
                self._check_start(data)
                self._reader.feed(data)
                self._take_login()
            else:
                self._reader.feed(data)
                self._take_all(self._client)
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

    def _take_all(self, client: _Client) -> None:
        """Take all packets that are complete; one call of ``pump`` is for all PUBACK that follow each other."""
        pop, session = self._reader.pop, client.session
        freed = False
        while (packet := pop()) is not None:
            if type(packet) is Puback:  # comes once for each message sent, and never waits
                session.acknowledged(packet[0])
                freed = True
                continue
            if freed:
                session.pump()
                freed = False
            self._take(client, packet)
            if self._closed:
                return
        if freed:
            session.pump()

    def _handle(self, packet: Packet) -> None:
        client = self._client
        if client is None:
            self._login(packet)
        else:
            self._take(client, packet)

    def _take(self, client: _Client, packet: Packet) -> None:
        if type(packet) is Puback:
            client.session.acknowledged(packet.packet_id)
            client.session.pump()
        elif self._holding.active and not isinstance(packet, _NEVER_HELD):
            if isinstance(packet, Publish):
                client.inbound.check_quota(packet, self._holding.messages)
            self._holding.keep(packet)
        else:
            self._act(client, packet)

    def _act(self, client: _Client, packet: Packet) -> None:
        if type(packet) is Publish:
            if packet.qos:
                client.inbound.check_quota(packet, self._holding.messages)
            if self._hub.exchange.crowded and self._wait_for_room(client, packet):
                return
            slow = client.inbound.publish(packet)
            if slow:
                self._holding.wait_for(slow)
            if self._hub.turn.units <= 0:
                self._holding.paused = True
                self._hub.turn.later(self._resume)
        else:
            handler = self._HANDLERS.get(type(packet))
            if handler is None:
                raise _protocol_error(f"a client must not send {type(packet).__name__}")
            handler(self, client, packet)

    def _wait_for_room(self, client: _Client, packet: Publish) -> bool:
        """Whether *packet* has to wait because a queue is full."""
        full = client.inbound.must_wait_for(packet)
        if full:
            self._holding.keep_first(packet)
            self._holding.wait_for(full, endless=not client.inbound.refusable)
        return bool(full)

    def _check_start(self, data: bytes) -> None:
        """Something else than MQTT, such as a browser, is not left waiting for the rest of a packet."""
        if not self._started and data[:1] != _CONNECT:
            raise _protocol_error(f"the first byte is 0x{data[0]:02x}, not that of CONNECT")
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
            raise _protocol_error(f"{type(packet).__name__} came before CONNECT")
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
        inbound = Inbound(hub, session, outbound)
        filters = FilterRequests(hub, session, outbound, self._holding, self._resume)
        self._client = _Client(wanted, session, outbound, inbound, filters, packet.will)
        self._log.client_id = wanted.client_id
        hub.peers[wanted.client_id] = self
        hub.waiting_logins.discard(self)
        self._unread.move(hub.unread)
        outbound.send(login.welcome(wanted, hub, session_present=present))
        self._expect_signs_of_life()
        session.resume(outbound, wanted.receive_maximum)

    def _refuse(self, packet: Connect, reason: ReasonCode) -> None:
        self._hub.counters.connections_refused += 1
        self._log.refused(packet.client_id, reason)
        self._shut(encode(Connack(reason=reason), packet.version))

    def _taken(self, client: _Client, packet: Pubrec) -> None:
        reason = client.session.taken(packet.packet_id, packet.reason)
        if not packet.reason.failed:
            client.outbound.send(Pubrel(packet.packet_id, reason))

    def _released(self, client: _Client, packet: Pubrel) -> None:
        client.inbound.release(packet)

    def _completed(self, client: _Client, packet: Pubcomp) -> None:
        client.session.completed(packet.packet_id)

    def _ping(self, client: _Client, _packet: Pingreq) -> None:
        client.outbound.send(Pingresp())

    def _subscribe(self, client: _Client, packet: Subscribe) -> None:
        client.filters.subscribe(packet)

    def _unsubscribe(self, client: _Client, packet: Unsubscribe) -> None:
        client.filters.unsubscribe(packet)

    def _resume(self) -> None:
        """What waits behind a packet that took long has its turn."""
        if self._holding.paused and self._client is not None and not self._client.filters.active:
            self._holding.paused = False
            self._go_on()

    def _disconnect(self, client: _Client, packet: Disconnect) -> None:
        seconds = packet.properties.session_expiry_interval
        if seconds is not None:
            if seconds and not client.session.expiry:
                raise _protocol_error("a session that was to end with the connection cannot be prolonged")
            client.session.expiry = login.expiry_of(seconds)
        self._finish(publish_will=packet.reason is not ReasonCode.SUCCESS)
        self._link.close(linger=False)

    def _auth(self, _client: _Client, _packet: Auth) -> None:
        raise PacketError("there is no extended authentication", code=ReasonCode.BAD_AUTHENTICATION_METHOD)

    def _go_on(self) -> None:
        client = self._client
        if client is None:
            return
        try:
            while not self._closed and (packet := self._holding.take()) is not None:
                self._act(client, packet)
        except PacketError as error:
            self._fail(error)

    def _expect_signs_of_life(self) -> None:
        client = self._client
        if client is None or not client.wanted.keep_alive:
            return
        limit = client.wanted.keep_alive * _KEEP_ALIVE_GRACE
        now = self._hub.clock.monotonic()
        if not self._holding.reading:  # the silence is ours
            self._heard_at = now
        due = self._heard_at + limit
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

    def _fail(self, error: PacketError) -> None:
        hub = self._hub
        hub.counters.connections_failed += 1
        self.failure = error
        self._log.failed(error)
        if self._client is None:
            self._shut(unread_connect_answer(error))
        else:
            self._close(error.code, error.problem, publish_will=True)

    def _close(self, reason: ReasonCode, words: str, *, publish_will: bool) -> None:
        client = self._client
        last = b""
        if client is not None and client.outbound.version is ProtocolVersion.V5:
            wanted = client.wanted
            last = goodbye(reason, words if wanted.problem_information else "", wanted.max_packet_size)
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
        self._holding.stop()
        self._holding.paused = False
        self._hub.turn.forget(self._resume)
        self._hub.waiting_logins.discard(self)
        self._unread.note(0)
        self._reader = _NOTHING_MORE
        if client is not None:
            client.filters.stop()
            self._take_held(client)
            del self._hub.peers[client.session.client_id]
            self._hub.sessions.detach(client.session, client.will if publish_will else None)

    def _take_held(self, client: _Client) -> None:
        """Forward the messages that were held back, as far as there is room; nobody can be kept waiting any more."""
        client.inbound.gone = True
        try:
            while (packet := self._holding.take()) is not None:
                if isinstance(packet, Publish):
                    client.inbound.publish(packet)
        except PacketError as error:
            self.failure = error
            self._log.failed(error)
        self._holding.packets.clear()

    _HANDLERS: ClassVar[dict[type, Callable[..., None]]] = {
        Pubrel: _released,
        Pubrec: _taken,
        Pubcomp: _completed,
        Pingreq: _ping,
        Subscribe: _subscribe,
        Unsubscribe: _unsubscribe,
        Disconnect: _disconnect,
        Auth: _auth,
    }


_NOTHING_MORE = PacketReader()
_NEVER_HELD = (Pubrec, Pubrel, Pubcomp, Pingreq)


@dataclass(slots=True)
class _Client:
    wanted: login.Login
    session: Session
    outbound: Outbound
    inbound: Inbound
    filters: FilterRequests
    will: Will | None


def _protocol_error(problem: str) -> PacketError:
    return PacketError(problem, code=ReasonCode.PROTOCOL_ERROR)
