"""The MQTT client port on aiomqtt 2 and the paho client below it.

A thin adapter: aiomqtt connects, logs in and disconnects; paho publishes, subscribes and calls back. The native
client's reader splits the bytes into packets and reads messages, for which paho takes eight times as long, and
acknowledges QoS 2 too early. It also reads the answers to subscriptions, for which paho makes an object per filter.
paho handles all other packets. It adds what the two lack: a message is acknowledged only after it was accepted, a
refused publish is an error, a lost link ends waiting calls at once, and all queues are bounded.

Promises of the port that only the native client keeps:

- QoS 2 is sent as QoS 1, because paho's handshakes end with its link, so that a message may arrive twice.
- A cancelled connect leaves a thread until the connection succeeds or fails, at most `MqttOptions.timeout`.

Concurrency: everything except connecting runs in the loop's thread. Any number of tasks may publish; as many publishes
of QoS 1 as the broker allows are open at once, the others wait in order.
"""

import ssl
from collections.abc import Awaitable
from contextlib import suppress
from functools import partial
from random import Random
from typing import Any, Final, TypeVar, final

import aiomqtt
import anyio
from paho.mqtt import client as paho
from paho.mqtt.enums import MQTTErrorCode
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.reasoncodes import ReasonCode as PahoReason

from homebot.errors import LinkError, RefusedError, UnansweredError
from homebot.mqtt.client import paho_values as values
from homebot.mqtt.client.client import MqttClient
from homebot.mqtt.client.link import UNREADABLE, ClientLink
from homebot.mqtt.client.login import MqttVersion, disconnect_error, early_end, login_error
from homebot.mqtt.client.native import answer_in
from homebot.mqtt.client.paho_socket import PahoSocket
from homebot.mqtt.client.receiver import Frame, Receiver
from homebot.mqtt.client.requests import Answer, Requests
from homebot.mqtt.client.tcp_transport import dial_error, make_tls_context
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES, MqttSubscription, PacketType, Properties, ReasonCode

T = TypeVar("T")


@final
class AiomqttClient(MqttClient):
    """The client on aiomqtt 2, which publishes QoS 2 as QoS 1."""

    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        tls = await make_tls_context(options) if options.tls else None  # each time: certificates are renewed
        link = _AiomqttLink(options, version, receiver, tls)
        await link.open()
        return link


@final
class _AiomqttLink(ClientLink):
    """One aiomqtt client with its only link, as a second link would repeat publishes that failed long ago."""

    def __init__(
        self, options: MqttOptions, version: MqttVersion, receiver: Receiver, tls: ssl.SSLContext | None
    ) -> None:
        requests = Requests(Random(), options.timeout)  # noqa: S311 - paho chooses the identifiers
        super().__init__(options, version, receiver, requests)
        self._calls: set[anyio.CancelScope] = set()  # that end with the link
        self._client = aiomqtt.Client(**values.settings_of(options, version))
        client = self._paho = self._client._client  # noqa: SLF001 - aiomqtt's handle to paho
        client.connect_timeout = options.timeout
        client.disable_logger()  # it builds a line for each packet
        client.on_message = client.on_publish = None  # neither is paho's here, which would make objects for them
        self._then_connect: Any = client.on_connect
        self._then_disconnect: Any = client.on_disconnect
        client.on_connect, client.on_disconnect = self._on_connect, self._on_disconnect
        self._socket = PahoSocket(client, options, tls, self)

    async def open(self) -> None:
        try:
            await self._end_with_link(self._client.__aenter__())
        except aiomqtt.MqttError as error:
            reason = self._no_connection(error.__context__)
        except (LinkError, RefusedError) as error:
            if self._is_granted:
                return  # and lost in the same moment, which `wait_lost` tells
            reason = self._lost or error
        except BaseException:
            self.cut(LinkError("the connection attempt was cancelled"))
            raise
        else:
            return
        self.cut(reason)
        raise reason

    async def close(self, *, ends_session: bool) -> None:
        if self._lost is not None:
            return
        if ends_session and self._is_v5:
            properties = values.properties_of(PacketTypes.DISCONNECT, SessionExpiryInterval=0)
            self._paho.disconnect(properties=properties)
            await self._gone.wait()
        with suppress(aiomqtt.MqttError):
            await self._client.__aexit__(None, None, None)
        if self.transport is not None:
            await self.transport.wait_closed()

    async def publish(self, topic: str, payload: bytes, qos: int, properties: Properties, *, retain: bool) -> int:
        extra = None if properties is NO_PROPERTIES or not self._is_v5 else values.publish_properties(properties)
        qos = min(qos, values.MAX_QOS)
        self._check_granted(topic, len(payload) + values.packed_size(extra), qos, retain=retain)
        if qos:
            await self._window.acquire()
            try:
                self._check_alive()
                publish = partial(self._socket.publish, topic, payload, qos, extra, retain=retain)
                while (info := publish()).rc == paho.MQTT_ERR_QUEUE_SIZE:
                    pass  # that packet identifier still waits for its answer; the next
                self._check_alive()
                (reason,) = await self._answer(info.mid, "publish")
            finally:
                self._window.release()
            return reason
        self._socket.publish(topic, payload, qos, extra, retain=retain)
        await self._wait_until_taken()
        return 0

    async def subscribe(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        self._check_alive()
        version = self.grant.protocol
        filters: Any = [
            (subscription.filter, values.subscribe_options(subscription, version)) for subscription in subscriptions
        ]
        return await self._answer_to(self._paho.subscribe(filters), "subscribe")

    async def unsubscribe(self, filters: tuple[str, ...]) -> None:
        self._check_alive()
        await self._answer_to(self._paho.unsubscribe(list(filters)), "unsubscribe")

    def _no_connection(self, cause: BaseException | None) -> LinkError | RefusedError:
        if isinstance(cause, OSError) and not isinstance(cause, TimeoutError):
            return dial_error(cause, in_tls=self._options.tls)
        within = f"within {self._options.timeout:g} s"
        if self._socket.is_open:
            return UnansweredError(f"no answer to CONNECT {within}")
        return LinkError(f"no answer {within}")

    async def _answer_to(self, request: tuple[MQTTErrorCode, int | None], what: str) -> Answer:
        """Wait for the answer to a request that paho is about to send."""
        result, packet_id = request
        if packet_id is None:
            raise LinkError(f"{what} failed: {paho.error_string(result)}")
        return await self._answer(packet_id, what)

    async def _end_with_link(self, request: Awaitable[T]) -> T:
        """Wait for *request*, which the libraries do not tell about the end of the link; then raise why it ended."""
        with anyio.CancelScope() as scope:
            self._calls.add(scope)
            try:
                return await request
            finally:
                self._calls.discard(scope)
        raise LinkError(f"request failed, the link is lost: {self._lost}")

    def _lose(self, reason: LinkError | RefusedError) -> None:
        super()._lose(reason)
        self._socket.end()
        for scope in self._calls:
            scope.cancel()

    def _on_connect(
        self, client: paho.Client, userdata: Any, flags: paho.ConnectFlags, code: PahoReason, properties: Any
    ) -> None:
        if code.is_failure:
            self.cut(login_error(code.value))
            return
        keep_alive = getattr(properties, "ServerKeepAlive", 0) or self._options.keep_alive
        self._begin(values.grant_of(self.grant.protocol, flags, properties), keep_alive)
        self._then_connect(client, userdata, flags, code, properties)

    def _on_disconnect(
        self, client: paho.Client, userdata: Any, flags: paho.DisconnectFlags, code: PahoReason, properties: Any
    ) -> None:
        if flags.is_disconnect_packet_from_server:
            self.cut(disconnect_error(code.value))
        elif code.value == ReasonCode.SUCCESS:
            self._lose(LinkError("closed"))  # by us: the good-bye is still on its way
        else:
            is_unreadable = code.value == ReasonCode.PROTOCOL_ERROR
            reason = LinkError(UNREADABLE if is_unreadable else "the broker closed the connection")
            self.cut(reason if self._is_granted else early_end(reason, self._options))
        success = PahoReason(PacketTypes.DISCONNECT)  # otherwise aiomqtt keeps an unread error
        self._then_disconnect(client, userdata, flags, success, properties)

    def _handle(self, frame: Frame) -> None:
        kind = frame.first >> 4
        if kind in _ANSWERS:
            self._requests.answered(*answer_in(frame, is_v5=self._is_v5))
        if kind not in _ONLY_OURS:
            self._socket.feed(frame)


_ONLY_OURS: Final = frozenset({PacketType.SUBACK, PacketType.UNSUBACK})
_ANSWERS: Final = _ONLY_OURS | {PacketType.PUBACK}
