"""A stranger floods the topics on which devices announce themselves, over a socket; those of the house are heard."""

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import anyio
import pytest
from tests.patience import PATIENCE
from tests.sizes import nightly
from tests.system.attack_probe import Attacked, attacked, begun, open_files, until
from tests.system.own_time import own_time
from tests.turns import slowness
from websockets.sync.client import connect

from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.system

LIST = "zigbee2mqtt/bridge/devices"
SECONDS = 2.0


def client(homebot: Attacked) -> MqttConnection:
    options = MqttOptions.from_url(f"mqtt://127.0.0.1:{homebot.broker}")
    return MqttConnection(options, AiomqttClient, status_topic=None)


def bridge_list(*names: str) -> bytes:
    """What a Zigbee2MQTT with these lamps says."""
    features = [
        {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"}
    ]
    definition = {"model": "L1", "vendor": "V", "exposes": [{"type": "light", "features": features}]}
    return json.dumps(
        [
            {
                "ieee_address": f"0x{number:016x}",
                "friendly_name": name,
                "type": "Router",
                "supported": True,
                "definition": definition,
            }
            for number, name in enumerate(names, 1)
        ]
    ).encode()


def discovery(name: str) -> bytes:
    device = {"identifiers": [name], "name": name}
    return json.dumps({"command_topic": f"{name}/set", "unique_id": name, "device": device}).encode()


def call(homebot: Attacked, service: str) -> dict[str, object]:
    with connect(homebot.url, proxy=None, compression=None, open_timeout=PATIENCE) as door:
        door.send(json.dumps({"op": "call_service", "id": "q", "service": service, "args": {}, "timeout": PATIENCE}))
        while (answer := json.loads(door.recv(timeout=PATIENCE))).get("id") != "q":
            pass
    values: dict[str, object] = answer["values"]
    return values


async def known_after(homebot: Attacked, name: str, within: float) -> float:
    """Return the seconds of homebot's own until a device of that name is known."""
    with own_time(homebot.pid) as seconds, anyio.fail_after(within):
        while True:
            found = await anyio.to_thread.run_sync(call, homebot, "/discovery/find_devices")
            if name in {one["name"] for one in found["devices"]}:  # type: ignore[attr-defined]
                return seconds()
            await anyio.sleep(0.05)


def cpu(pid: int) -> float:
    """Return the seconds of processor time that a process used."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def flood(
    homebot: Attacked, topic: str, payload: Callable[[int], bytes], sent: list[int], is_over: anyio.Event
) -> None:
    """Publish until it is over: 4,000 short messages in each second, or as many long ones as the broker takes."""
    async with client(homebot) as stranger:
        await stranger.wait_connected()
        while not is_over.is_set():
            for _ in range(40):
                await stranger.publish(topic.format(sent[0]), payload(sent[0]))
                sent[0] += 1
            await stranger.publish("stranger", b"", qos=1)
            await anyio.sleep(0.01)


def counted(homebot: Attacked) -> dict[str, int]:
    counts = call(homebot, "/gateway/mqtt/health")["counts"]
    return {one["name"]: one["count"] for one in counts}  # type: ignore[attr-defined]


async def deferred_more(homebot: Attacked, count: int) -> None:
    """Wait until more than *count* announcements were put off."""
    with anyio.fail_after(PATIENCE):
        while True:
            counts = await anyio.to_thread.run_sync(counted, homebot)
            if counts["announcements_deferred"] > count:
                return
            await anyio.sleep(0.1)


@pytest.fixture(scope="module")
def homebot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Attacked]:
    with attacked(tmp_path_factory.mktemp("flooded")) as running:
        yield begun(running)


@pytest.mark.rooms("homeassistant", "zigbee2mqtt")
@pytest.mark.parametrize(
    ("case", "topic", "payload"),
    [
        pytest.param("short", LIST, lambda number: b"{broken %d" % number, marks=nightly),
        ("long", LIST, lambda number: b"[" + b"%d," % (number % 1000) * 60_000),
        ("changing", "homeassistant/light/stranger{}/config", lambda number: b"{broken %d" % number),
    ],
    ids=["short garbage on the bridge's topic", "long garbage on the bridge's topic", "changing topics"],
)
async def test_a_flood_of_garbage_silences_nobody(
    homebot: Attacked, case: str, topic: str, payload: Callable[[int], bytes]
) -> None:
    async with client(homebot) as house, anyio.create_task_group() as tasks:
        await house.wait_connected()
        await house.publish(LIST, bridge_list(f"Desk {case}"), qos=1, retain=True)
        await known_after(homebot, f"Desk {case}", PATIENCE)
        before, used, counts, sent = homebot.toll(), cpu(homebot.pid), counted(homebot), [0]
        is_over = anyio.Event()
        tasks.start_soon(flood, homebot, topic, payload, sent, is_over)
        await anyio.sleep(SECONDS * 0.6)
        await house.publish(LIST, bridge_list(f"Desk {case}", f"Shelf {case}"), qos=1, retain=True)
        heard = await known_after(homebot, f"Shelf {case}", PATIENCE)
        await anyio.sleep(max(0.0, SECONDS * 0.4 - heard))
        await deferred_more(homebot, counts["announcements_deferred"])
        is_over.set()
        used = cpu(homebot.pid) - used
        counts = {name: count - counts[name] for name, count in counted(homebot).items()}
        await house.publish(f"homeassistant/light/{case}/config", discovery(f"New {case}"), qos=1, retain=True)
        newcomer = await known_after(homebot, f"New {case}", PATIENCE)
        after = homebot.toll()
    print(
        f"\n{case}: {sent[0]:,} messages; the bridge was heard after {heard:.2f} s, a newcomer after {newcomer:.2f} s; "
        f"{counts['announcements_rejected']} were read as yet, {counts['announcements_deferred']} put off, of which "
        f"{counts['announcements_ignored']} for good; {used:.1f} s of processor time\n{after}"
    )
    assert heard < 4 * slowness()
    assert newcomer < 4 * slowness()
    assert counts["announcements_rejected"] <= 1024 + 8 * 256
    until(lambda: open_files(homebot.pid) <= before.files or None, PATIENCE)  # without opening one more to read it
    until(lambda: replace(homebot.toll(), files=0).is_back_at(before) or None, PATIENCE)  # a last read is a task
    assert after.rss < before.rss + 64
