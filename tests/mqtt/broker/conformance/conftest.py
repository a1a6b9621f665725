"""What the Eclipse Paho interoperability tests expect, in our own words: clients that answer as clients should."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from tests.mqtt.broker.conftest import MemoryClient, NewState, Stranger

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerState, RefusedFilters


class Talker:
    """A client that completes every exchange; what it got is in ``messages`` and ``others``.

    Attributes:
        deaf: Takes messages no longer, and answers nothing.
    """

    def __init__(self, client: MemoryClient) -> None:
        self.client = client
        self.messages: list[mqtt.Publish] = []
        self.others: list[mqtt.Packet] = []
        self.deaf = False
        self._open: dict[int | None, mqtt.Publish] = {}
        self._last_id = 0

    @property
    def connack(self) -> mqtt.Connack:
        """What the login was answered with."""
        (connack,) = [packet for packet in self.others if isinstance(packet, mqtt.Connack)]
        return connack

    @property
    def payloads(self) -> list[bytes]:
        return [message.payload for message in self.messages]

    def send(self, *packets: mqtt.Packet) -> None:
        self.client.send(*packets)
        self.settle()

    def settle(self, *others: Talker) -> None:
        """Let this client and *others* take and answer until nothing comes any more."""
        while any(talker._take() for talker in (self, *others)):
            pass

    def subscribe(self, *requests: mqtt.MqttSubscription | str, qos: int = 2, identifier: int = 0) -> mqtt.Suback:
        filters = tuple(mqtt.MqttSubscription(each, qos) if isinstance(each, str) else each for each in requests)
        properties = mqtt.Properties(subscription_identifiers=(identifier,)) if identifier else mqtt.NO_PROPERTIES
        self.send(mqtt.Subscribe(self._next_id(), filters, properties))
        return [packet for packet in self.others if isinstance(packet, mqtt.Suback)][-1]

    def publish(
        self, topic: str, payload: bytes = b"x", qos: int = 0, *, retain: bool = False, **properties: object
    ) -> None:
        packet_id = self._next_id() if qos else None
        extra = mqtt.Properties(**properties) if properties else mqtt.NO_PROPERTIES  # type: ignore[arg-type] # names of properties
        self.send(mqtt.Publish(topic, payload, qos, retain, packet_id=packet_id, properties=extra))

    def publish_each_qos(self, topic: str, **properties: object) -> None:
        """Three messages: payload and QoS are 0, 1 and 2."""
        for qos in range(3):
            self.publish(topic, b"%d" % qos, qos, retain=False, **properties)

    def leave(self, **properties: object) -> None:
        """Disconnect as one should."""
        self.send(mqtt.Disconnect(properties=mqtt.Properties(**properties)))  # type: ignore[arg-type] # names of properties
        self.client.peer.lost()

    def ended_with(self) -> list[mqtt.Disconnect]:
        """The goodbyes of the broker, once it has closed the connection."""
        assert self.client.link.closed
        return [packet for packet in self.others if isinstance(packet, mqtt.Disconnect)]

    def _next_id(self) -> int:
        self._last_id += 1
        return self._last_id

    def _take(self) -> bool:
        packets = [] if self.deaf else self.client.take()
        for packet in packets:
            self._answer(packet)
        return bool(packets)

    def _answer(self, packet: mqtt.Packet) -> None:
        if isinstance(packet, mqtt.Publish):
            if packet.qos == 2:
                self._open[packet.packet_id] = packet
                self.client.send(mqtt.Pubrec(packet.packet_id or 0))
                return
            self.messages.append(packet)
            if packet.qos:
                self.client.send(mqtt.Puback(packet.packet_id or 0))
        elif isinstance(packet, mqtt.Pubrel):
            self.messages.append(self._open.pop(packet.packet_id))
            self.client.send(mqtt.Pubcomp(packet.packet_id))
        elif isinstance(packet, mqtt.Pubrec):
            self.client.send(mqtt.Pubrel(packet.packet_id))
        else:
            self.others.append(packet)


Meet = Callable[..., Talker]


@pytest.fixture
def state(new_state: NewState) -> BrokerState:
    """With the settings that the Paho tests ask of a server."""
    return new_state(keep_alive=60, policy=RefusedFilters({"test/nosubscribe"}))


@pytest.fixture
def meet(stranger: Stranger) -> Meet:
    """Send a CONNECT; whether it was accepted is in ``connack``."""

    def make(
        client_id: str = "a",
        version: mqtt.ProtocolVersion = mqtt.ProtocolVersion.V5,
        *,
        clean: bool = True,
        keep_alive: int = 0,
        will: mqtt.Will | None = None,
        is_bridge: bool = False,
        **properties: object,
    ) -> Talker:
        talker = Talker(stranger(version))
        wanted = mqtt.Properties(**properties)  # type: ignore[arg-type] # names of properties
        connect = mqtt.Connect(client_id, version, clean, keep_alive, will=will, properties=wanted, is_bridge=is_bridge)
        talker.send(connect)
        return talker

    return make
