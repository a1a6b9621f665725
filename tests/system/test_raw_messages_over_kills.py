"""Raw messages that an app hears while Mosquitto is killed again and again, beside those that plain paho hears."""

import json
import threading
from collections import Counter
from functools import partial
from typing import Any, Final

import anyio
import pytest
from paho.mqtt import client as paho
from paho.mqtt.enums import CallbackAPIVersion
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, MosquittoBroker
from tests.patience import PATIENCE, until
from tests.turns import Turns

from homebot.config import parse_config
from homebot.devices import RawMessage, SubscribeToTopic
from homebot.devices.services import SubscribeToTopicRequest
from homebot.graph import Client, Node
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime
from homebot.testing.contexts import in_background

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
    pytest.mark.rooms("homeassistant"),
]

SENSORS: Final = 50
KILLS: Final = 3
SETTINGS: Final = "autosave_interval 1\n"
"""What it knows is written down each second, so that it comes back with its sessions and its retained messages."""


class PlainListener:
    """A paho client of the usual kind: one session, one subscription, a thread of its own."""

    def __init__(self, port: int) -> None:
        self.heard: Counter[bytes] = Counter()
        self.is_subscribed = threading.Event()
        self._client = paho.Client(CallbackAPIVersion.VERSION2, client_id="plain", clean_session=False)
        self._client.username_pw_set("anna", "right")
        self._client.on_connect = self._on_connect
        self._client.on_subscribe = lambda *_: self.is_subscribed.set()
        self._client.on_message = lambda _client, _data, message: self.heard.update([bytes(message.payload)])
        self._client.reconnect_delay_set(1, 1)
        self._client.connect("127.0.0.1", port)
        self._client.loop_start()

    def _on_connect(self, client: paho.Client, _data: object, flags: paho.ConnectFlags, *_: Any) -> None:
        if not flags.session_present:
            client.subscribe("sensors/+", 1)

    def stop(self) -> None:
        self._client.disconnect()
        self._client.loop_stop()


async def announce(connection: MqttConnection) -> None:
    for number in range(SENSORS):
        device = {"identifiers": [f"sensor-{number}"], "name": f"Sensor {number}"}
        config = {"unique_id": f"sensor-{number}", "state_topic": f"sensors/{number}", "device": device}
        topic = f"homeassistant/sensor/sensor-{number}/config"
        await connection.publish(topic, json.dumps(config).encode(), qos=1, retain=True)


async def listen(client: Client[Any, Any]) -> str:
    """Subscribe to all sensors, once they are known; return the topic on which their messages come."""
    topic = ""
    with anyio.fail_after(PATIENCE):
        for number in range(SENSORS):
            request = SubscribeToTopicRequest(topic=f"sensors/{number}", listener="/app")
            while not (answer := await client.call(request)).success:  # noqa: ASYNC110 - another process announces it
                await anyio.sleep(0.05)
            topic = answer.data_topic
    return topic


async def test_after_a_kill_of_the_broker_an_app_hears_hardly_more_twice_than_plain_paho() -> None:
    """Retained states come again on each new link, for what was missed; what was heard is not heard again."""
    heard: Counter[bytes] = Counter()
    turns = Turns()
    async with MosquittoBroker(credentials={"anna": "right"}, policy=None, settings=SETTINGS) as broker:
        url = f"mqtt://anna:right@{broker.host}:{broker.port}"
        tables = {"gateways": {"mqtt": {"url": url}}, "discovery": {"persist": False}}
        plain = await anyio.to_thread.run_sync(PlainListener, broker.port)
        other = MqttOptions.from_url(url, client_id="sensors")
        try:
            async with (
                MqttConnection(other, NativeClient, status_topic=None) as connection,
                Runtime(parse_config(tables, "test"), with_door=False) as runtime,
                Node(runtime.graph, "app") as node,
                in_background(turns.take_some),
            ):
                await anyio.to_thread.run_sync(plain.is_subscribed.wait, PATIENCE)
                await connection.wait_connected()
                await announce(connection)
                topic = await listen(node.create_client(SubscribeToTopic, "/gateway/mqtt/subscribe_to_topic"))
                node.create_subscription(RawMessage, topic, lambda message: heard.update([message.payload]), 10_000)
                for kill in range(KILLS):
                    payloads = {b"%d" % (kill * SENSORS + number) for number in range(SENSORS)}
                    for number in range(SENSORS):
                        payload = b"%d" % (kill * SENSORS + number)
                        await connection.publish(f"sensors/{number}", payload, qos=1, retain=True)
                    await until(partial(payloads.issubset, heard))
                    await until(partial(payloads.issubset, plain.heard))
                    await broker.until_saved()
                    await broker.stop(abrupt=True)
                    await broker.start()
                    await connection.wait_connected()
                last = {b"last %d" % number for number in range(SENSORS)}
                for number in range(SENSORS):
                    await connection.publish(f"sensors/{number}", b"last %d" % number, qos=1, retain=True)
                await until(partial(last.issubset, heard))  # and so the gateway is back
        finally:
            await anyio.to_thread.run_sync(plain.stop)
    twice = sum(count - 1 for count in heard.values())
    twice_plain = sum(count - 1 for count in plain.heard.values())
    print(f"heard twice: by an app {twice}, by plain paho {twice_plain}; longest turn {1000 * turns.longest:.1f} ms")
    assert twice <= twice_plain + SENSORS // 10
