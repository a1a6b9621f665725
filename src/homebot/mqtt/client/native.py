"""The MQTT client port on our own codec: over TCP and TLS, or over a link in memory without socket and thread.

It keeps every promise of the port. It answers as :class:`homebot.mqtt.client.aiomqtt_adapter.AiomqttClient` does; one
contract test runs against both, and says where they differ.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import replace
from random import Random
from typing import final

import anyio

from homebot.clock import Clock, LoopClock
from homebot.errors import HomebotError, LinkError, RefusedError, UsageError
from homebot.logger import get_logger
from homebot.mqtt.client.packet_values import filter_request, publish_properties
from homebot.mqtt.client.port import MqttCounters, MqttSubscription, PublishResult, SessionGrant
from homebot.mqtt.client.protocol import ClientProtocol
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import check_granted, reason_text
from homebot.mqtt.client.requests import Requests
from homebot.mqtt.client.tcp_transport import dial_tcp
from homebot.mqtt.client.transport import Dial
from homebot.mqtt.client.version_choice import ClosedEarlyError, VersionChoice
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES as NOTHING
from homebot.mqtt.packets import PacketType, ProtocolVersion, Publish, Subscribe, Unsubscribe
from homebot.mqtt.packets.properties import encode_properties
from homebot.mqtt.topics import validate_filter, validate_topic

__all__ = ["NativeClient"]

_GOODBYE = 1.0
"""Seconds that ending a session may take; the broker may be gone already."""

_log = get_logger()


@final
class NativeClient:
    """The `MqttClient` port on our own codec; make it inside a running event loop.

    Args:
        options: Broker, login and limits.
        dial: The way to the broker.
        clock: Paces log lines.
        random: Chooses the first packet identifier.
    """

    def __init__(
        self,
        options: MqttOptions,
        dial: Dial = dial_tcp,
        *,
        clock: Clock | None = None,
        random: Random | None = None,
    ) -> None:
        self._options = options
        self._dial = dial
        self._choice = VersionChoice(options)
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
            size = len(payload)
            if extra is not NOTHING:
                size += len(encode_properties(extra, PacketType.PUBLISH))
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
        reasons = await talk.answer_to(request, packet_id, "subscribe")
        refused = [(each.filter, code) for each, code in zip(subscriptions, reasons, strict=False) if code >= 0x80]
        if refused:
            names = ", ".join(repr(name) for name, _ in refused)
            raise RefusedError(f"the subscription to {names}", reason_text(refused[0][1]), refused[0][1])
        return reasons

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
            self._protocol.acknowledge(data)

    def drop(self) -> None:
        """Cut the link; see `MqttClient.drop`."""
        if self._protocol is not None and self._up:
            self._protocol.drop()

    async def _publish_and_wait(self, talk: ClientProtocol, packet: Publish) -> PublishResult:
        await talk.window.acquire()
        try:
            talk.check_alive()
            packet_id = self._requests.new_id()
            (reason,) = await talk.answer_to(packet._replace(packet_id=packet_id), packet_id, "publish")
        finally:
            talk.window.release()
        if reason >= 0x80:
            raise RefusedError(f"the publish to {packet.topic!r}", reason_text(reason), reason)
        return PublishResult(reason)

    @asynccontextmanager
    async def _connected(self) -> AsyncIterator[SessionGrant]:
        if self._up:
            raise UsageError("this MQTT client is connected already")
        self._up = True
        try:
            talk, session = await self._open()
            self._protocol = talk
            try:
                yield session
            finally:
                await self._close(talk)
        finally:
            self._up = False

    async def _open(self) -> tuple[ClientProtocol, SessionGrant]:
        try:
            try:
                opened = await self._open_once()
            except (RefusedError, ClosedEarlyError) as error:
                if not self._choice.falls_back(error):
                    raise
                opened = await self._open_once()
        except BaseException:
            self._choice.failed()
            raise
        self._choice.succeeded()
        return opened

    async def _open_once(self) -> tuple[ClientProtocol, SessionGrant]:
        version = ProtocolVersion.V5 if self._choice.version == "5" else ProtocolVersion.V311
        talk = ClientProtocol(self._options, version, self._receiver, self._requests)
        return talk, await talk.open(self._dial)

    async def _close(self, talk: ClientProtocol) -> None:
        options = self._options
        ends_session = talk.is_alive and options.session_ends_on_close and options.session_expiry > 0
        is_v5 = talk.version is ProtocolVersion.V5
        await talk.close(ends_session=ends_session and is_v5)
        if ends_session and not is_v5:
            await self._end_session(talk.version)

    async def _end_session(self, version: ProtocolVersion) -> None:
        """End it as MQTT 3.1.1 has it: connect once more, with a clean session, and leave.

        Source: MQTT Version 3.1.1, section 3.1.2.4.
        """
        options = replace(self._options, session_expiry=0, will=None)
        with anyio.CancelScope(shield=True), anyio.move_on_after(_GOODBYE):
            last = ClientProtocol(options, version, Receiver(options, LoopClock()), self._requests)
            try:
                await last.open(self._dial)
            except HomebotError as error:  # the broker is gone, and with it most likely the session
                _log.debug("mqtt.session_left", broker=options.url, reason=str(error))
                return
            await last.close(ends_session=False)

    def _need_protocol(self) -> ClientProtocol:
        if self._protocol is None or not self._up:
            raise LinkError(f"not connected to {self._options.url}")
        return self._protocol
