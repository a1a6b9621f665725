"""Events all the way, from each maker's message to an app: each is told once, and none is told again."""

import json
from dataclasses import dataclass, field

import anyio
import pytest
from tests.gateways.mqtt.known_house import KnownHouse, Payload, known_house
from tests.whole_house import WHOLE_HOUSE

from homebot.devices.gateway_messages import Report
from homebot.devices.handles import FollowHandles, Handle
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection

pytestmark = pytest.mark.virtual_time

MAC = "a8032abe54dc"
DEVICE = {"identifiers": ["remote1"], "name": "Remote"}
HA_EVENT = {"unique_id": "e1", "state_topic": "remote/event", "event_types": ["single", "double"], "device": DEVICE}
HA_TRIGGER = {
    "automation_type": "trigger",
    "type": "action",
    "subtype": "single",
    "topic": "remote/action",
    "payload": "single",
    "device": DEVICE,
}
Z2M_REMOTE = {
    "ieee_address": "0x00158d0001abcdef",
    "type": "EndDevice",
    "friendly_name": "remote",
    "supported": True,
    "definition": {
        "model": "WXKG11LM",
        "vendor": "Aqara",
        "description": "Remote",
        "exposes": [
            {
                "type": "enum",
                "name": "action",
                "property": "action",
                "label": "Action",
                "access": 1,
                "values": ["single", "double"],
            }
        ],
    },
}
TASMOTA = {
    "ip": "10.0.0.1",
    "dn": "Remote",
    "fn": ["Remote"],
    "hn": "remote",
    "mac": MAC.upper(),
    "md": "Sonoff",
    "ty": 0,
    "if": 0,
    "ofln": "Offline",
    "onln": "Online",
    "state": ["OFF", "ON", "TOGGLE", "HOLD"],
    "sw": "14.4.1",
    "t": "remote",
    "ft": "%prefix%/%topic%/",
    "tp": ["cmnd", "stat", "tele"],
    "rl": [0],
    "swc": [-1],
    "swn": [None],
    "btn": [1],
    "so": {"73": 1},
    "ver": 1,
}
GEN2 = "shellyplusi4-a8032abe54dc"
GEN2_ANSWERS: dict[str, object] = {
    "Shelly.GetDeviceInfo": {"name": "Hall", "id": GEN2, "mac": MAC.upper(), "model": "SNSN-0024X", "gen": 2},
    "Shelly.GetConfig": {"sys": {"device": {}}, "input:0": {"id": 0, "type": "button"}},
    "Shelly.GetStatus": {"sys": {"mac": MAC.upper()}, "input:0": {"id": 0, "state": None}},
}
HOMIE = {
    "homie": "5.0",
    "version": 1,
    "name": "Remote",
    "nodes": {
        "b": {"name": "B", "properties": {"action": {"datatype": "enum", "format": "single,double", "retained": False}}}
    },
}


def gen2_event(event: str) -> Payload:
    events = [{"component": "input:0", "id": 0, "event": event}]
    return {"src": GEN2, "method": "NotifyEvent", "params": {"events": events}}


@dataclass(frozen=True)
class Remote:
    """How a maker's remote announces itself, says two equal presses and one other, and what is no press."""

    announced: tuple[tuple[str, Payload], ...]
    topic: str
    presses: tuple[Payload, Payload, Payload]
    between: Payload | None = None
    told: tuple[str, str, str] = ("single", "single", "double")
    is_asked: bool = False
    answers: dict[str, object] = field(default_factory=dict)


REMOTES = {
    "homeassistant event": Remote(
        (("homeassistant/event/remote/config", HA_EVENT),),
        "remote/event",
        ({"event_type": "single"}, {"event_type": "single"}, {"event_type": "double"}),
    ),
    "homeassistant trigger": Remote(
        (("homeassistant/device_automation/remote/single/config", HA_TRIGGER),),
        "remote/action",
        ("single", "single", "single"),
        between="",
        told=("single", "single", "single"),
    ),
    "homeassistant tag": Remote(
        (("homeassistant/tag/remote/config", {"topic": "remote/tag", "device": DEVICE}),),
        "remote/tag",
        ("E9", "E9", "F0"),
        told=("E9", "E9", "F0"),
    ),
    "zigbee2mqtt": Remote(
        (("zigbee2mqtt/bridge/devices", [Z2M_REMOTE]),),
        "zigbee2mqtt/remote",
        ({"action": "single", "battery": 90}, {"action": "single"}, {"action": "double"}),
        between={"action": "", "battery": 90},
    ),
    "tasmota": Remote(
        (
            (f"tasmota/discovery/{MAC.upper()}/config", TASMOTA),
            (f"tasmota/discovery/{MAC.upper()}/sensors", {"sn": {}}),
        ),
        "stat/remote/RESULT",
        ({"Button1": {"Action": "SINGLE"}}, {"Button1": {"Action": "SINGLE"}}, {"Button1": {"Action": "DOUBLE"}}),
    ),
    "shelly gen2": Remote(
        ((f"{GEN2}/online", "true"),),
        f"{GEN2}/events/rpc",
        (gen2_event("single_push"), gen2_event("single_push"), gen2_event("double_push")),
        between=gen2_event("btn_up"),
        is_asked=True,
    ),
    "homie": Remote(
        (("homie/5/remote/$description", HOMIE), ("homie/5/remote/$state", "ready")),
        "homie/5/remote/b/action",
        ("single", "single", "double"),
    ),
}
EACH = pytest.mark.parametrize("remote", REMOTES.values(), ids=REMOTES)


async def announce(house: KnownHouse, remote: Remote) -> None:
    if remote.is_asked:
        await house.wire.subscribe(MqttSubscription(f"{GEN2}/rpc"))
    for topic, payload in remote.announced:
        await house.say(topic, payload, retain=True)
    if remote.is_asked:
        with anyio.move_on_after(2):
            while True:
                for message in await house.wire.receive():
                    frame = json.loads(message.payload)
                    result = GEN2_ANSWERS.get(frame["method"], {})
                    answer = {"id": frame["id"], "src": GEN2, "dst": frame["src"], "result": result}
                    await house.say(f"{frame['src']}/rpc", answer)
    await anyio.sleep(1)


async def press(house: KnownHouse, remote: Remote) -> None:
    for payload in remote.presses:
        await house.say(remote.topic, payload)
        await anyio.sleep(5)
        if remote.between is not None:
            await house.say(remote.topic, remote.between)


async def read(follow: FollowHandles[Handle]) -> list[str]:
    """The events that come within a moment."""
    found = []
    with anyio.move_on_after(0.5):
        async for change in follow:
            if change.event is not None:
                found.append(str(change.event.value.plain()))  # noqa: PERF401  # it is cut short
    return found


@WHOLE_HOUSE
@EACH
async def test_each_press_is_told_once(remote: Remote) -> None:
    """Also one that equals the one before, and to an app that is slow; none is a state."""
    async with known_house(root="home425") as house:
        await announce(house, remote)
        follow = house.devices.follow(Handle)
        assert await read(follow) == []
        await press(house, remote)
        assert await read(follow) == list(remote.told)
        (device,) = [one for one in house.directory.index.devices() if one.events]
        assert not {state.capability for state in device.states} & {"press", "scan"}
        assert [str(one.value.plain()) for one in device.events] == [remote.told[-1]]
        follow.close()


@EACH
async def test_a_press_that_the_broker_kept_is_none(remote: Remote) -> None:
    """Whether it comes before its announcement or after it, and whoever comes late to hear it."""

    async def before(wire: MqttConnection) -> None:
        text = remote.presses[0] if isinstance(remote.presses[0], str) else json.dumps(remote.presses[0])
        await wire.publish(remote.topic, text.encode(), qos=1, retain=True)

    async with known_house(before, root="home425") as house:
        follow = house.devices.follow(Handle)
        reading: list[str] = []
        await announce(house, remote)
        reading += await read(follow)
        await anyio.sleep(30)
        assert reading + await read(follow) == []
        assert not [one for one in house.directory.index.devices() if one.events]
        follow.close()


@WHOLE_HOUSE
async def test_a_press_of_one_part_that_two_conventions_announce_is_told_once() -> None:
    """And two presses twice, whichever of the two says so first."""
    twin = {
        "unique_id": "0x00158d0001abcdef_action_zigbee2mqtt",
        "state_topic": "zigbee2mqtt/remote",
        "value_template": '{"event_type":"{{ value_json.action }}"}',
        "event_types": ["single", "double"],
        "object_id": "remote_action",
        "device": {"identifiers": ["zigbee2mqtt_0x00158d0001abcdef"], "name": "remote"},
    }
    async with known_house(root="home425") as house:
        await house.say("homeassistant/event/0x00158d0001abcdef/action/config", twin, retain=True)
        await house.say("zigbee2mqtt/bridge/devices", [Z2M_REMOTE], retain=True)
        await anyio.sleep(1)
        (device,) = await house.devices.find()
        assert [len(one.routes) for one in device.parts] == [2]
        follow = house.devices.follow(Handle)
        assert await read(follow) == []
        for action in ("single", "single", "double"):
            await house.say("zigbee2mqtt/remote", {"action": action})
        assert await read(follow) == ["single", "single", "double"]
        follow.close()


async def test_a_directory_that_is_restarted_hears_no_press_again() -> None:
    """What a gateway keeps for late joiners is what lasts."""
    remote = REMOTES["homeassistant event"]
    async with known_house(root="home425") as house:
        await announce(house, remote)
        await press(house, remote)
        await house.say("remote/other", "x")
        async with Node(house.graph, "late") as node:
            latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            kept = node.create_subscription(Report, "/gateway/mqtt/readings", qos_profile=latched)
            assert kept.take() is None


@WHOLE_HOUSE
async def test_the_press_that_makes_a_device_known_is_told_once() -> None:
    """The thesis's way: a device is there once it speaks; here one that spoke before it was announced."""
    remote = REMOTES["homie"]
    async with known_house(root="home425") as house:
        follow = house.devices.follow(Handle)
        reader: list[str] = await read(follow)
        await house.say(remote.announced[0][0], remote.announced[0][1], retain=True)
        await house.wire.publish(remote.announced[1][0], b"ready", qos=1, retain=True)
        await anyio.sleep(0.5)
        await house.wire.publish(remote.topic, b"single", qos=1)
        reader += await read(follow)
        assert reader == ["single"]
        follow.close()
