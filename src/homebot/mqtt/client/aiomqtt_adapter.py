"""The MQTT client port on aiomqtt 2; the one file that knows aiomqtt and the paho client below it.

aiomqtt gives the login, the requests to unsubscribe, and the books of own publishes of QoS 1 and 2.
Replaced, because it loses messages or waits in vain: the dialling (a cancelled one leaves a thread and a lock behind),
the reading (one message for each turn of the loop, acknowledged before anybody has it, stopped by one bad packet), the
keep-alive (a dead link is found out after two intervals and more), and the waiting for answers (a refused publish looks
like a good one, a dead link like a slow one).

It is longer than other files, because whatever touches the libraries stands here and nowhere else.

Concurrency: all callbacks run in the loop's own thread. Any number of tasks publish, as many of QoS 1 and 2 at once as
the broker allows; the others wait in order.
"""

# ruff: noqa: SLF001, ARG002 - paho has no public way to do these things, and its callbacks have fixed parameters

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
import ssl
import struct
import sys
from collections.abc import AsyncIterator, Iterable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Final, Literal, TypeVar, final

import aiomqtt
import anyio
from paho.mqtt import MQTTException
from paho.mqtt import client as paho
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode as PahoReason

from homebot.clock import Clock, LoopClock
from homebot.errors import HomebotError, LinkError, RefusedError, UsageError, WireError
from homebot.logger import get_logger
from homebot.mqtt.client.dial import dial
from homebot.mqtt.client.incoming import Frame, FrameReader
from homebot.mqtt.client.keep_alive import KeepAlive, LifeSign
from homebot.mqtt.client.port import MqttCounters, MqttSubscription, PublishResult, SessionGrant
from homebot.mqtt.client.read_ahead import ReadAhead
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import check_granted, disconnect_error, login_error, reason_text
from homebot.mqtt.client.session_end import end_session
from homebot.mqtt.client.tcp_transport import make_tls_context, socket_error
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets.primitives import Cursor
from homebot.mqtt.packets.properties import PacketType, decode_properties
from homebot.mqtt.packets.publish import Publish, encode_publish
from homebot.mqtt.packets.reason import ProtocolVersion, ReasonCode
from homebot.mqtt.packets.subscribe import FilterRequest, Subscribe, encode_subscribe
from homebot.mqtt.topics import validate_filter, validate_topic

__all__ = ["AiomqttClient"]

_PORTION = 32 * 1024
"""Bytes understood in one turn of the loop: enough for a few hundred messages, a few milliseconds of work."""

_READ_SIZE = 1024 * 1024
_READ_AHEAD = 16 * 1024 * 1024
"""Bytes read in one turn, and waiting to be understood, at most; see `ReadAhead` for why so many."""

_IN_FLIGHT = 100
"""Most own publishes of QoS 1 and 2 that wait for their answer at once, however many the broker would allow."""

_SEND_QUEUE = 256
"""Packets that may wait for the socket before a publish of QoS 0 waits too."""

_TCP_QUICKACK: Final[int | None] = getattr(socket, "TCP_QUICKACK", None)  # Linux has it
_SINGLE_ACKNOWLEDGEMENT = 4  # bytes of a PUBACK or PUBREC
_HOLD = 0.001  # seconds for which a single one waits for company
_GOODBYE = 1.0
"""Seconds that a clean close may take; the broker may be gone already."""

_PINGREQ: Final = b"\xc0\x00"
_TLS_ALERT: Final = 0x15  # RFC 8446, section 5.1
_IN_TLS: Final = "the server there uses TLS; is the address mqtts://?"
_NO_MQTT: Final = "the server there is not an MQTT broker"

# The libraries log what a peer makes them log, without a limit; the facts are in our errors and events.
_SILENCE: Final = logging.getLogger("homebot.mqtt.silence")
_SILENCE.disabled = True

_log = get_logger()

_Version = Literal["5", "3.1.1"]
T = TypeVar("T")
_CODEC: Final = {"5": ProtocolVersion.V5, "3.1.1": ProtocolVersion.V311}


@final
class AiomqttClient:
    """The `MqttClient` port on aiomqtt 2; make it inside a running event loop.

    Args:
        options: Broker, login and limits.
        clock: Paces log lines.
    """

    def __init__(self, options: MqttOptions, clock: Clock | None = None) -> None:
        self._options = options
        self._receiver = Receiver(options, LoopClock() if clock is None else clock)
        self._link: _Link | None = None
        self._up = False

    @property
    def counters(self) -> MqttCounters:
        """Counters of the events so far."""
        return self._receiver.counters

    def connected(self) -> AbstractAsyncContextManager[SessionGrant]:
        """Make the link; see `MqttClient.connected`."""
        return self._connected()

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait until the link is gone and say why."""
        return await self._need_link().wait_lost()

    async def publish(
        self,
        topic: str,
        payload: bytes = b"",
        *,
        qos: int = 0,
        retain: bool = False,
        properties: MessageProperties = NO_PROPERTIES,
    ) -> PublishResult:
        """Publish; see `MqttClient.publish`."""
        validate_topic(topic)
        if qos not in {0, 1, 2}:
            raise UsageError(f"QoS is 0, 1 or 2, not {qos}")
        return await self._need_link().send(topic, payload, qos, retain=retain, properties=properties)

    async def subscribe(self, *subscriptions: MqttSubscription) -> tuple[int, ...]:
        """Subscribe; see `MqttClient.subscribe`."""
        for subscription in subscriptions:
            validate_filter(subscription.filter)
        return await self._need_link().request(subscriptions) if subscriptions else ()

    async def unsubscribe(self, *filters: str) -> None:
        """Take back subscriptions; see `MqttClient.unsubscribe`."""
        if filters:
            await self._need_link().cancel(filters)

    async def receive(self) -> list[MqttMessage]:
        """All messages that are there; see `MqttClient.receive`."""
        return await self._receiver.take()

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        """Acknowledge; see `MqttClient.ack`."""
        data = self._receiver.settle(messages)
        if data and self._link is not None:
            self._link.acknowledge(data)

    def drop(self) -> None:
        """Cut the link; see `MqttClient.drop`."""
        if self._link is not None and self._up:
            self._link.drop()

    @asynccontextmanager
    async def _connected(self) -> AsyncIterator[SessionGrant]:
        if self._up:
            raise UsageError("this MQTT client is connected already")
        self._up = True
        try:
            link, session = await self._open()
            try:
                yield session
            finally:
                await self._close(link)
        finally:
            self._up = False

    async def _close(self, link: _Link) -> None:
        ends_session = link.is_alive and self._options.session_ends_on_close and self._options.session_expiry > 0
        await link.close()
        if not ends_session:
            return
        with anyio.CancelScope(shield=True), anyio.move_on_after(_GOODBYE):
            try:
                tls = await make_tls_context(self._options) if self._options.tls else None
                await end_session(self._options, link.version, await dial(self._options, tls))
            except HomebotError as error:
                _log.debug("mqtt.session_left", broker=self._options.url, reason=str(error))

    async def _open(self) -> tuple[_Link, SessionGrant]:
        tls = await make_tls_context(self._options) if self._options.tls else None  # certificates are renewed
        try:
            return await self._open_as(self._first_version(), tls)
        except (RefusedError, _ClosedEarlyError) as error:
            if not self._falls_back(error):
                raise
            reason = str(error)
        opened = await self._open_as("3.1.1", tls)  # from now on the first version too, so this is said once
        _log.info(
            "mqtt.fell_back",
            message=f"{self._options.url} speaks MQTT 3.1.1, not 5",
            broker=self._options.url,
            reason=reason,
        )
        return opened

    async def _open_as(self, version: _Version, tls: ssl.SSLContext | None) -> tuple[_Link, SessionGrant]:
        # The same object on every link: a new one counts packet identifiers from the start again, and a broker
        # with an open QoS 2 hand-shake of that number takes the next message for a repetition and swallows it.
        link = self._link
        if link is None or link.version != version:
            link = _Link(self._options, version, self._receiver)
        session = await link.open(await dial(self._options, tls))
        self._link = link
        return link, session

    def _first_version(self) -> _Version:
        if self._options.protocol != "auto":
            return self._options.protocol
        return "5" if self._link is None else self._link.version

    def _falls_back(self, error: HomebotError) -> bool:
        if self._options.protocol != "auto" or self._first_version() != "5":
            return False
        if isinstance(error, RefusedError):
            return error.code == ReasonCode.UNSUPPORTED_PROTOCOL_VERSION
        return self._link is None  # a broker that has spoken 5 before closed for another reason

    def _need_link(self) -> _Link:
        if self._link is None or not self._up:
            raise LinkError(f"not connected to {self._options.url}")
        return self._link


class _ClosedEarlyError(LinkError):
    """The broker closed the connection where it should have answered CONNECT."""


class _Link(aiomqtt.Client):
    """One paho client and its successive links."""

    def __init__(self, options: MqttOptions, version: _Version, receiver: Receiver) -> None:
        clean = options.session_expiry == 0
        five = version == "5"
        super().__init__(
            options.host,
            options.port,
            username=options.user,
            password=None if options.password is None else options.password.get_secret_value(),
            logger=_SILENCE,
            identifier=options.client_id,
            protocol=aiomqtt.ProtocolVersion.V5 if five else aiomqtt.ProtocolVersion.V311,
            will=_will(options, with_properties=five),
            clean_session=None if five else clean,
            clean_start=clean if five else paho.MQTT_CLEAN_START_FIRST_ONLY,
            timeout=options.timeout,
            keepalive=options.keep_alive,
            properties=_connect_properties(options) if five else None,
        )
        self.version: Final = version
        self.pending_calls_threshold = sys.maxsize  # else it warns from ten calls on
        self._options = options
        self._receiver = receiver
        self._packets = FrameReader(options.maximum_packet_size)
        self._ahead = ReadAhead(_PORTION, _READ_AHEAD)
        self._is_reading = False
        self._granted: SessionGrant | None = None
        self._greeting: asyncio.Future[SessionGrant] = self._loop.create_future()
        self._lost: LinkError | RefusedError | None = LinkError("not connected yet")
        self._gone = anyio.Event()
        self._drained = anyio.Event()
        self._answers: dict[int, asyncio.Future[int]] = {}
        self._grants: dict[int, asyncio.Future[tuple[int, ...]]] = {}
        self._window = anyio.Semaphore(_IN_FLIGHT, fast_acquire=True)
        self._keep_alive: KeepAlive | None = None
        self._life_check: asyncio.TimerHandle | None = None
        self._flush_soon: asyncio.Handle | None = None
        self._held = b""
        self._release_held: asyncio.TimerHandle | None = None
        self._stuck = False
        self._dialled: socket.socket | None = None
        self._write_error: OSError | None = None
        # paho dials in a blocking call; it is given the socket that was dialled without blocking.
        self._client._create_socket = self._take_socket  # type: ignore[method-assign] # the only way in
        # paho says of a failed write only that it failed, not that the broker's TLS did not like our certificate.
        self._client._sock_send = self._send_to_socket  # type: ignore[method-assign, assignment] # as above
        # Not 0, so that a restarted process does not meet the open identifiers of its predecessor.
        self._client._last_mid = secrets.randbelow(65_535)
        # paho makes costly objects for each call of it, and we read the answers ourselves.
        self._client.on_publish = None

    async def open(self, sock: socket.socket) -> SessionGrant:
        """Say CONNECT on *sock*, which from now on belongs to the link, and wait for the answer."""
        self._dialled = sock
        self._packets = FrameReader(self._options.maximum_packet_size)
        self._granted = self._lost = self._write_error = None
        self._gone = anyio.Event()
        self._greeting = self._loop.create_future()
        try:
            self._client_connect()  # does not block: the socket is there
            with anyio.fail_after(self.timeout):
                return await self._greeting
        except TimeoutError as error:
            self._break(LinkError(f"no answer to CONNECT within {self.timeout:g} s"))
            raise LinkError(f"no answer to CONNECT within {self.timeout:g} s") from error
        except BaseException:
            self._break(LinkError("the connection attempt was cancelled"))
            raise

    async def close(self) -> None:
        """Say good-bye, if there is still somebody, and drop the link."""
        self.put(b"")  # what is held
        with anyio.CancelScope(shield=True), anyio.move_on_after(_GOODBYE):
            if self._client.disconnect() == paho.MQTT_ERR_SUCCESS:
                await self._gone.wait()
        self._abort()
        self._lose(LinkError("closed"))

    def drop(self) -> None:
        self._break(LinkError("dropped"))

    @property
    def is_alive(self) -> bool:
        return self._lost is None

    async def wait_lost(self) -> LinkError | RefusedError:
        await self._gone.wait()
        return self._lost or LinkError("closed")

    async def send(
        self, topic: str, payload: bytes, qos: int, *, retain: bool, properties: MessageProperties
    ) -> PublishResult:
        extra = None if properties is NO_PROPERTIES or self.version != "5" else _publish_properties(properties)
        self._check_alive()
        if self._granted is not None:
            check_granted(self._granted, topic, len(payload) + _packed_size(extra), qos, retain=retain)
        if qos:
            async with self._window:
                return await self._send_and_wait(topic, payload, qos, retain=retain, extra=extra)
        if extra is None:
            self.put(encode_publish(Publish(topic, payload, 0, retain), _CODEC[self.version]))
        else:
            self._hand_over(topic, payload, 0, retain=retain, extra=extra)
        while len(self._client._out_packet) > _SEND_QUEUE and self._lost is None:
            if self._drained.is_set():
                self._drained = anyio.Event()
            await self._drained.wait()
        self._check_alive()
        return PublishResult()

    async def request(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        """Subscribe without paho, which takes three times as long over it: a house has thousands of topics."""
        self._check_alive()
        packet_id = self._free_packet_id()
        wishes = tuple(_wish(subscription) for subscription in subscriptions)
        self.put(encode_subscribe(Subscribe(packet_id, wishes), _CODEC[self.version]))
        self._check_alive()
        reasons = await self._wait_for_answer(self._grants, packet_id, "a subscribe")
        refused = [(s.filter, reason) for s, reason in zip(subscriptions, reasons, strict=False) if reason >= 0x80]
        if refused:
            names = ", ".join(repr(name) for name, _ in refused)
            raise RefusedError(f"the subscription to {names}", reason_text(refused[0][1]), refused[0][1])
        return reasons

    async def cancel(self, filters: tuple[str, ...]) -> None:
        self._check_alive()
        try:
            await self.unsubscribe(list(filters))
        except aiomqtt.MqttError as error:
            raise self._lost_error("unsubscribe") from error
        self._check_alive()

    def acknowledge(self, data: bytes) -> None:
        """Send acknowledgements: many at once, a single one a moment later, together with the answer it may cause."""
        if len(data) > _SINGLE_ACKNOWLEDGEMENT:
            self.put(data)
            return
        self._held += data
        if self._release_held is None:
            self._release_held = self._loop.call_later(_HOLD, self.put, b"")

    def put(self, data: bytes) -> None:
        """Send finished packets, as many as there are in *data*: at once if the socket takes them, else in turn."""
        if self._lost is not None:
            return
        if self._held:
            data, self._held = self._held + data, b""
        if self._release_held is not None:
            self._release_held.cancel()
            self._release_held = None
        client, sent = self._client, 0
        sock = client.socket()
        if not client.want_write() and sock is not None:
            try:
                sent = sock.send(data)
            except (BlockingIOError, InterruptedError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
                sent = 0
            except OSError as error:
                self._break(self._cut(error))
                return
        if sent < len(data):
            # paho passes packets of this type on as they are; it does not look into them.
            client._packet_queue(paho.PUBACK, data[sent:], 0, 0)

    # -- own publishes ------------------------------------------------------------------------------------

    async def _send_and_wait(
        self, topic: str, payload: bytes, qos: int, *, retain: bool, extra: Properties | None
    ) -> PublishResult:
        if qos == 1 and extra is None:
            packet_id = self._put_publish(topic, payload, retain=retain)
        else:
            packet_id = self._hand_over(topic, payload, qos, retain=retain, extra=extra)
            self._flush()
        self._check_alive()  # the sending itself may have found the link broken
        reason = await self._wait_for_answer(self._answers, packet_id, "a publish")
        if reason >= 0x80:
            raise RefusedError(f"the publish to {topic!r}", reason_text(reason), reason)
        return PublishResult(reason)

    def _put_publish(self, topic: str, payload: bytes, *, retain: bool) -> int:
        """Send a plain PUBLISH of QoS 1 without paho, which takes five times as long over it."""
        self._check_alive()
        packet_id = self._free_packet_id()
        self.put(encode_publish(Publish(topic, payload, 1, retain, packet_id=packet_id), _CODEC[self.version]))
        return packet_id

    def _free_packet_id(self) -> int:
        client = self._client
        taken = (self._answers, self._grants, self._pending_unsubscribes, client._out_messages)
        packet_id = client._mid_generate()
        while any(packet_id in ids for ids in taken):
            packet_id = client._mid_generate()
        return packet_id

    async def _wait_for_answer(self, waiting: dict[int, asyncio.Future[T]], packet_id: int, to_what: str) -> T:
        answer: asyncio.Future[T] = self._loop.create_future()
        waiting[packet_id] = answer
        overdue = self._loop.call_later(self.timeout, _expire, answer)
        try:
            return await answer
        except TimeoutError as error:
            raise LinkError(f"no answer to {to_what} within {self.timeout:g} s") from error
        finally:
            overdue.cancel()
            del waiting[packet_id]

    def _hand_over(self, topic: str, payload: bytes, qos: int, *, retain: bool, extra: Properties | None) -> int:
        self._check_alive()
        info = self._client.publish(topic, payload, qos, retain, extra)
        while info.rc == paho.MQTT_ERR_QUEUE_SIZE:  # the identifier still waits for its answer; try the next
            info = self._client.publish(topic, payload, qos, retain, extra)
        if info.rc != paho.MQTT_ERR_SUCCESS:
            raise self._lost_error("publish")
        return info.mid

    def _answered(self, packet: Frame) -> None:
        """PUBACK, PUBCOMP, or a PUBREC that says no: the hand-shake is over."""
        packet_id = int.from_bytes(packet.body[:2], "big")
        client = self._client
        if client._out_messages.pop(packet_id, None) is not None:
            client._inflight_messages -= 1
            client._update_inflight()
        answer = self._answers.get(packet_id)
        if answer is not None and not answer.done():
            answer.set_result(packet.body[2] if len(packet.body) > 2 else 0)

    def _check_alive(self) -> None:
        if self._lost is not None:
            raise LinkError(f"the link is lost: {self._lost}")

    def _lost_error(self, what: str) -> LinkError:
        if self._lost is None:
            return LinkError(f"no answer to {what} within {self.timeout:g} s")
        return LinkError(f"{what} failed, the link is lost: {self._lost}")

    # -- the socket ---------------------------------------------------------------------------------------

    def _take_socket(self) -> socket.socket:
        sock, self._dialled = self._dialled, None
        if sock is None:
            raise ConnectionError("no socket was dialled")
        return sock

    def _send_to_socket(self, data: bytes | bytearray) -> int:
        try:
            return type(self._client)._sock_send(self._client, data)
        except BlockingIOError:
            raise
        except OSError as error:
            self._write_error = error
            raise

    def _on_socket_open(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        self._ahead = ReadAhead(_PORTION, _READ_AHEAD)
        self._is_reading = True
        self._loop.add_reader(sock.fileno(), self._read_ready)

    def _on_socket_close(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        self._loop.remove_reader(sock.fileno())
        if self._life_check is not None:
            self._life_check.cancel()
        self._keep_alive = None

    def _on_socket_register_write(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        # Later in this turn, so that everything said in one turn goes together; not at once, because paho may
        # hold a lock that its callbacks need.
        self._flush_soon = self._loop.call_soon(self._flush)

    def _on_socket_unregister_write(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        if self._stuck:
            self._loop.remove_writer(sock.fileno())
            self._stuck = False
        self._drained.set()

    def _flush(self) -> None:
        if self._flush_soon is not None:
            self._flush_soon.cancel()
            self._flush_soon = None
        sock = self._client.socket()
        self._client.loop_write()
        if sock is not None and self._client.socket() is sock and self._client.want_write():
            self._loop.add_writer(sock.fileno(), self._flush)
            self._stuck = True

    def _check_signs_of_life(self, keep_alive: KeepAlive) -> None:
        """Instead of paho's, which looks once a second and waits for a whole interval for the answer to its ping."""
        match keep_alive.check(self._loop.time()):
            case LifeSign.LOST:
                self._break(LinkError("the broker does not answer any more"))
                return
            case LifeSign.PING:
                self.put(_PINGREQ)
            case LifeSign.WAIT:
                pass
        if self._lost is None:
            self._life_check = self._loop.call_at(keep_alive.due, self._check_signs_of_life, keep_alive)

    def _read_ready(self) -> None:
        sock = self._client.socket()
        if not isinstance(sock, socket.socket):
            return
        more = True
        while more and self._lost is None:
            try:
                data = sock.recv(_READ_SIZE)
            except (BlockingIOError, InterruptedError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
                return
            except OSError as error:  # also where TLS 1.3 tells that it does not like our certificate
                self._take_in_all_of_it()
                self._break(self._cut(error))
                return
            if data and self._keep_alive is not None:
                self._keep_alive.heard(self._loop.time())
            if data and (self._ahead.size or len(data) > _PORTION):
                self._read_ahead(sock, data)
            else:
                self._take_in_all_of_it()
                self._take_in(data)
            _acknowledge_at_once(sock)
            more = isinstance(sock, ssl.SSLSocket) and sock.pending() > 0

    def _read_ahead(self, sock: socket.socket, data: bytes) -> None:
        if not self._ahead.size:
            self._loop.call_soon(self._take_in_portion)
        self._ahead.put(data)
        if self._ahead.is_full:
            self._loop.remove_reader(sock.fileno())
            self._is_reading = False

    def _take_in_portion(self) -> None:
        sock = self._client.socket()
        if self._lost is not None or not isinstance(sock, socket.socket):
            return
        if portion := self._ahead.take():
            self._take_in(portion)
        if self._ahead.size and self._lost is None:
            self._loop.call_soon(self._take_in_portion)
        if not self._is_reading and not self._ahead.is_full and self._lost is None:
            self._is_reading = True
            self._loop.add_reader(sock.fileno(), self._read_ready)

    def _take_in_all_of_it(self) -> None:
        """Before the end of the link: what came before it counts."""
        while self._lost is None and (portion := self._ahead.take()):
            self._take_in(portion)

    def _take_in(self, data: bytes) -> None:
        if not data:
            self._break(self._cut())
            return
        try:
            packets = self._packets.feed(data)
        except WireError as error:
            self._break(LinkError(_NO_MQTT if self._granted is None else str(error)))
            return
        answers = bytearray()
        publish = self._receiver.publish
        for packet in packets:
            if packet.first & 0xF0 == paho.PUBLISH and self._granted is not None:
                answers += publish(packet)
            else:
                answers += self._handle(packet)
            if self._lost is not None:
                return
        if answers:
            self.put(bytes(answers))

    def _cut(self, error: OSError | None = None) -> LinkError | RefusedError:
        """Interpret the end of the socket: with *error*, or in order."""
        reason = LinkError("the broker closed the connection") if error is None else socket_error(error)
        if self._granted is not None or isinstance(reason, RefusedError):
            return reason
        hint = "is this a port for TLS (mqtts://)?"
        if self._options.tls:
            hint = "does it want a client certificate (cert_file)?"
        return LinkError(f"{reason} instead of answering; {hint}")

    def _handle(self, packet: Frame) -> bytes:
        kind = packet.first & 0xF0
        if self._granted is None and kind != paho.CONNACK:
            self._break(LinkError(_IN_TLS if packet.first == _TLS_ALERT and not self._options.tls else _NO_MQTT))
        elif packet.oversize:
            self._break(LinkError(f"the broker sent a packet of type {kind >> 4} where it must not"))
        elif kind == paho.PUBREL:
            return self._receiver.release(packet)
        elif kind in {paho.PUBACK, paho.PUBCOMP} or (
            kind == paho.PUBREC and len(packet.body) > 2 and packet.body[2] >= 0x80
        ):
            self._answered(packet)
        elif kind == paho.SUBACK:
            self._grant(packet)
        else:
            self._let_paho_handle(packet)
        return b""

    def _grant(self, packet: Frame) -> None:
        """SUBACK; its reasons as they are, because brokers give others than the protocol has."""
        cursor = Cursor(packet.body)
        try:
            packet_id = cursor.uint16()
            if self.version == "5":
                decode_properties(cursor, PacketType.SUBACK)
        except WireError as error:
            self._break(LinkError(f"the broker sent something unreadable: {error}"))
            return
        answer = self._grants.get(packet_id)
        if answer is not None and not answer.done():
            answer.set_result(tuple(cursor.take(cursor.left)))

    def _let_paho_handle(self, packet: Frame) -> None:
        client = self._client
        client._in_packet["command"] = packet.first
        client._in_packet["packet"] = bytearray(packet.body)
        client._in_packet["remaining_length"] = len(packet.body)
        client._in_packet["pos"] = 0
        try:
            code = client._packet_handle()
        except MQTTException as error:
            self._break(LinkError(f"the broker sent something unreadable: {error}"))
            return
        if code != paho.MQTT_ERR_SUCCESS:
            self._break(LinkError(f"the broker sent something out of place: {paho.error_string(code)}"))

    # -- the life of a link -------------------------------------------------------------------------------

    def _on_connect(
        self,
        client: paho.Client,
        userdata: Any,
        flags: paho.ConnectFlags,
        reason_code: PahoReason,
        properties: Properties | None = None,
    ) -> None:
        if self._greeting.done():
            return
        code = reason_code.value
        if code >= 0x80:
            error = login_error(code)
            self._greeting.set_exception(error)
            self._lose(error)  # paho closes the socket; here it holds the lock for that
            return
        session = _session(self.version, flags, properties)
        self._granted = session
        limit = min(session.receive_maximum, _IN_FLIGHT)
        # paho's own limit is 200 whatever the broker says, and a broker cuts the link of who exceeds its number.
        # The public setter refuses while connected, but the number is not known before.
        client._max_inflight_messages = limit
        self._window = anyio.Semaphore(limit, fast_acquire=True)
        if not session.resumed:
            client.drop_out_messages()  # or they would be published anew, minutes late
        self._receiver.begin_link(session)
        keep_alive = KeepAlive(_keep_alive(properties, self._options), self._options.timeout, self._loop.time())
        self._keep_alive = keep_alive
        self._life_check = self._loop.call_at(keep_alive.due, self._check_signs_of_life, keep_alive)
        self._greeting.set_result(session)

    def _on_disconnect(
        self,
        client: paho.Client,
        userdata: Any,
        flags: paho.DisconnectFlags,
        reason_code: PahoReason,
        properties: Properties | None = None,
    ) -> None:
        if flags.is_disconnect_packet_from_server:
            self._lose(disconnect_error(reason_code.value))
        elif self._write_error is not None:
            self._lose(self._cut(self._write_error))
        else:
            self._lose(LinkError(reason_text(reason_code.value) if reason_code.is_failure else "closed"))

    def _break(self, reason: LinkError | RefusedError) -> None:
        self._lose(reason)
        self._abort()

    def _abort(self) -> None:
        self._client._sock_close()  # the public disconnect() waits for the peer

    def _lose(self, reason: LinkError | RefusedError) -> None:
        if self._lost is not None:
            return
        self._lost = reason
        self._held = b""
        if self._release_held is not None:
            self._release_held.cancel()
            self._release_held = None
        if not self._greeting.done():
            early = isinstance(reason, LinkError)
            self._greeting.set_exception(_ClosedEarlyError(str(reason)) if early else reason)
        self._receiver.end_link(reason)
        self._fail_calls()
        self._gone.set()
        self._drained.set()

    def _fail_calls(self) -> None:
        """Tell everybody who waits for an answer that none will come."""
        for answer in self._answers.values():
            if not answer.done():
                answer.set_exception(self._lost_error("publish"))
        for grant in self._grants.values():
            if not grant.done():
                grant.set_exception(self._lost_error("subscribe"))
        for event in self._pending_unsubscribes.values():
            event.set()
        # Their callers know that they failed; paho would send them on the next link, whenever that is. QoS 2
        # stays: its hand-shake must be brought to an end, or the broker swallows a later message of its number.
        messages = self._client._out_messages
        for packet_id in [packet_id for packet_id, message in messages.items() if message.qos == 1]:
            del messages[packet_id]


def _wish(subscription: MqttSubscription) -> FilterRequest:
    return FilterRequest(
        subscription.filter,
        subscription.qos,
        subscription.no_local,
        subscription.retain_as_published,
        subscription.retain_handling,
    )


def _expire(answer: asyncio.Future[T]) -> None:
    if not answer.done():
        answer.set_exception(TimeoutError())


def _acknowledge_at_once(sock: socket.socket) -> None:
    """A broker with Nagle's algorithm on, such as Mosquitto, waits up to 40 ms for the acknowledgement of TCP.

    Linux forgets this wish after a while, so it is repeated.
    """
    if _TCP_QUICKACK is not None and sock.fileno() >= 0:
        sock.setsockopt(socket.IPPROTO_TCP, _TCP_QUICKACK, 1)


def _connect_properties(options: MqttOptions) -> Properties:
    # No TopicAliasMaximum: paho does not resolve aliases, and neither do we.
    properties = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call] # paho has no types there
    properties.ReceiveMaximum = options.receive_maximum
    properties.MaximumPacketSize = options.maximum_packet_size
    properties.SessionExpiryInterval = options.session_expiry
    return properties


def _publish_properties(wanted: MessageProperties, packet_type: int = PacketTypes.PUBLISH) -> Properties:
    properties = Properties(packet_type)  # type: ignore[no-untyped-call] # as above
    for name, value in (
        ("PayloadFormatIndicator", 1 if wanted.payload_is_text else None),
        ("MessageExpiryInterval", wanted.expiry),
        ("ContentType", wanted.content_type),
        ("ResponseTopic", wanted.response_topic),
        ("CorrelationData", wanted.correlation_data),
        ("UserProperty", list(wanted.user) or None),
    ):
        if value is not None:
            setattr(properties, name, value)
    return properties


def _packed_size(properties: Properties | None) -> int:
    """Bytes of the properties; it also checks them, which paho does only when half of a publish is booked."""
    if properties is None:
        return 0
    try:
        return len(properties.pack())  # type: ignore[no-untyped-call] # paho has no types there
    except (MQTTException, ValueError, struct.error) as error:
        raise UsageError(f"these message properties cannot be sent: {error}") from error


def _will(options: MqttOptions, *, with_properties: bool) -> aiomqtt.Will | None:
    will = options.will
    if will is None:
        return None
    extra = _publish_properties(will.properties, PacketTypes.WILLMESSAGE) if with_properties else None
    return aiomqtt.Will(will.topic, will.payload, will.qos, will.retain, extra)


def _keep_alive(properties: Properties | None, options: MqttOptions) -> float:
    """The interval in seconds: the broker's where it gives one."""
    seconds = getattr(properties, "ServerKeepAlive", None)
    return float(seconds) if isinstance(seconds, int) and seconds > 0 else float(options.keep_alive)


def _session(version: _Version, flags: paho.ConnectFlags, properties: Properties | None) -> SessionGrant:
    def fact(name: str, default: int) -> int:
        value = getattr(properties, name, default)
        return value if isinstance(value, int) else default

    return SessionGrant(
        resumed=bool(flags.session_present),
        protocol=version,
        maximum_qos=fact("MaximumQoS", 2),
        retain_available=bool(fact("RetainAvailable", 1)),
        receive_maximum=fact("ReceiveMaximum", 65_535),
        maximum_packet_size=fact("MaximumPacketSize", 0) or None,
    )
