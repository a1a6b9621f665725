"""Commands by a Mosquitto to devices that are away, and by one that is frozen; over MQTT 3.1.1, nothing expires."""

import json
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

import anyio
import pytest
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, MosquittoBroker
from tests.patience import PATIENCE
from tests.turns import Turns

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Handle, Light
from homebot.devices.outcomes import Confirmed, Evidence, NoAnswer
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions, MqttProtocol
from homebot.runtime import Runtime
from homebot.testing.contexts import in_background

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
    pytest.mark.rooms("homeassistant"),
]

CREDENTIALS: Final = {"anna": "right"}
DEVICE: Final = {"device": {"identifiers": ["porch"], "name": "Porch"}}
LAMP: Final = {"name": "Lamp", "unique_id": "lamp", "command_topic": "lamp/set", "state_topic": "lamp"} | DEVICE
BELL: Final = {"name": "Bell", "unique_id": "bell", "command_topic": "bell/set"} | DEVICE
TIMEOUT: Final = 2.0


class AbsentDevice:
    """A lamp and a button with a session of their own on the broker, which are there only now and then."""

    def __init__(self, url: str) -> None:
        self.url = url
        options = MqttOptions.from_url(url, client_id="porch", protocol="3.1.1", session_expiry=3600)
        self._connection = MqttConnection(options, NativeClient, status_topic=None)

    async def announce(self) -> None:
        """Subscribe, announce both, and leave."""
        async with self._connection as connection:
            await connection.wait_connected()
            await connection.subscribe(MqttSubscription("lamp/set", qos=1), MqttSubscription("bell/set", qos=1))
            for kind, config in (("light", LAMP), ("button", BELL)):
                topic = f"homeassistant/{kind}/{config['unique_id']}/config"
                await connection.publish(topic, json.dumps(config).encode(), qos=1, retain=True)

    async def missed(self) -> Counter[tuple[str, bytes]]:
        """Come back, and return what the broker had kept."""
        found: Counter[tuple[str, bytes]] = Counter()
        async with self._connection as connection:
            await connection.wait_connected()
            await connection.subscribe(MqttSubscription("end"))
            await connection.publish("end")  # the broker sends it after what it kept
            while True:
                batch = await connection.receive()
                connection.ack(batch)
                for message in batch:
                    if message.topic == "end":
                        return found
                    found[message.topic, message.payload] += 1


@asynccontextmanager
async def announced() -> AsyncIterator[tuple[MosquittoBroker, AbsentDevice]]:
    async with MosquittoBroker(credentials=CREDENTIALS, policy=None) as broker:
        device = AbsentDevice(f"mqtt://anna:right@{broker.host}:{broker.port}")
        await device.announce()
        yield broker, device


@asynccontextmanager
async def home(device: AbsentDevice, protocol: MqttProtocol) -> AsyncIterator[tuple[Light, Handle]]:
    """Yield the lamp and the bell, once another process has announced them."""
    tables = {
        "gateways": {"mqtt": {"url": device.url, "act": True, "protocol": protocol}},
        "discovery": {"persist": False},
        "control": {"timeout": TIMEOUT},
    }
    turns = Turns()
    async with (
        Runtime(parse_config(tables, "test"), with_door=False) as runtime,
        Node(runtime.graph, "app") as node,
        in_background(turns.take_some),
    ):
        devices = Devices(node)
        with anyio.fail_after(PATIENCE):
            while True:
                lamps = await devices.find(Light)
                buttons = [one for one in await devices.find(Handle) if one.can("push")]
                if lamps and buttons:
                    break
                await anyio.sleep(0.05)
        yield lamps[0], buttons[0]
    print(f"longest turn {1000 * turns.longest:.1f} ms")


async def test_a_device_that_was_away_obeys_no_repetition_over_mqtt_3_1_1() -> None:
    async with announced() as (_, device):
        async with home(device, "3.1.1") as (lamp, _):
            outcome = await lamp.turn_on()
        assert isinstance(outcome, NoAnswer)
        assert outcome.waited >= TIMEOUT  # so it was sent three times
        assert await device.missed() == {("lamp/set", b"ON"): 1}


async def test_nothing_is_left_of_what_was_sent_to_a_device_that_was_away_for_longer_over_mqtt_5() -> None:
    async with announced() as (_, device):
        async with home(device, "5") as (lamp, _):
            await lamp.turn_on()
            await anyio.sleep(TIMEOUT)  # the time of Mosquitto
        assert await device.missed() == {}


async def test_a_press_for_a_device_that_is_away_was_accepted_by_its_network_and_not_confirmed() -> None:
    async with announced() as (_, device):
        async with home(device, "3.1.1") as (_, bell):
            outcome = await bell.command("push", value=True)
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.ACKNOWLEDGED
        assert outcome.text.startswith("accepted by the network after ")
        assert await device.missed() == {("bell/set", b"PRESS"): 1}


async def test_a_command_to_a_frozen_broker_has_no_answer_and_arrives_once() -> None:
    """It left this process, so that nobody may say that it was not sent."""
    async with announced() as (broker, device):
        async with home(device, "5") as (lamp, bell):
            with broker.frozen():
                outcomes = [await lamp.turn_on(), await bell.command("push", value=True)]
            for outcome in outcomes:
                assert isinstance(outcome, NoAnswer)
                assert outcome.is_unacknowledged
        assert await device.missed() == {("lamp/set", b"ON"): 1, ("bell/set", b"PRESS"): 1}
