"""Gateways of one group share the texts of devices: each message goes to one of them."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.devices import RawMessage, SubscribeToTopic
from homebot.devices.services import SubscribeToTopicRequest
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

SENSOR = "home425/temperature/attic/out"
END = b"end"


class Member:
    """A gateway of the group ``attic``, in a homebot of its own, and the texts that it heard."""

    def __init__(self) -> None:
        self.heard: list[bytes] = []
        self.ended = anyio.Event()

    def hear(self, message: RawMessage) -> None:
        if message.payload == END:
            self.ended.set()
        else:
            self.heard.append(message.payload)


@asynccontextmanager
async def member_on(url: str) -> AsyncIterator[Member]:
    member = Member()
    settings = MqttGatewaySettings(url=url, root="home425", conventions=("thesis",), share="attic")
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        anyio.create_task_group() as tasks,
    ):
        gateway = MqttGateway(node, settings)
        assert gateway.observes_because == "it shares the group attic; a homebot without share sends commands"
        await tasks.start(gateway.serve)
        asking = watcher.create_client(SubscribeToTopic, gateway.names.subscribe)
        answer = await asking.call(SubscribeToTopicRequest(topic=SENSOR, listener=watcher.full_name))
        watcher.create_subscription(RawMessage, answer.data_topic, member.hear, 1000)
        yield member
        tasks.cancel_scope.cancel()


async def check_sharing(url: str) -> None:
    async with (
        member_on(url) as one,
        member_on(url) as other,
        MqttConnection(MqttOptions.from_url(url), AiomqttClient, status_topic=None) as device,
    ):
        await device.wait_connected()
        for number in range(200):
            await device.publish(SENSOR, b"%d" % number, qos=1)
        with anyio.fail_after(PATIENCE):
            while not (one.ended.is_set() and other.ended.is_set()):  # the last of all that a member gets
                await device.publish(SENSOR, END, qos=1)
    assert sorted(map(int, one.heard + other.heard)) == [*range(200)]
    assert min(len(one.heard), len(other.heard)) > 0


@pytest.mark.system
async def test_on_mosquitto_each_message_reaches_one_of_two_homebots(mosquitto_url: str) -> None:
    await check_sharing(mosquitto_url)


@pytest.mark.slow
async def test_on_the_embedded_broker_each_message_reaches_one_of_two_homebots(embedded_broker_url: str) -> None:
    await check_sharing(embedded_broker_url)


def test_a_gateway_that_shares_only_observes_also_on_the_embedded_broker() -> None:
    """The report behind its command could reach another gateway of the group."""
    settings = MqttGatewaySettings(conventions=("thesis",), share="attic")
    resolved = MqttGateway.resolve(settings, GatewayContext.of(HostedBroker("mqtt://127.0.0.1:1883")))
    assert isinstance(resolved, MqttGatewaySettings)
    assert not resolved.act
    assert MqttGateway.observes(settings)
