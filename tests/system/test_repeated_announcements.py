"""A lamp that is announced twice on a Mosquitto, as after a rename: one device, and one command each time."""

import json
from typing import Any, Final

import anyio
import pytest
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, MosquittoBroker
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Evidence
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
    pytest.mark.rooms("homeassistant"),
]

COMMANDS: Final = 10


def lamp(unique_id: str, *identifiers: str) -> dict[str, Any]:
    """A lamp of Home Assistant discovery, whose topics are the same whatever it is called."""
    device = {"device": {"identifiers": identifiers, "name": unique_id}} if identifiers else {}
    return {"unique_id": unique_id, "name": unique_id, "command_topic": "lamp4/set", "state_topic": "lamp4"} | device


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ({"old_lamp": lamp("old_lamp", "m1234")}, {"new_lamp": lamp("new_lamp", "m1234")}),
        ({"old_lamp": lamp("old_lamp", "m1234")}, {"new_lamp": lamp("new_lamp", "m5678")}),
        ({"old_lamp": lamp("old_lamp")}, {"new_lamp": lamp("new_lamp")}),
        ({"old_lamp": lamp("kept", "m1234")}, {"new_lamp": lamp("kept", "m1234")}),
        ({"lamp4": lamp("old_lamp", "m1234")}, {"new_lamp": lamp("new_lamp", "m5678")}),
        ({"old_lamp_4": lamp("old_lamp", "m1234")}, {"old_lamp_5": lamp("new_lamp", "m5678")}),
    ],
    ids=["unique id", "device", "no device", "place", "named by its topic", "names in common"],
)
async def test_a_lamp_that_is_left_over_from_a_rename_is_neither_refused_nor_commanded_twice(
    before: dict[str, Any], after: dict[str, Any]
) -> None:
    told: list[bytes] = []

    async def live(connection: MqttConnection) -> None:
        while True:
            for message in await connection.receive():
                told.append(message.payload)
                await connection.publish("lamp4", message.payload)

    async with MosquittoBroker(credentials={"anna": "right"}, policy=None) as broker:
        url = f"mqtt://anna:right@{broker.host}:{broker.port}"
        tables = {"gateways": {"mqtt": {"url": url, "act": True}}, "discovery": {"persist": False}}
        async with (
            MqttConnection(MqttOptions.from_url(url), NativeClient, status_topic=None) as connection,
            Runtime(parse_config(tables, "test"), with_door=False) as runtime,
            Node(runtime.graph, "app") as node,
            anyio.create_task_group() as tasks,
        ):
            await connection.wait_connected()
            await connection.subscribe(MqttSubscription("lamp4/set"))
            tasks.start_soon(live, connection)
            devices = Devices(node)
            for name, config in (before | after).items():
                topic = f"homeassistant/light/{name}/config"
                await connection.publish(topic, json.dumps(config).encode(), qos=1, retain=True)
            with anyio.fail_after(PATIENCE):
                while sum(len(part.routes) for one in await devices.find() for part in one.parts) < 2:  # noqa: ASYNC110
                    await anyio.sleep(0.02)  # the broker is another process
            for number in range(COMMANDS):
                (light,) = await devices.find(Light)
                outcome = await (light.turn_off() if number % 2 else light.turn_on())
                assert isinstance(outcome, Confirmed)
                assert outcome.evidence is Evidence.REPORTED
            tasks.cancel_scope.cancel()
    assert told == [b"ON", b"OFF"] * (COMMANDS // 2)
