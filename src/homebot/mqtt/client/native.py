"""The MQTT client port on our own codec: over TCP and TLS, or over a link in memory without socket and thread.

It keeps every promise of the port.
"""

from __future__ import annotations

from collections.abc import Iterable
from random import Random
from typing import final

from homebot.clock import Clock
from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client.base import BaseClient, ClientLink
from homebot.mqtt.client.packet_values import filter_request, publish_properties
from homebot.mqtt.client.port import MqttSubscription, SessionGrant
from homebot.mqtt.client.protocol import ClientProtocol
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import check_granted
from homebot.mqtt.client.requests import Requests
from homebot.mqtt.client.tcp_transport import dial_tcp
from homebot.mqtt.client.transport import Dial
from homebot.mqtt.client.version_choice import MqttVersion
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES as NOTHING
from homebot.mqtt.packets import PacketType, ProtocolVersion, Publish, Subscribe, Unsubscribe
from homebot.mqtt.packets.properties import encode_properties

__all__ = ["NativeClient"]

_CODEC = {"5": ProtocolVersion.V5, "3.1.1": ProtocolVersion.V311}


@final
class NativeClient(BaseClient):
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
        super().__init__(options, clock)
        self._dial = dial
        self._requests = Requests(Random() if random is None else random)  # noqa: S311 - identifiers are no secret

    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        protocol = ClientProtocol(options, _CODEC[version], receiver, self._requests)
        return _NativeLink(protocol, await protocol.open(self._dial), receiver, self._requests)


@final
class _NativeLink:
    def __init__(self, protocol: ClientProtocol, grant: SessionGrant, receiver: Receiver, requests: Requests) -> None:
        self.grant = grant
        self._protocol = protocol
        self._receiver = receiver
        self._requests = requests

    @property
    def is_alive(self) -> bool:
        return self._protocol.is_alive

    async def wait_lost(self) -> LinkError | RefusedError:
        return await self._protocol.wait_lost()

    async def publish(
        self, topic: str, payload: bytes, qos: int, properties: MessageProperties, *, retain: bool
    ) -> int:
        protocol = self._protocol
        protocol.check_alive()
        extra, size = NOTHING, len(payload)
        if properties is not NO_PROPERTIES and protocol.version is ProtocolVersion.V5:
            extra = publish_properties(properties)
            size += len(encode_properties(extra, PacketType.PUBLISH))
        check_granted(self.grant, topic, size, qos, retain=retain)
        packet = Publish(topic, payload, qos, retain, properties=extra)
        if qos:
            return await self._publish_and_wait(packet)
        protocol.send_packet(packet)
        await protocol.wait_until_taken()
        return 0

    async def subscribe(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        self._protocol.check_alive()
        packet_id = self._requests.new_id()
        request = Subscribe(packet_id, tuple(filter_request(each) for each in subscriptions))
        return await self._protocol.answer_to(request, packet_id, "subscribe")

    async def unsubscribe(self, filters: tuple[str, ...]) -> None:
        self._protocol.check_alive()
        packet_id = self._requests.new_id()
        await self._protocol.answer_to(Unsubscribe(packet_id, filters), packet_id, "unsubscribe")

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        if data := self._receiver.settle(messages):
            self._protocol.acknowledge(data)

    async def close(self, *, ends_session: bool) -> None:
        await self._protocol.close(ends_session=ends_session and self._protocol.version is ProtocolVersion.V5)

    def cut(self, reason: LinkError | RefusedError) -> None:
        self._protocol.cut(reason)

    async def _publish_and_wait(self, packet: Publish) -> int:
        protocol = self._protocol
        await protocol.window.acquire()
        try:
            protocol.check_alive()
            packet_id = self._requests.new_id()
            (reason,) = await protocol.answer_to(packet._replace(packet_id=packet_id), packet_id, "publish")
        finally:
            protocol.window.release()
        return reason
