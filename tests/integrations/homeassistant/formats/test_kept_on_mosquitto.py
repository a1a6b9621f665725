"""What a real Mosquitto with its default limits keeps of a large house is taken in whole."""

import json

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.system

LAMPS = 1500
"""More than one subscription of QoS 1 would get, which is 1,020."""


async def keep(url: str) -> None:
    async with MqttConnection(MqttOptions.from_url(url), AiomqttClient, status_topic=None) as devices:
        await devices.wait_connected()
        for number in range(LAMPS):
            last = number == LAMPS - 1
            config = {
                "unique_id": f"lamp{number}",
                "device": {"identifiers": [f"lamp{number}"]},
                "command_topic": f"lamp{number}/set",
                "state_topic": f"lamp{number}/state",
            }
            await devices.publish(f"lamp{number}/state", b"ON", retain=True)
            await devices.publish(
                f"homeassistant/light/lamp{number}/config", json.dumps(config).encode(), qos=int(last), retain=True
            )


async def test_every_lamp_and_its_state_is_found(mosquitto_url: str) -> None:
    await keep(mosquitto_url)
    settings = MqttGatewaySettings(url=mosquitto_url, root="home425", conventions=("thesis", "homeassistant"))
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        anyio.create_task_group() as tasks,
    ):
        gateway = MqttGateway(node, settings)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        sightings = watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=latched)
        reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=latched)
        await tasks.start(gateway.serve)
        with anyio.fail_after(PATIENCE):
            found = {(await sightings.receive()).key for _ in range(LAMPS)}
            told = {(await reports.receive()).key for _ in range(LAMPS)}
        tasks.cancel_scope.cancel()
    assert len(found) == len(told) == LAMPS
