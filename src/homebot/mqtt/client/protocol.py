"""One link of a client in memory, from CONNECT to its end."""

from __future__ import annotations

import asyncio
from typing import Final, final

import anyio

from homebot.errors import LinkError, RefusedError, WireError
from homebot.mqtt.client.incoming import Frame, FrameReader
from homebot.mqtt.client.keep_alive import KeepAlive, LifeSign
from homebot.mqtt.client.memory_transport import MemorySocket
from homebot.mqtt.client.packet_values import connect_packet, disconnect_packet, session_of
from homebot.mqtt.client.port import SessionGrant
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import disconnect_error, login_error
from homebot.mqtt.client.requests import Answer, Requests
from homebot.mqtt.client.send_window import SendWindow
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import (
    Connack,
    Disconnect,
    Packet,
    PacketType,
    Pingreq,
    Pingresp,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Suback,
    Unsuback,
    decode,
    encode,
)

__all__ = ["ClientProtocol"]

_IN_FLIGHT = 100  # as on the link with a socket, so that tests see the same order
_SEND_BUFFER = 256 * 1024  # bytes that may wait for the broker before a publish of QoS 0 waits too
_PUBLISH: Final = PacketType.PUBLISH
_PUBREL: Final = PacketType.PUBREL


@final
class ClientProtocol:
    """Fills :class:`homebot.mqtt.client.memory_transport.LinkUser`.

    Args:
        options: Login and limits.
        version: What to speak.
        receiver: Where messages go.
        requests: The client's open requests.

    Attributes:
        version: What is spoken.
        granted: What the broker granted; None before.
        window: Bounds the own publishes of QoS 1 and 2 that are open.
    """

    def __init__(self, options: MqttOptions, version: ProtocolVersion, receiver: Receiver, requests: Requests) -> None:
        self.version: Final = version
        self.granted: SessionGrant | None = None
        self.window = SendWindow(0)
        self._options = options
        self._receiver = receiver
        self._requests = requests
        self._loop = asyncio.get_running_loop()
        self._packets = FrameReader(options.maximum_packet_size)
        self._socket: MemorySocket | None = None
        self._greeting: asyncio.Future[SessionGrant] = self._loop.create_future()
        self._lost: LinkError | RefusedError | None = None
        self._gone = anyio.Event()
        self._drained: anyio.Event | None = None
        self._unfinished: set[int] = set()  # hand-shakes of an earlier link that take up a place each
        self._keep_alive: KeepAlive | None = None
        self._check: asyncio.TimerHandle | None = None

    async def open(self, socket: MemorySocket) -> SessionGrant:
        """Say CONNECT on *socket*, which is to bring its bytes here, and wait for the answer.

        Raises:
            LinkError: The broker did not answer.
            RefusedError: It said no.
        """
        self._socket = socket
        self.send_packet(connect_packet(self._options, self.version))
        words = f"no answer to CONNECT within {self._options.timeout:g} s"
        try:
            with anyio.fail_after(self._options.timeout):
                return await self._greeting
        except TimeoutError:
            self._break(LinkError(words))
            raise LinkError(words) from None
        except BaseException:
            self._break(LinkError("the connect was given up"))
            raise

    def close(self, *, ends_session: bool) -> None:
        """Say good-bye, if there is still somebody, and drop the link."""
        if self._lost is None and self._socket is not None:
            self.send_packet(disconnect_packet(ends_session=ends_session))
            self._socket.close()
        self._lose(LinkError("closed"))

    def drop(self) -> None:
        """Cut the link without a word."""
        self._break(LinkError("dropped"))

    @property
    def is_alive(self) -> bool:
        """True if the link stands."""
        return self._lost is None

    def check_alive(self) -> None:
        """Raise LinkError where the link is lost."""
        if self._lost is not None:
            raise LinkError(f"the link is lost: {self._lost}")

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait for the end and say why."""
        await self._gone.wait()
        return self._lost or LinkError("closed")

    def send_packet(self, packet: Packet) -> None:
        """Send one packet."""
        self.put(encode(packet, self.version))

    def put(self, data: bytes) -> None:
        """Send finished packets."""
        if self._lost is None and self._socket is not None:
            self._socket.write(data)

    async def wait_until_taken(self) -> None:
        """Wait while the broker is far behind in taking what was said.

        Raises:
            LinkError: The link was lost.
        """
        while self._socket is not None and self._socket.waiting > _SEND_BUFFER and self._lost is None:
            self._drained = self._drained or anyio.Event()
            await self._drained.wait()
        self.check_alive()

    async def answer_to(self, request: Packet, packet_id: int, what: str) -> Answer:
        """Send *request* and wait for its last answer.

        Raises:
            UsageError: The request cannot be said in MQTT.
            LinkError: No answer came.
        """
        data = encode(request, self.version)
        answer = self._requests.expect(packet_id)
        if isinstance(request, Publish) and request.qos == 2:
            self._requests.hold(request)
        overdue = self._loop.call_later(self._options.timeout, _expire, answer)
        try:
            self.put(data)
            return await answer
        except TimeoutError:
            raise LinkError(f"no answer to a {what} within {self._options.timeout:g} s") from None
        except LinkError as error:
            raise LinkError(f"{what} failed, the link is lost: {error}") from None
        finally:
            overdue.cancel()
            self._requests.forget(packet_id)

    def data_received(self, data: bytes) -> None:
        """Bytes came from the broker."""
        if self._keep_alive is not None:
            self._keep_alive.heard(self._loop.time())
        answers = bytearray()
        try:
            for frame in self._packets.feed(data):
                if self._lost is not None:
                    return
                if frame.first >> 4 == _PUBLISH and self.granted is not None:
                    answers += self._receiver.publish(frame)
                elif frame.first >> 4 == _PUBREL and self.granted is not None:
                    answers += self._receiver.release(frame)
                else:
                    self._handle(self._decoded(frame))
        except WireError as error:
            self._break(LinkError(str(error)))
            return
        if answers:
            self.put(bytes(answers))

    def drained(self) -> None:
        """The broker has taken everything that was written."""
        if self._drained is not None:
            self._drained.set()
            self._drained = None

    def link_ended(self) -> None:
        """The broker closed the link."""
        self._lose(LinkError("the broker closed the connection"))

    def _decoded(self, frame: Frame) -> Packet:
        if frame.oversize:
            raise WireError(f"the broker sent a packet of type {frame.first >> 4} where it must not")
        return decode(frame.first, frame.body, self.version)

    def _handle(self, packet: Packet) -> None:
        if self.granted is None and not isinstance(packet, Connack):
            raise WireError(f"{type(packet).__name__} came instead of CONNACK")
        match packet:
            case Connack():
                self._on_connack(packet)
            case Pubrec() if not packet.reason.failed:
                self.send_packet(self._requests.taken(packet.packet_id))
            case Puback() | Pubrec() | Pubcomp() | Suback() | Unsuback():
                self._on_answer(packet)
            case Pingresp():
                pass  # it was heard
            case Disconnect():
                self._lose(disconnect_error(packet.reason))
            case _:
                raise WireError(f"a broker must not send {type(packet).__name__}")

    def _on_connack(self, packet: Connack) -> None:
        if self._greeting.done():
            raise WireError("CONNACK came twice")
        if packet.reason.failed:
            self._lose(login_error(packet.reason))
            return
        self.granted = session = session_of(packet, self.version)
        seconds = packet.properties.server_keep_alive or self._options.keep_alive
        self._keep_alive = KeepAlive(seconds, self._options.timeout, self._loop.time())
        again = self._requests.begin_link(resumed=session.resumed)
        self._unfinished = {each.packet_id for each in again if each.packet_id is not None}
        self.window = SendWindow(min(session.receive_maximum, _IN_FLIGHT) - len(again))
        self._receiver.begin_link(session)
        self._greeting.set_result(session)
        for each in again:
            self.send_packet(each)
        self._check = self._loop.call_at(self._keep_alive.due, self._check_signs_of_life, self._keep_alive)

    def _on_answer(self, packet: Answer) -> None:
        self._requests.answered(packet)
        if packet.packet_id in self._unfinished:
            self._unfinished.discard(packet.packet_id)
            self.window.release()

    def _check_signs_of_life(self, keep_alive: KeepAlive) -> None:
        match keep_alive.check(self._loop.time()):
            case LifeSign.LOST:
                self._break(LinkError("the broker does not answer any more"))
                return
            case LifeSign.PING:
                self.send_packet(Pingreq())
            case LifeSign.WAIT:
                pass
        self._check = self._loop.call_at(keep_alive.due, self._check_signs_of_life, keep_alive)

    def _break(self, reason: LinkError | RefusedError) -> None:
        if self._socket is not None:
            self._socket.abort()
        self._lose(reason)

    def _lose(self, reason: LinkError | RefusedError) -> None:
        if self._lost is not None:
            return
        self._lost = reason
        if self._check is not None:
            self._check.cancel()
        if not self._greeting.done():
            self._greeting.set_exception(reason)
        self._receiver.end_link(reason)
        self._requests.fail(str(reason))
        self.window.close(f"publish failed, the link is lost: {reason}")
        self._gone.set()
        self.drained()


def _expire(answer: asyncio.Future[Answer]) -> None:
    if not answer.done():
        answer.set_exception(TimeoutError())
