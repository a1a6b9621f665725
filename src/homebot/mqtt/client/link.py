"""One link of an MQTT client, from login to end, as far as it is independent of the implementation."""

import asyncio
from abc import ABC, abstractmethod
from typing import Final, final

import anyio

from homebot.errors import LinkError, RefusedError, WireError
from homebot.mqtt.client.keep_alive import KeepAlive, LifeSign
from homebot.mqtt.client.login import ClosedEarlyError, MqttVersion, SessionGrant, early_end, reason_text
from homebot.mqtt.client.receiver import Frame, Receiver
from homebot.mqtt.client.requests import Answer, Requests, SendWindow
from homebot.mqtt.client.transport import SEND_BUFFER, ClientTransport
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import MqttSubscription, PacketType, Properties, ReasonCode
from homebot.support.unanswered import SENT_REQUESTS

UNREADABLE: Final = "the broker sent something unreadable"

_IN_FLIGHT: Final = 100
"""Most own publishes of QoS 1 and 2 that wait for their answer at once, however many the broker would allow."""

_PUBLISH: Final = PacketType.PUBLISH
_PUBREL: Final = PacketType.PUBREL
_PINGREQ: Final = b"\xc0\x00"  # of every version
_TLS_ALERT: Final = 0x15  # RFC 8446, section 5.1
_IN_TLS: Final = "the server there uses TLS; is the address mqtts://?"
_NO_MQTT: Final = "the server there is not an MQTT broker"
_OVERHEAD: Final = 12  # bytes of a PUBLISH besides topic, properties and payload, at most


class ClientLink(ABC):
    """One link from login to end: incoming bytes are cut into packets, and messages go to the receiver.

    The subclass gets all other packets. Implements :class:`homebot.mqtt.client.transport.TransportUser`.

    Attributes:
        transport: Carries the bytes; None before there is a connection.
    """

    def __init__(self, options: MqttOptions, version: MqttVersion, receiver: Receiver, requests: Requests) -> None:
        self.grant = SessionGrant(resumed=False, protocol=version)
        self._is_granted = False
        self._is_v5: Final = version == "5"
        self._options: Final = options
        self._receiver: Final = receiver
        self._requests: Final = requests
        self._loop: Final = asyncio.get_running_loop()
        self.transport: ClientTransport | None = None
        self._window = SendWindow(0)  # bounds the own publishes of QoS 1 and 2 that are open
        self._lost: LinkError | RefusedError | None = None
        self._packets = FrameReader(options.maximum_packet_size)
        self._gone = anyio.Event()
        self._drained: anyio.Event | None = None
        self._heard_at = self._loop.time()
        self._check: asyncio.TimerHandle | None = None  # of the keep-alive

    @property
    def is_alive(self) -> bool:
        """True if the link stands."""
        return self._lost is None

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait for the end and say why."""
        await self._gone.wait()
        return self._lost or LinkError("closed")

    @abstractmethod
    async def publish(self, topic: str, payload: bytes, qos: int, properties: Properties, *, retain: bool) -> int:
        """Publish, and return the reason code of the answer; at QoS 0 it is 0, once the broker is not far behind.

        Raises:
            RefusedError: The broker does not take such messages.
            LinkError: The link is lost, or no answer came.
        """

    @abstractmethod
    async def subscribe(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        """Subscribe, and return the reason codes of the answer."""

    @abstractmethod
    async def unsubscribe(self, filters: tuple[str, ...]) -> None:
        """Take back subscriptions."""

    @abstractmethod
    async def close(self, *, ends_session: bool) -> None:
        """Send DISCONNECT and wait until the link is closed; *ends_session* where the version has a field for it."""

    def cut(self, reason: LinkError | RefusedError) -> None:
        """End the link without a word because of *reason*; nothing where it has ended."""
        if self.transport is not None and self._lost is None:
            self.transport.abort()
        self._lose(reason)

    def data_received(self, data: bytes) -> None:
        """Handle bytes from the broker."""
        self._heard_at = self._loop.time()
        answers = b""
        has_messages = False
        try:
            for frame in self._packets.feed(data):
                if self._lost is not None:
                    return
                kind = frame.first >> 4
                if kind == _PUBLISH and self._is_granted:
                    answers += self._receiver.publish(frame)
                    has_messages = True
                elif kind == _PUBREL and self._is_granted:
                    answers += self._receiver.release(frame)
                else:
                    if not self._is_granted or frame.oversize:
                        self._check_frame(frame)
                    self._handle(frame)
        except ClosedEarlyError as error:
            self.cut(error)
        except WireError as error:
            self.cut(LinkError(f"{UNREADABLE}: {error}") if self._is_granted else ClosedEarlyError(_NO_MQTT))
        else:
            if answers:
                self._put(answers)
        finally:
            if has_messages:
                self._receiver.deliver()

    def drained(self) -> None:
        """Go on: the broker has taken everything that was written."""
        if self._drained is not None:
            self._drained.set()
            self._drained = None

    def link_ended(self, reason: LinkError | RefusedError) -> None:
        """End with the link, which the broker closed, or which broke."""
        self._lose(reason if self._is_granted else early_end(reason, self._options))

    @abstractmethod
    def _handle(self, frame: Frame) -> None:
        """Take in a packet that is no message; before the login has succeeded a CONNACK.

        Raises:
            WireError: It does not follow the protocol.
        """

    def _begin(self, grant: SessionGrant, keep_alive: int, *, open_publishes: int = 0) -> None:
        """Begin after a login that succeeded; *open_publishes* of an earlier link take up places."""
        self.grant = grant
        self._check_signs_of_life(KeepAlive(keep_alive, self._options.timeout, self._loop.time()))
        self._is_granted = True
        self._window = SendWindow(min(grant.receive_maximum, _IN_FLIGHT) - open_publishes)
        assert self.transport is not None  # noqa: S101 - the answer to the login came by it
        self._receiver.begin_link(grant, self.transport.write_acknowledgements)

    def _lose(self, reason: LinkError | RefusedError) -> None:
        if self._lost is not None:
            return
        self._lost = reason
        if self._check is not None:
            self._check.cancel()
        self._receiver.end_link(reason)
        self._requests.fail(str(reason))
        self._window.close(f"publish failed, the link is lost: {reason}")
        self._gone.set()
        self.drained()

    def _check_signs_of_life(self, keep_alive: KeepAlive) -> None:
        keep_alive.heard_at = self._heard_at
        match keep_alive.check(self._loop.time()):
            case LifeSign.LOST:
                self.cut(LinkError("the broker stopped responding"))
                return
            case LifeSign.PING:
                self._put(_PINGREQ)
            case LifeSign.WAIT:
                pass
        self._check = self._loop.call_at(keep_alive.due, self._check_signs_of_life, keep_alive)

    def _check_alive(self) -> None:
        if self._lost is not None:
            raise LinkError(f"the link is lost: {self._lost}")

    def _check_granted(self, topic: str, size: int, qos: int, *, retain: bool) -> None:
        """Refuse a publish that the broker would answer by closing the link; *size* is of payload and properties.

        Raises:
            LinkError: The link is lost.
            RefusedError: The broker does not take such messages.
        """
        self._check_alive()
        limit = self.grant.maximum_packet_size
        if qos > self.grant.maximum_qos:
            code = ReasonCode.QOS_NOT_SUPPORTED
        elif retain and not self.grant.retain_available:
            code = ReasonCode.RETAIN_NOT_SUPPORTED
        elif limit is not None and len(topic.encode()) + size + _OVERHEAD > limit:
            code = ReasonCode.PACKET_TOO_LARGE
        else:
            return
        raise RefusedError(f"the publish to {topic!r}", reason_text(code), code)

    def _put(self, data: bytes) -> None:
        if self._lost is None and self.transport is not None:
            self.transport.write(data)

    async def _wait_until_taken(self) -> None:
        """Wait while the broker is far behind in reading."""
        while self.transport is not None and self.transport.waiting > SEND_BUFFER and self._lost is None:
            self._drained = self._drained or anyio.Event()
            await self._drained.wait()
        self._check_alive()

    async def _answer(self, packet_id: int, what: str, request: bytes = b"") -> Answer:
        """Send *request*, a whole packet, unless it is empty; return the last answer.

        Raises:
            LinkError: No answer came.
        """
        if request:
            self._put(request)
        answer, requests = self._requests.expect(packet_id), SENT_REQUESTS.get()
        requests.is_unanswered = True
        try:
            reasons = await answer
            requests.is_unanswered = False
        except TimeoutError:
            raise LinkError(f"no answer to a {what} within {self._options.timeout:g} s") from None
        except LinkError as error:
            raise LinkError(f"{what} failed, the link is lost: {error}") from None
        finally:
            self._requests.forget(packet_id)
        return reasons

    def _check_frame(self, frame: Frame) -> None:
        if not self._is_granted and frame.first >> 4 != PacketType.CONNACK:
            in_tls = frame.first == _TLS_ALERT and not self._options.tls
            raise ClosedEarlyError(_IN_TLS if in_tls else _NO_MQTT)
        if frame.oversize:
            raise WireError(f"a packet of type {frame.first >> 4} of {frame.oversize} bytes")


_HEAD = 2 + 65_535 + 2
"""Longest topic and packet identifier at the start of a PUBLISH: the kept part of an oversized one."""

_new = tuple.__new__  # makes a named tuple in half the time that its own call takes


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
                self._skipping = Frame(buffer[position], b"", length)
                self._skip = length
                position = len(buffer) - len(self._skip_over(buffer[start:], packets))
                continue
            if end > size:
                self._needed = end - position
                break
            packets.append(_new(Frame, (buffer[position], buffer[start:end], 0)))
            position = end
        if self._rest or position < size:
            self._rest = bytearray(buffer[position:])
        return packets

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
