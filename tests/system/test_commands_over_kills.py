"""Commands to a lamp whose broker is killed again and again: what is confirmed has happened, nothing happens late."""

import json
from collections import Counter
from dataclasses import dataclass, field

import anyio
import pytest
from tests.mqtt.client.broker_process import BrokerProcess
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, MosquittoBroker
from tests.patience import PATIENCE
from tests.sizes import nightly, size

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Handle, Light
from homebot.devices.outcomes import Confirmed, Evidence, Outcome
from homebot.gateways.mqtt.command_publisher import COMMAND_ID
from homebot.graph import Node
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = [pytest.mark.system, pytest.mark.rooms("homeassistant")]

KILLS = size(3, 10)
LATEST = 12.0
"""Seconds: the longest wait for an answer, and one more second, in which brokers count; and a busy machine."""
CREDENTIALS = {"anna": "right"}
LAMP = {
    "unique_id": "lamp",
    "name": "Lamp",
    "schema": "json",
    "brightness": True,
    "brightness_scale": 100,
    "supported_color_modes": ["brightness"],
    "state_topic": "lamp/state",
    "command_topic": "lamp/set",
    "device": {"identifiers": ["lamp"], "name": "Lamp"},
}
BUTTON = {
    "unique_id": "button",
    "name": "Button",
    "command_topic": "button/set",
    "device": {"identifiers": ["button"], "name": "Button"},
}


@dataclass
class RealDevices:
    """A lamp and a button on the broker, and what they did."""

    obeyed: list[tuple[float, int]] = field(default_factory=list)
    pressed: list[str] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    """The ids of all commands that were carried out."""

    async def live(self, connection: MqttConnection) -> None:
        await connection.subscribe(
            MqttSubscription("lamp/set", qos=1), MqttSubscription("button/set", qos=1), every_link=True
        )
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._announce, connection)
            while True:
                batch = await connection.receive()
                connection.ack(batch)
                for message in batch:
                    command_id = dict(message.properties.user_properties)[COMMAND_ID]
                    self.ids.append(command_id)
                    if message.topic == "button/set":
                        self.pressed.append(command_id)
                    elif (level := json.loads(message.payload).get("brightness")) is not None:
                        self.obeyed.append((anyio.current_time(), level))
                        tasks.start_soon(self._say, connection, level)

    async def _say(self, connection: MqttConnection, level: int) -> None:
        await connection.publish("lamp/state", json.dumps({"state": "ON", "brightness": level}).encode(), qos=0)

    async def _announce(self, connection: MqttConnection) -> None:
        async for state in connection.states():
            if state.phase is LinkPhase.CONNECTED:
                for kind, config in (("light", LAMP), ("button", BUTTON)):
                    topic = f"homeassistant/{kind}/{config['unique_id']}/config"
                    await connection.publish(topic, json.dumps(config).encode(), qos=0, retain=True)


@nightly
@pytest.mark.no_cover
@pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed")
async def test_mosquitto_is_killed() -> None:
    await check_commands_over_kills(MosquittoBroker(credentials=CREDENTIALS, policy=None))


@pytest.mark.no_cover
async def test_the_embedded_broker_is_killed_and_has_forgotten_everything() -> None:
    await check_commands_over_kills(BrokerProcess(credentials=CREDENTIALS))


@pytest.mark.no_cover
async def test_the_embedded_broker_drops_all_links_and_remembers_its_sessions() -> None:
    await check_commands_over_kills(Broker(credentials=CREDENTIALS))


async def check_commands_over_kills(broker: MosquittoBroker | BrokerProcess | Broker) -> None:
    """What is confirmed has happened; nothing happens after its time, or twice."""
    devices_there = RealDevices()
    given: list[tuple[float, float, int, Outcome]] = []
    presses: list[Outcome] = []
    async with broker:
        url = f"mqtt://anna:right@127.0.0.1:{broker.port}"
        tables = {
            "gateways": {"mqtt": {"url": url, "act": True, "responses": True}},
            "discovery": {"persist": False},
            "control": {"rate_limit": False},
        }
        config = parse_config(tables, "test")
        other = MqttOptions.from_url(url, client_id="devices")
        async with (
            MqttConnection(other, NativeClient, status_topic=None) as connection,
            Runtime(config, with_door=False) as runtime,
            Node(runtime.graph, "app") as node,
            anyio.create_task_group() as tasks,  # which ends before the connection that its tasks read
        ):
            tasks.start_soon(devices_there.live, connection)
            lamp, button = await _handles(Devices(node))
            is_over, confirmed_again, pressed = anyio.Event(), [anyio.Event()], anyio.Event()

            async def kill() -> None:
                with anyio.fail_after(PATIENCE):
                    await pressed.wait()  # later the silent button gets no command for ten seconds after each kill
                for number in range(KILLS):
                    confirmed_again[0] = anyio.Event()
                    with anyio.fail_after(PATIENCE):
                        await confirmed_again[0].wait()
                    await anyio.sleep(0.05 * number)  # so that kills hit each part of a command
                    await broker.stop(abrupt=True)
                    await broker.start()
                is_over.set()

            tasks.start_soon(kill)
            while not is_over.is_set():
                level = 5 + 10 * (len(given) % 10)
                began = anyio.current_time()
                outcome = await lamp.command("level", float(level))
                given.append((began, anyio.current_time(), level, outcome))
                if isinstance(outcome, Confirmed):
                    confirmed_again[0].set()
                if len(given) % 3 == 0:
                    presses.append(await button.command("push", value=True))
                    if isinstance(presses[-1], Confirmed):
                        pressed.set()
            tasks.cancel_scope.cancel()
    print(f"{len(given)} commands: {Counter(type(one[-1]).__name__ for one in given)}; {len(presses)} presses")
    obeyed = devices_there.obeyed
    confirmed = [one for one in given if isinstance(one[-1], Confirmed)]
    assert len(confirmed) >= KILLS
    for began, ended, level, outcome in confirmed:
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED
        assert any(began <= at <= ended and done == level for at, done in obeyed)
    for at, level in obeyed:
        latest = max(began for began, _, wanted, _ in given if wanted == level and began <= at)
        assert at - latest < LATEST
    assert len(set(devices_there.ids)) == len(devices_there.ids)  # none twice, also where a report was lost
    assert {one.command_id for one in presses if isinstance(one, Confirmed)} <= set(devices_there.pressed)


async def _handles(devices: Devices) -> tuple[Light, Handle]:
    with anyio.fail_after(PATIENCE):
        while True:
            lamps = await devices.find(Light)
            buttons = [one for one in await devices.find(Handle) if one.can("push")]
            if lamps and buttons:
                return lamps[0], buttons[0]
            await anyio.sleep(0.05)
