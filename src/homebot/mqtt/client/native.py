"""The MQTT client port over a link in memory: real packets, no socket, no thread.

It answers as :class:`homebot.mqtt.client.aiomqtt_adapter.AiomqttClient` does; one contract test runs against both.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from random import Random
from typing import Protocol, final

from homebot.clock import Clock, LoopClock
from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt.client.memory_transport import LinkUser, MemorySocket
from homebot.mqtt.client.packet_values import filter_request, publish_properties
from homebot.mqtt.client.port import MqttCounters, MqttSubscription, PublishResult, SessionGrant
from homebot.mqtt.client.protocol import ClientProtocol
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import check_granted, reason_text
from homebot.mqtt.client.requests import Requests
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES as NOTHING
from homebot.mqtt.packets import (
    Connect,
    Disconnect,
    PacketType,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Suback,
    Subscribe,
    Unsubscribe,
    encode,
)
from homebot.mqtt.packets.properties import encode_properties
from homebot.mqtt.topics import validate_filter, validate_topic

__all__ = ["Dial", "MemoryClient"]


class Dial(Protocol):
    """Opens a link to a broker in memory."""

    def __call__(self, host: str, port: int, user: LinkUser) -> MemorySocket:
        """Bytes of the broker go to *user*; raises LinkError where nobody answers."""
        ...


@final
class MemoryClient:
    """The `MqttClient` port in memory; made by `MemoryBroker.make_client`, inside a running event loop.

    Args:
        options: Login and limits. "auto" speaks MQTT 5, which the broker in memory always does.
        dial: The way to the broker.
        clock: Paces log lines.
        random: Chooses the first packet identifier.

    Raises:
        UsageError: The options ask for TLS.
    """

    def __init__(
        self, options: MqttOptions, dial: Dial, *, clock: Clock | None = None, random: Random | None = None
    ) -> None:
        if options.tls:
            raise UsageError("a link in memory has no TLS: write mqtt:// instead of mqtts://")
        self._options = options
        self._dial = dial
        self._version = ProtocolVersion.V311 if options.protocol == "3.1.1" else ProtocolVersion.V5
        self._receiver = Receiver(options, LoopClock() if clock is None else clock)
        self._requests = Requests(Random() if random is None else random)  # noqa: S311 - identifiers are no secret
        self._protocol: ClientProtocol | None = None
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
        return await self._need_protocol().wait_lost()

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
        talk = self._need_protocol()
        talk.check_alive()
        extra = publish_properties(properties) if talk.version is ProtocolVersion.V5 else NOTHING
        if talk.granted is not None:
            size = len(payload) + len(encode_properties(extra, PacketType.PUBLISH))
            check_granted(talk.granted, topic, size, qos, retain=retain)
        packet = Publish(topic, payload, qos, retain, properties=extra)
        if qos:
            return await self._publish_and_wait(talk, packet)
        talk.send_packet(packet)
        await talk.wait_until_taken()
        return PublishResult()

    async def subscribe(self, *subscriptions: MqttSubscription) -> tuple[int, ...]:
        """Subscribe; see `MqttClient.subscribe`."""
        for subscription in subscriptions:
            validate_filter(subscription.filter)
        if not subscriptions:
            return ()
        talk = self._need_protocol()
        talk.check_alive()
        packet_id = self._requests.new_id()
        request = Subscribe(packet_id, tuple(filter_request(each) for each in subscriptions))
        answer = await talk.answer_to(request, packet_id, "subscribe")
        reasons = answer.reasons if isinstance(answer, Suback) else ()
        refused = [(each.filter, code) for each, code in zip(subscriptions, reasons, strict=False) if code.failed]
        if refused:
            names = ", ".join(repr(name) for name, _ in refused)
            raise RefusedError(f"the subscription to {names}", reason_text(refused[0][1]), refused[0][1])
        return tuple(int(reason) for reason in reasons)

    async def unsubscribe(self, *filters: str) -> None:
        """Take back subscriptions; see `MqttClient.unsubscribe`."""
        if not filters:
            return
        talk = self._need_protocol()
        talk.check_alive()
        packet_id = self._requests.new_id()
        await talk.answer_to(Unsubscribe(packet_id, filters), packet_id, "unsubscribe")

    async def receive(self) -> list[MqttMessage]:
        """All messages that are there; see `MqttClient.receive`."""
        return await self._receiver.take()

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        """Acknowledge; see `MqttClient.ack`."""
        data = self._receiver.settle(messages)
        if data and self._protocol is not None:
            self._protocol.put(data)

    def drop(self) -> None:
        """Cut the link; see `MqttClient.drop`."""
        if self._protocol is not None and self._up:
            self._protocol.drop()

    async def _publish_and_wait(self, talk: ClientProtocol, packet: Publish) -> PublishResult:
        await talk.window.acquire()
        try:
            talk.check_alive()
            packet_id = self._requests.new_id()
            answer = await talk.answer_to(packet._replace(packet_id=packet_id), packet_id, "publish")
        finally:
            talk.window.release()
        reason = answer.reason if isinstance(answer, Puback | Pubrec | Pubcomp) else 0
        if reason >= 0x80:
            raise RefusedError(f"the publish to {packet.topic!r}", reason_text(reason), reason)
        return PublishResult(reason)

    @asynccontextmanager
    async def _connected(self) -> AsyncIterator[SessionGrant]:
        if self._up:
            raise UsageError("this MQTT client is connected already")
        self._up = True
        try:
            talk = ClientProtocol(self._options, self._version, self._receiver, self._requests)
            session = await talk.open(self._dial(self._options.host, self._options.port, talk))
            self._protocol = talk
            try:
                yield session
            finally:
                self._close(talk)
        finally:
            self._up = False

    def _close(self, talk: ClientProtocol) -> None:
        options = self._options
        ends_session = talk.is_alive and options.session_ends_on_close and options.session_expiry > 0
        is_v5 = talk.version is ProtocolVersion.V5
        talk.close(ends_session=ends_session and is_v5)
        if ends_session and not is_v5:
            self._end_session()

    def _end_session(self) -> None:
        """MQTT 3.1.1 has one way to it: connect once more, with a clean session, and leave."""
        options = self._options
        password = None if options.password is None else options.password.get_secret_value().encode()
        connect = Connect(options.client_id, self._version, username=options.user, password=password)
        try:
            socket = self._dial(options.host, options.port, _NoUser())
        except LinkError:
            return  # the broker is gone, and with it most likely the session
        socket.write(encode(connect) + encode(Disconnect(), self._version))
        socket.close()

    def _need_protocol(self) -> ClientProtocol:
        if self._protocol is None or not self._up:
            raise LinkError(f"not connected to {self._options.url}")
        return self._protocol


class _NoUser:
    """A user that does not listen to the answers."""

    def data_received(self, data: bytes) -> None:
        pass

    def drained(self) -> None:
        pass

    def link_ended(self) -> None:
        pass
