"""The MQTT client port on aiomqtt 2 and the paho client below it.

A thin adapter: aiomqtt connects, logs in, subscribes and says good-bye; paho publishes, acknowledges and calls back.
It closes what they leave open: a message is acknowledged only when it was taken, a refused publish is an error, callers
that wait for an answer hear at once that the link dropped, and what waits is bounded.

Promises of the port that it does not keep, and the native client does:

- QoS 2 goes out and is subscribed to as QoS 1: paho answers an arriving message of QoS 2 before anybody has it, and the
  next process would never get it. So a message may come twice.
- A packet that MQTT does not allow ends the link; a message that is too large is dropped only when all of it is here.
- Where a broker cuts the connection during the login, the error says less about why.
- A cancelled connect leaves a thread behind until the connection stands or fails, `MqttOptions.timeout` at most; the
  socket of a failed TLS hand-shake stays open until Python collects it.

Concurrency: all but the connecting runs in the loop's own thread. Any number of tasks publish, as many of QoS 1 at once
as the broker allows; the others wait in order.
"""

# ruff: noqa: ARG002 - paho's callbacks have fixed parameters

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Awaitable, Iterable
from contextlib import suppress
from typing import Any, Final, TypeVar, final

import aiomqtt
import anyio
from paho.mqtt import client as paho
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode as PahoReason

from homebot.clock import Clock
from homebot.errors import InvalidNameError, LinkError, RefusedError
from homebot.mqtt.client import paho_values as values
from homebot.mqtt.client.base import BaseClient, ClientLink, check_granted
from homebot.mqtt.client.paho_socket import PahoSocket
from homebot.mqtt.client.port import MqttSubscription, SessionGrant
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import disconnect_error, login_error
from homebot.mqtt.client.requests import SendWindow
from homebot.mqtt.client.tcp_transport import dial_error, make_tls_context
from homebot.mqtt.client.version_choice import MqttVersion, early_end
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets.reason import ReasonCode
from homebot.mqtt.topics import validate_topic

__all__ = ["AiomqttClient"]

_IN_FLIGHT: Final = 100  # own publishes of QoS 1 that wait for their answer, however many the broker would allow
T = TypeVar("T")


@final
class AiomqttClient(BaseClient):
    """The `MqttClient` port on aiomqtt 2; make it inside a running event loop.

    Args:
        options: Broker, login and limits.
        clock: Paces log lines.
    """

    def __init__(self, options: MqttOptions, clock: Clock | None = None) -> None:
        super().__init__(options, clock)
        self._links = 0

    @property
    def limits(self) -> tuple[str, ...]:
        """Promises of the port that it does not keep; see `MqttClient.limits`."""
        return ('aiomqtt carries QoS 2 as QoS 1, so a message may come twice; client = "native" carries it',)

    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        tls = await make_tls_context(options) if options.tls else None  # each time: certificates are renewed
        self._links += 1
        link = _AiomqttLink(options, version, self._links, receiver, tls)
        await link.open()
        return link


@final
class _AiomqttLink:
    """One aiomqtt client and its one link: a second link of it would repeat publishes that failed long ago."""

    def __init__(
        self, options: MqttOptions, version: MqttVersion, number: int, receiver: Receiver, tls: ssl.SSLContext | None
    ) -> None:
        self._version = version
        self.grant = SessionGrant(resumed=False, protocol=version)
        self._options = options
        self._number = number
        self._receiver = receiver
        self._lost: LinkError | RefusedError | None = None
        self._gone = anyio.Event()
        self._is_up = False
        self._window = SendWindow(_IN_FLIGHT)
        self._answers: dict[int, asyncio.Future[int]] = {}
        self._calls: set[anyio.CancelScope] = set()  # that end with the link
        self._client = aiomqtt.Client(**values.settings_of(options, version), tls_context=tls)
        client = self._paho = self._client._client  # noqa: SLF001 - aiomqtt's handle to paho
        client.connect_timeout = options.timeout
        client.manual_ack_set(on=True)
        client.on_message, client.on_publish = self._on_message, self._on_publish
        self._then_connect: Any = client.on_connect
        self._then_disconnect: Any = client.on_disconnect
        client.on_connect, client.on_disconnect = self._on_connect, self._on_disconnect
        self._socket = PahoSocket(client, lambda error: self.cut(LinkError(f"{_UNREADABLE}: {error!r}")))

    @property
    def is_alive(self) -> bool:
        return self._lost is None

    async def open(self) -> None:
        try:
            await self._end_with_link(self._client.__aenter__())
        except aiomqtt.MqttError as error:
            reason = self._no_connection(error.__context__)
        except LinkError:
            raise self._lost or LinkError("closed") from None
        except BaseException:
            self.cut(LinkError("the connection attempt was cancelled"))
            raise
        else:
            return
        self.cut(reason)
        raise reason  # not from the library's error, which keeps paho's socket open

    async def close(self, *, ends_session: bool) -> None:
        if self._lost is not None:
            return
        if ends_session and self._version == "5":
            properties = values.properties_of(PacketTypes.DISCONNECT, SessionExpiryInterval=0)
            self._paho.disconnect(properties=properties)
            await self._gone.wait()
        with suppress(aiomqtt.MqttError):
            await self._client.__aexit__(None, None, None)

    def cut(self, reason: LinkError | RefusedError) -> None:
        """End the link without a word; nothing where it has ended."""
        self._lose(reason)
        self._socket.close()

    async def wait_lost(self) -> LinkError | RefusedError:
        await self._gone.wait()
        return self._lost or LinkError("closed")

    async def publish(
        self, topic: str, payload: bytes, qos: int, properties: MessageProperties, *, retain: bool
    ) -> int:
        self._check_alive()
        extra = None if properties is NO_PROPERTIES or self._version != "5" else values.publish_properties(properties)
        qos = min(qos, values.MOST_QOS)
        check_granted(self.grant, topic, len(payload) + values.packed_size(extra), qos, retain=retain)
        if qos:
            return await self._publish_and_wait(topic, payload, qos, extra, retain=retain)
        self._paho.publish(topic, payload, qos, retain, extra)
        self._socket.flush()
        await self._socket.wait_until_taken()
        self._check_alive()
        return 0

    async def subscribe(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        self._check_alive()
        options: list[Any] = [(each.filter, values.subscribe_options(each, self._version)) for each in subscriptions]
        codes = await self._call(self._client.subscribe(options), "subscribe")
        return tuple(code if isinstance(code, int) else code.value for code in codes)

    async def unsubscribe(self, filters: tuple[str, ...]) -> None:
        self._check_alive()
        await self._call(self._client.unsubscribe(list(filters)), "unsubscribe")

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        for message in messages:
            if message.qos and message.receipt >> 16 == self._number and self._lost is None:
                self._paho.ack(message.receipt & 0xFFFF, message.qos)

    def _no_connection(self, cause: BaseException | None) -> LinkError | RefusedError:
        if isinstance(cause, OSError) and not isinstance(cause, TimeoutError):
            return dial_error(cause, in_tls=self._options.tls)
        to_what = "" if not self._socket.is_open else " to CONNECT"
        return LinkError(f"no answer{to_what} within {self._options.timeout:g} s")

    def _check_alive(self) -> None:
        if self._lost is not None or not self._is_up:
            raise LinkError(f"the link is lost: {self._lost or 'not connected yet'}")

    async def _publish_and_wait(
        self, topic: str, payload: bytes, qos: int, extra: Properties | None, *, retain: bool
    ) -> int:
        await self._window.acquire()
        packet_id = 0
        try:
            self._check_alive()
            while (info := self._paho.publish(topic, payload, qos, retain, extra)).rc == paho.MQTT_ERR_QUEUE_SIZE:
                pass  # that packet identifier still waits for its answer; the next
            packet_id = info.mid
            answer: asyncio.Future[int] = asyncio.get_running_loop().create_future()
            self._answers[packet_id] = answer
            self._socket.flush()
            with anyio.fail_after(self._options.timeout):
                return await answer
        except TimeoutError:
            raise self._no_answer("publish") from None
        finally:
            self._answers.pop(packet_id, None)
            self._window.release()

    async def _call(self, request: Awaitable[T], what: str) -> T:
        try:
            return await self._end_with_link(request)
        except aiomqtt.MqttError:
            raise self._no_answer(what) from None

    async def _end_with_link(self, request: Awaitable[T]) -> T:
        """Wait for *request*, which the libraries do not tell about the end of the link; then raise why it ended."""
        with anyio.CancelScope() as scope:
            self._calls.add(scope)
            try:
                return await request
            finally:
                self._calls.discard(scope)
        raise self._no_answer("request")

    def _no_answer(self, what: str) -> LinkError:
        if self._lost is None:
            return LinkError(f"no answer to a {what} within {self._options.timeout:g} s")
        return LinkError(f"{what} failed, the link is lost: {self._lost}")

    def _lose(self, reason: LinkError | RefusedError) -> None:
        if self._lost is not None:
            return
        self._lost = reason
        if self._is_up:
            self._receiver.end_link(reason)
        for answer in self._answers.values():
            if not answer.done():
                answer.set_exception(self._no_answer("publish"))
        self._window.close(f"publish failed, the link is lost: {reason}")
        for scope in self._calls:
            scope.cancel()
        self._gone.set()

    def _on_connect(
        self, client: paho.Client, userdata: Any, flags: paho.ConnectFlags, code: PahoReason, properties: Any
    ) -> None:
        if code.is_failure:
            self.cut(login_error(code.value))
            return
        self.grant = grant = values.grant_of(self._version, flags, properties)
        self._window = SendWindow(min(grant.receive_maximum, _IN_FLIGHT))
        self._receiver.begin_link(grant)
        self._is_up = True
        self._then_connect(client, userdata, flags, code, properties)

    def _on_disconnect(
        self, client: paho.Client, userdata: Any, flags: paho.DisconnectFlags, code: PahoReason, properties: Any
    ) -> None:
        if flags.is_disconnect_packet_from_server:
            self._lose(disconnect_error(code.value))
        else:
            reason = LinkError(_ENDS.get(code.value, "the broker closed the connection"))
            self._lose(reason if self._is_up else early_end(reason, self._options))
        success = PahoReason(PacketTypes.DISCONNECT)  # or aiomqtt keeps an error that nobody reads
        self._then_disconnect(client, userdata, flags, success, properties)

    def _on_message(self, client: paho.Client, userdata: Any, message: paho.MQTTMessage) -> None:
        self._socket.note_received()
        try:
            taken = values.message_of(message, self._number << 16 | message.mid)
            validate_topic(taken.topic)
        except (UnicodeDecodeError, InvalidNameError):
            self._receiver.note_malformed("a PUBLISH with a topic that is none")
            client.ack(message.mid, message.qos)
            return
        if len(taken.payload) > self._options.maximum_packet_size:
            self._receiver.note_oversize(len(taken.payload))
            client.ack(message.mid, message.qos)
            return
        self._receiver.accept(taken)

    def _on_publish(self, client: paho.Client, userdata: Any, mid: int, code: PahoReason, properties: Any) -> None:
        self._socket.note_received()
        answer = self._answers.get(mid)
        if answer is not None and not answer.done():
            answer.set_result(code.value)


_UNREADABLE: Final = "the broker sent something unreadable"
_ENDS: Final[dict[int, str]] = {
    ReasonCode.SUCCESS: "closed",
    ReasonCode.PROTOCOL_ERROR: _UNREADABLE,
    ReasonCode.KEEP_ALIVE_TIMEOUT: "the broker does not answer any more",
}
