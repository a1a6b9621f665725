"""The MQTT client port on our own codec: over TCP and TLS, or over a link in memory without socket and thread.

It keeps every promise of the port.
"""

import asyncio
from functools import lru_cache
from random import Random
from typing import Final, final

import anyio

from homebot.clock import Clock
from homebot.errors import LinkError, RefusedError, UnansweredError, WireError
from homebot.mqtt.client.client import MqttClient
from homebot.mqtt.client.link import ClientLink
from homebot.mqtt.client.login import ClosedEarlyError, MqttVersion, SessionGrant, disconnect_error, login_error
from homebot.mqtt.client.receiver import Frame, Receiver
from homebot.mqtt.client.requests import Answer, Requests
from homebot.mqtt.client.tcp_transport import dial_tcp
from homebot.mqtt.client.transport import Dial
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import (
    NO_PROPERTIES,
    Connack,
    Connect,
    Disconnect,
    MqttSubscription,
    Packet,
    PacketType,
    Properties,
    ProtocolVersion,
    Publish,
    Subscribe,
    Unsubscribe,
    decode,
    encode,
)
from homebot.mqtt.packets.primitives import Cursor
from homebot.mqtt.packets.properties import decode_properties, encode_properties
from homebot.mqtt.packets.publish import encode_publish_parts
from homebot.mqtt.packets.reason import PacketError

_PUBREC: Final = PacketType.PUBREC
_PINGRESP: Final = PacketType.PINGRESP
_ANSWERS: Final = frozenset({PacketType.PUBACK, _PUBREC, PacketType.PUBCOMP, PacketType.SUBACK, PacketType.UNSUBACK})
_FAILED: Final = 0x80  # reason codes from here on say no
_V3_CONNACK: Final = 2  # bytes of its body


@final
class NativeClient(MqttClient):
    """The client on our own codec."""

    def __init__(
        self,
        options: MqttOptions,
        dial: Dial = dial_tcp,
        *,
        clock: Clock | None = None,
        random: Random | None = None,
    ) -> None:
        super().__init__(options, clock)
        self._dial = dial
        random = Random() if random is None else random  # noqa: S311 - identifiers are no secret
        self._requests = Requests(random, options.timeout)

    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        protocol = ClientProtocol(options, version, receiver, self._requests)
        await protocol.open(self._dial)
        return protocol


@final
class ClientProtocol(ClientLink):
    """A link that speaks by our own codec."""

    def __init__(self, options: MqttOptions, version: MqttVersion, receiver: Receiver, requests: Requests) -> None:
        super().__init__(options, version, receiver, requests)
        self._version: Final = ProtocolVersion.V5 if self._is_v5 else ProtocolVersion.V311
        self._greeting: asyncio.Future[None] = self._loop.create_future()
        self._unfinished: set[int] = set()  # handshakes of an earlier link that take up a place each

    async def open(self, dial: Dial) -> None:
        """Open a link that brings its bytes here, say CONNECT, and wait for the answer.

        Raises:
            LinkError: The broker cannot be reached, or did not answer.
            RefusedError: It said no.
            UsageError: A certificate file cannot be used.
        """
        self.transport = await dial(self._options, self)
        self._send(_connect_packet(self._options, self._version))
        words = f"no answer to CONNECT within {self._options.timeout:g} s"
        try:
            with anyio.fail_after(self._options.timeout):
                await self._greeting
        except TimeoutError:
            self.cut(LinkError(words))
            raise UnansweredError(words) from None
        except BaseException:
            self.cut(LinkError("the connection attempt was cancelled"))
            raise

    async def publish(self, topic: str, payload: bytes, qos: int, properties: Properties, *, retain: bool) -> int:
        """Publish; see `ClientLink.publish`."""
        encoded = _encode(properties) if self._is_v5 else b""
        head, tail = encode_publish_parts(topic, payload, qos, retain, encoded)
        self._check_granted(topic, len(tail), qos, retain=retain)
        if not qos:
            self._put(head + tail)
            await self._wait_until_taken()
            return 0
        window = self._window
        has_waited = await window.acquire()
        try:
            if has_waited:
                self._check_alive()
            packet_id = self._requests.new_id()
            if qos == 2:
                publish = Publish(topic, payload, qos, retain, packet_id=packet_id, properties=properties)
                self._requests.hold(packet_id, publish)
            (reason,) = await self._answer(packet_id, "publish", head + packet_id.to_bytes(2, "big") + tail)
        finally:
            window.release()
        return reason

    async def subscribe(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        """Subscribe, and return the reason codes of the answer."""
        self._check_alive()
        packet_id = self._requests.new_id()
        return await self._answer(packet_id, "subscribe", encode(Subscribe(packet_id, subscriptions), self._version))

    async def unsubscribe(self, filters: tuple[str, ...]) -> None:
        """Take back subscriptions."""
        self._check_alive()
        packet_id = self._requests.new_id()
        await self._answer(packet_id, "unsubscribe", encode(Unsubscribe(packet_id, filters), self._version))

    async def close(self, *, ends_session: bool) -> None:
        """Send DISCONNECT, if there is still a link, and drop it; MQTT 5 has a field for *ends_session*."""
        transport = self.transport
        if self._lost is None and transport is not None:
            ends = ends_session and self._is_v5
            self._send(Disconnect(properties=Properties(session_expiry_interval=0)) if ends else Disconnect())
            transport.close()
            self._lose(LinkError("closed"))
            await transport.wait_closed()
        self._lose(LinkError("closed"))

    def _handle(self, frame: Frame) -> None:
        kind = frame.first >> 4
        if kind in _ANSWERS:
            packet_id, reasons = answer_in(frame, is_v5=self._is_v5)
            if kind == _PUBREC and reasons[0] < _FAILED:
                self._send(self._requests.taken(packet_id))
                return
            self._requests.answered(packet_id, reasons)
            if packet_id in self._unfinished:
                self._unfinished.discard(packet_id)
                self._window.release()
        elif kind != _PINGRESP:  # that one was heard
            old = frame.first >> 4 == PacketType.CONNACK and len(frame.body) == _V3_CONNACK
            packet = decode(frame.first, frame.body, ProtocolVersion.V311 if old else self._version)
            match packet:
                case Connack():
                    self._on_connack(packet)
                case Disconnect():
                    self.cut(disconnect_error(packet.reason))
                case _:
                    raise WireError(f"a broker must not send {type(packet).__name__}")

    def _on_connack(self, packet: Connack) -> None:
        if self._greeting.done():
            raise WireError("CONNACK came twice")
        if packet.reason.failed:
            reason = login_error(packet.reason)
            self._greeting.set_exception(reason)
            self.cut(reason)
            return
        granted = packet.properties
        session = SessionGrant(
            resumed=packet.session_present,
            protocol="5" if self._version is ProtocolVersion.V5 else "3.1.1",
            maximum_qos=2 if granted.maximum_qos is None else granted.maximum_qos,
            retain_available=granted.retain_available != 0,
            receive_maximum=granted.receive_maximum or 65_535,
            maximum_packet_size=granted.maximum_packet_size,
        )
        seconds = packet.properties.server_keep_alive or self._options.keep_alive
        again = self._requests.begin_link(resumed=session.resumed)
        self._unfinished = {open_packet.packet_id for open_packet in again if open_packet.packet_id is not None}
        self._begin(session, seconds, open_publishes=len(again))
        self._greeting.set_result(None)
        for open_packet in again:
            self._send(open_packet)

    def _lose(self, reason: LinkError | RefusedError) -> None:
        if not self._greeting.done():
            early = isinstance(reason, LinkError)
            self._greeting.set_exception(ClosedEarlyError(str(reason)) if early else reason)
        super()._lose(reason)

    def _send(self, packet: Packet) -> None:
        self._put(encode(packet, self._version))


def answer_in(frame: Frame, *, is_v5: bool) -> tuple[int, Answer]:
    """Return packet identifier and reason codes of PUBACK, PUBREC, PUBCOMP, SUBACK or UNSUBACK.

    Raises:
        PacketError: The packet ends too early.
    """
    kind, body = frame.first >> 4, frame.body
    if len(body) < 2:
        raise PacketError("an answer ends before its packet id", body)
    packet_id = body[0] << 8 | body[1]
    if kind < PacketType.SUBACK:
        return packet_id, (body[2] if len(body) > 2 else 0,)
    start = 2
    if is_v5 and len(body) > start and body[start] == 0:  # no properties
        start += 1
    elif is_v5:
        cursor = Cursor(body)
        cursor.position = start
        decode_properties(cursor, PacketType(kind))
        start = cursor.position
    return packet_id, tuple(body[start:])


def _connect_packet(options: MqttOptions, version: ProtocolVersion) -> Connect:
    is_v5 = version is ProtocolVersion.V5
    properties = NO_PROPERTIES
    if is_v5:
        properties = Properties(
            receive_maximum=options.receive_maximum,
            maximum_packet_size=options.maximum_packet_size,
            session_expiry_interval=options.session_expiry,
        )
    return Connect(
        client_id=options.client_id,
        version=version,
        clean_start=options.session_expiry == 0,
        keep_alive=options.keep_alive,
        username=options.user,
        password=None if options.password is None else options.password.get_secret_value().encode(),
        will=options.will,
        properties=properties,
    )


@lru_cache(maxsize=32)
def _encode(properties: Properties) -> bytes:
    """Return the properties of a PUBLISH as they are sent; the last ones are remembered: most say none, or how long."""
    return encode_properties(properties, PacketType.PUBLISH)
