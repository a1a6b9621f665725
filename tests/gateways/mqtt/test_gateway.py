"""The MQTT gateway and brokers on sockets: bursts, restarts, logins, and what a client cannot do."""

import platform
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial

import anyio
import anyio.abc
import anyio.lowlevel
import pytest
from tests.patience import PATIENCE

from homebot.devices import RawMessage, SubscribeToTopic
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.services import SubscribeToTopicRequest
from homebot.errors import LinkError, RefusedError
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.slow

LAMP = "home425/lights/lamp/out"


@dataclass
class House:
    """A gateway, a node that watches it, and a client on the devices' side of the broker."""

    gateway: MqttGateway
    watcher: Node
    devices: MqttConnection

    async def say(self, payload: bytes, *, qos: int = 1) -> None:
        await self.devices.publish(LAMP, payload, qos=qos)

    async def inbox(self) -> str:
        """Listen to the lamp, and return the topic where its messages come."""
        client = self.watcher.create_client(SubscribeToTopic, self.gateway.names.subscribe)
        return (await client.call(SubscribeToTopicRequest(topic=LAMP, listener=self.watcher.full_name))).data_topic


@asynccontextmanager
async def gateway_on(url: str, client: str = "aiomqtt") -> AsyncIterator[House]:
    """Run a gateway on the broker at *url* in home ``home425``."""
    table = {"url": url, "root": "home425", "conventions": ("thesis",), "client": client}
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        MqttConnection(MqttOptions.from_url(url), AiomqttClient, status_topic=None) as devices,
        anyio.create_task_group() as tasks,
    ):
        gateway = MqttGateway(node, MqttGatewaySettings.model_validate(table))
        await tasks.start(gateway.serve)
        await devices.wait_connected()
        yield House(gateway, watcher, devices)
        tasks.cancel_scope.cancel()


async def test_a_burst_of_qos_0_does_not_overrun_an_inbox_with_a_fast_reader(embedded_broker_url: str) -> None:
    """3,000 messages that arrive in a few reads, three times what the inbox holds."""
    everything = anyio.Event()
    heard: list[bytes] = []

    def hear(message: RawMessage) -> None:
        heard.append(message.payload)
        if len(heard) == 3000:
            everything.set()

    async with gateway_on(embedded_broker_url) as house:
        house.watcher.create_subscription(RawMessage, await house.inbox(), hear, 1000)
        for number in range(3000):
            await house.say(b"%d" % number, qos=0)

        with anyio.fail_after(PATIENCE):
            await everything.wait()
        assert heard == [b"%d" % number for number in range(3000)]


@pytest.mark.parametrize("abrupt", [False, True])
async def test_a_restarted_broker_loses_no_acknowledged_message_and_the_gateway_is_back_in_time(
    *, abrupt: bool
) -> None:
    """Every publish of QoS 1 that was acknowledged reaches the listener, across three restarts."""
    async with Broker() as broker, gateway_on(broker.url) as house:
        inbox = house.watcher.create_subscription(RawMessage, await house.inbox(), qos_profile=1000)
        acknowledged: set[bytes] = set()
        with anyio.fail_after(PATIENCE):
            async with anyio.create_task_group() as tasks:
                for number in range(600):
                    if number % 150 == 149:
                        tasks.start_soon(partial(broker.restart, keep_sessions=True, abrupt=abrupt))
                    payload = str(number).encode()
                    while payload not in acknowledged:
                        try:
                            await house.say(payload)
                            acknowledged.add(payload)
                        except LinkError:
                            await anyio.lowlevel.checkpoint()
                            await house.devices.wait_connected()
        received: set[bytes] = set()
        with anyio.fail_after(PATIENCE):
            while not acknowledged <= received:
                received.add((await inbox.receive()).payload)


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


@pytest.mark.parametrize(("client", "notes"), [("aiomqtt", 1), ("native", 0)])
async def test_its_health_tells_what_its_client_cannot_do(embedded_broker_url: str, client: str, notes: int) -> None:
    async with gateway_on(embedded_broker_url, client) as house:
        asked = house.watcher.create_client(GetHealth, house.gateway.names.health)
        health = await asked.call(HealthRequest())
    assert len(health.notes) == notes
    assert health.troubles == ()
