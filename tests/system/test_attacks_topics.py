"""A plug that may write its own topics only, on a Mosquitto with access rights, wants homebot to open a door."""

import json
import os
import shutil
import subprocess
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL

import anyio
import pytest
from tests.mqtt.client.mosquitto_broker import until_it_answers
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.sizes import nightly

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import DoorLock, Light
from homebot.devices.outcomes import Refused
from homebot.errors import RefusedError
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = [pytest.mark.system, pytest.mark.rooms("homeassistant", "homie", "zigbee2mqtt")]

UNLOCK = '{"state":"UNLOCK"}'
IEEE = "0x00158d0001a2b3c4"
RIGHTS = """
user homebot
topic readwrite #
topic read $SYS/#

user house
topic readwrite #

user plug
topic write homeassistant/light/plug42/+/config
topic write tasmota/discovery/AABBCC112233/config
topic readwrite plug42/#
"""
WANTED = (
    "zigbee2mqtt/Front door/set",
    "zigbee2mqtt/Front door/set/state",
    f"zigbee2mqtt/{IEEE}/set",
    f"zigbee2mqtt/{IEEE}/set/state",
    "zigbee2mqtt/bridge/request/permit_join",
    "homebot/house/mqtt/status",
    "homebot/things/door/td",
    "$SYS/broker/log",
    "homeassistant/lock/garage_door/config",
    "home425/locks/cellar/in",
    "home425/locks/cellar/out",
    "garage_door/set",
    "homie/gate/gate/state/set",
)


@dataclass(frozen=True)
class Mosquitto:
    """A broker with access rights."""

    port: int

    def url(self, user: str) -> str:
        return f"mqtt://{user}:{user}@127.0.0.1:{self.port}"

    def client(self, user: str) -> MqttConnection:
        return MqttConnection(MqttOptions.from_url(self.url(user)), AiomqttClient, status_topic=None)


@pytest.fixture
async def mosquitto(tmp_path: Path) -> AsyncIterator[Mosquitto]:
    path = f"{os.environ['PATH']}:/usr/sbin:/usr/local/sbin"
    program, passwd = shutil.which("mosquitto", path=path), shutil.which("mosquitto_passwd", path=path)
    if program is None or passwd is None:
        pytest.skip("mosquitto is not installed")
    passwords, rights, config = (tmp_path / name for name in ("passwords", "rights", "mosquitto.conf"))
    passwords.touch(mode=0o600)
    for user in ("homebot", "house", "plug"):
        subprocess.run([passwd, "-b", str(passwords), user, user], check=True, stdout=DEVNULL, stderr=DEVNULL)
    rights.write_text(RIGHTS)
    rights.chmod(0o600)
    port = reserve_port()
    config.write_text(
        f"listener {port} 127.0.0.1\nallow_anonymous false\npassword_file {passwords}\nacl_file {rights}\n"
        + (f"user {os.environ.get('USER', 'root')}\n" if os.geteuid() == 0 else "")
    )
    async with await anyio.open_process([program, "-c", str(config)], stdout=DEVNULL, stderr=DEVNULL) as process:
        await until_it_answers(port)
        yield Mosquitto(port)
        process.terminate()


def honest() -> list[tuple[str, str]]:
    """A lock behind a bridge, in both of its announcements; others of every kind."""
    features = [
        {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "LOCK", "value_off": "UNLOCK"}
    ]
    entry = {
        "ieee_address": IEEE,
        "friendly_name": "Front door",
        "type": "EndDevice",
        "supported": True,
        "definition": {"model": "L1", "vendor": "V", "exposes": [{"type": "lock", "features": features}]},
    }
    told = {
        "command_topic": "zigbee2mqtt/Front door/set",
        "state_topic": "zigbee2mqtt/Front door",
        "value_template": "{{ value_json.state }}",
        "payload_lock": "LOCK",
        "payload_unlock": "UNLOCK",
        "unique_id": f"{IEEE}_lock_zigbee2mqtt",
        "device": {"identifiers": [f"zigbee2mqtt_{IEEE}"], "name": "Front door"},
    }
    garage = {
        "command_topic": "garage_door/set",
        "unique_id": "garage_door",
        "device": {"identifiers": ["garage_door"], "name": "Garage door"},
    }
    homie = {
        "$homie": "4.0.0",
        "$name": "Gate",
        "$nodes": "gate",
        "gate/$name": "gate",
        "gate/$type": "lock",
        "gate/$properties": "state",
        "gate/state/$name": "state",
        "gate/state/$datatype": "enum",
        "gate/state/$format": "lock,unlock",
        "gate/state/$settable": "true",
        "$state": "ready",
    }
    return [
        ("zigbee2mqtt/bridge/devices", json.dumps([entry])),
        (f"homeassistant/lock/{IEEE}/lock/config", json.dumps(told)),
        ("homeassistant/lock/garage_door/config", json.dumps(garage)),
        *((f"homie/gate/{topic}", payload) for topic, payload in homie.items()),
        ("home425/locks/cellar/out", "locked"),
    ]


def hostile(number: int, topic: str, *, stolen: bool) -> tuple[str, str]:
    """A lamp of the plug's that is told UNLOCK to go off; in its own name, or in that of the lock."""
    device = {"identifiers": [f"zigbee2mqtt_{IEEE}" if stolen else f"plug42-{number}"], "name": f"Lamp {number}"}
    config = {
        "command_topic": topic,
        "payload_on": UNLOCK,
        "payload_off": UNLOCK,
        "unique_id": f"plug42-{number}-{stolen}",
        "device": device,
    }
    return f"homeassistant/light/plug42/{number}{'s' if stolen else ''}/config", json.dumps(config)


async def publish(mosquitto: Mosquitto, user: str, messages: list[tuple[str, str]]) -> None:
    async with mosquitto.client(user) as client:
        await client.wait_connected()
        for topic, payload in messages:
            await client.publish(topic, payload.encode(), qos=1, retain=True)


@pytest.mark.parametrize("order", ["before", pytest.param("after", marks=nightly)])
async def test_a_plug_without_rights_opens_no_door(mosquitto: Mosquitto, order: str) -> None:
    """Whether it announces its lamps before the house is there or after; what is told to honest devices arrives."""
    attack = [hostile(number, topic, stolen=stolen) for stolen in (False, True) for number, topic in enumerate(WANTED)]
    attack.append(hostile(99, "plug42/set", stolen=False))
    attacks = [("plug", attack), ("house", honest())]
    for user, messages in attacks if order == "before" else reversed(attacks):
        await publish(mosquitto, user, messages)
    gateway = {"url": mosquitto.url("homebot"), "root": "home425", "act": True}
    # Without approvals, so that only the ownership of topics protects the locks.
    tables = {
        "gateways": {"mqtt": gateway},
        "discovery": {"persist": False},
        "control": {"approvals": False, "timeout": 1.0},
    }
    config = parse_config(tables, "test")
    heard: list[tuple[str, bytes]] = []
    async with (
        mosquitto.client("house") as spy,
        Runtime(config, with_door=False) as runtime,
        Node(runtime.graph, "app") as node,
    ):
        await spy.wait_connected()
        await spy.subscribe(MqttSubscription("#", qos=1, retain_handling=2), MqttSubscription("$SYS/broker/log", qos=1))
        devices = Devices(node)
        with anyio.fail_after(PATIENCE):
            await found(devices, Light, len(WANTED) + 1)
            await found(devices, DoorLock, 4)
        refused = 0

        async def tell(lamp: Light) -> None:
            nonlocal refused
            for command in (lamp.turn_on, lamp.turn_off):
                try:
                    was_refused = isinstance(await command(), Refused)
                except RefusedError:
                    was_refused = True
                refused += was_refused

        async with anyio.create_task_group() as tasks:
            for lamp in await devices.find(Light):
                tasks.start_soon(tell, lamp)
        async with anyio.create_task_group() as tasks:
            for lock in await devices.find(DoorLock):
                tasks.start_soon(lock.lock)
        with anyio.fail_after(PATIENCE):
            while ("end", b"") not in heard:
                if not heard:
                    await spy.publish("end", b"", qos=1)
                heard += [(one.topic, one.payload) for one in await spy.receive()]
    published = [(topic, payload) for topic, payload in heard if topic != "end"]
    print(f"refused {refused} commands; published {published}")
    assert {topic for topic, payload in published if payload == UNLOCK.encode()} == {"plug42/set"}
    locked = {topic for topic, payload in published if payload.lower() in {b"lock", b'{"state":"lock"}'}}
    assert locked == {
        "zigbee2mqtt/Front door/set",
        "garage_door/set",
        "homie/gate/gate/state/set",
        "home425/locks/cellar/in",
    }
    assert refused >= 2 * len(WANTED)


async def found(devices: Devices, kind: type[Light | DoorLock], count: int) -> None:
    """Wait until so many are there."""
    seen: set[str] = set()
    async for change in devices.follow(kind):
        seen.add(f"{change.handle.id}")
        if len(seen) >= count:
            return
