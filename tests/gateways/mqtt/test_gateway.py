"""The MQTT gateway and brokers on sockets: bursts, restarts, logins, and what a client cannot do."""

import platform
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.devices import RawMessage, SubscribeToTopic
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.services import SubscribeToTopicRequest
from homebot.errors import RefusedError
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.slow

LAMP = "home425/lights/lamp/out"


@asynccontextmanager
async def gateway_on(url: str, client: str = "aiomqtt") -> AsyncIterator[tuple[MqttGateway, Node]]:
    """Run a gateway on the broker at *url* in home ``home425``; yield it and a node that watches it."""
    table = {"url": url, "root": "home425", "conventions": ("thesis",), "client": client}
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        anyio.create_task_group() as tasks,
    ):
        gateway = MqttGateway(node, MqttGatewaySettings.model_validate(table))
        await tasks.start(gateway.serve)
        yield gateway, watcher
        tasks.cancel_scope.cancel()


async def test_a_burst_of_qos_0_does_not_overrun_an_inbox_with_a_fast_reader(embedded_broker_url: str) -> None:
    """3,000 messages that arrive in a few reads, three times what the inbox holds."""
    everything = anyio.Event()
    heard: list[bytes] = []

    def hear(message: RawMessage) -> None:
        heard.append(message.payload)
        if len(heard) == 3000:
            everything.set()

    options = MqttOptions.from_url(embedded_broker_url)
    async with (
        MqttConnection(options, AiomqttClient, status_topic=None) as device,
        gateway_on(embedded_broker_url) as (gateway, watcher),
    ):
        asking = watcher.create_client(SubscribeToTopic, gateway.names.subscribe)
        answer = await asking.call(SubscribeToTopicRequest(topic=LAMP, listener=watcher.full_name))
        watcher.create_subscription(RawMessage, answer.data_topic, hear, 1000)
        await device.wait_connected()
        for number in range(3000):
            await device.publish(LAMP, b"%d" % number, qos=0)

        with anyio.fail_after(PATIENCE):
            await everything.wait()
        assert heard == [b"%d" % number for number in range(3000)]


async def test_one_status_topic_is_all_that_runs_leave_at_the_broker(embedded_broker_url: str) -> None:
    """Its name does not change from run to run."""
    for _ in range(3):
        async with gateway_on(embedded_broker_url):
            pass
    async with MqttConnection(MqttOptions.from_url(embedded_broker_url), AiomqttClient, status_topic=None) as late:
        await late.subscribe(MqttSubscription("homebot/#", qos=1))
        await late.wait_connected()
        with anyio.fail_after(PATIENCE):
            (status,) = await late.receive()
    assert status.topic == f"homebot/{platform.node()}/mqtt/status"
    assert status.payload == b"offline"


@pytest.mark.parametrize("client", ["aiomqtt", "native"])
async def test_a_wrong_password_is_found_before_the_start(client: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """That a port was open counted as well, and the first message of the gateway was that its login is refused."""
    async with Broker(credentials={"robot": "right"}) as broker:
        table = {"url": broker.url, "user": "robot", "password_env": "PASSWORD", "client": client}
        settings = MqttGatewaySettings.model_validate(table)
        monkeypatch.setenv("PASSWORD", "right")
        await MqttGateway.reach(settings)
        monkeypatch.setenv("PASSWORD", "wrong")
        with pytest.raises(RefusedError, match="check user and password_file"):
            await MqttGateway.reach(settings)


@pytest.mark.parametrize("client", ["aiomqtt", "native"])
async def test_its_health_notes_no_limit_of_its_client(embedded_broker_url: str, client: str) -> None:
    """That aiomqtt publishes QoS 2 as QoS 1 stood in every report, and nobody can act on it."""
    async with gateway_on(embedded_broker_url, client) as (gateway, watcher):
        asked = watcher.create_client(GetHealth, gateway.names.health)
        health = await asked.call(HealthRequest())
    assert health.notes == ()
    assert health.troubles == ()
