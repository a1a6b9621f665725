"""Recordings of houses with several gateways and protocols, and their replays; the radio and the broker are virtual."""

import asyncio
import tomllib
from pathlib import Path
from random import Random

import anyio
import pytest
from tests.apps.houses import flat, lamp, motion
from tests.replay.recorded_days import (
    APPS,
    diff_of,
    difference,
    recorded,
    recorded_for_client,
    recording_of,
    replayed,
    texts,
)
from tests.simulated.families import FAMILIES
from tests.sizes import nightly

import homebot.apps.lights_out
from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.devices.names import MERGE_DEVICES
from homebot.devices.services import MergeDevices, MergeDevicesRequest
from homebot.graph import Node
from homebot.house.description import load_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.recording.recording import Recording
from homebot.runtime import Runtime
from homebot.support.virtual_time import VirtualTimeLoop

pytestmark = [pytest.mark.slow, pytest.mark.no_cover, pytest.mark.rooms("recording")]

MIXED = Path(__file__).parents[2] / "examples" / "houses" / "mixed.toml"
BOTH = ("mqtt", "observer")
ROOMS = {"study_lamp": "study", "study_moti": "study", "kitchen_lamp": "kitchen", "kitchen_motion": "kitchen"}


async def live(lines: list[str]) -> None:
    """An hour in a flat with Bluetooth and MQTT; a second gateway to the broker, which only observes, sights the same.

    A client records it from the second minute on. Anna is in the study and then in the kitchen. After half an hour the
    owner says that two sensors in the study, one on the radio and one at the broker, are one.
    """
    world = flat(
        ("00:05", "study"),
        ("00:20", "kitchen"),
        ("00:40", "outside"),
        hall_lamp=lamp("hall"),
        study_lamp=lamp("study", dialect=FAMILIES["ble_light"]),
        kitchen_lamp=lamp("kitchen", dialect="zigbee2mqtt"),
        hall_motion=motion("hall"),
        study_motion=motion("study", dialect=FAMILIES["bthome"]),
        study_relay=motion("study"),
        kitchen_motion=motion("kitchen", dialect="zigbee2mqtt"),
    )
    broker = {"class": "mqtt", "url": "embedded", "root": "home425"}
    tables = {
        "gateways": {"mqtt": broker, "observer": {**broker, "act": False}},
        "apps": {name: APPS[name] for name in ("lights_out", "follow_me")},
        "places": {
            "rooms": {name: {} for name in ("hall", "study", "kitchen")},
            "devices": {device: {"room": room} for device, room in ROOMS.items()},
        },
    }
    clock, random = LoopClock(1_767_225_600.0), Random(1)  # noqa: S311 - a simulation
    async with (
        MemoryBroker(clock=clock, random=random) as memory,
        Runtime(
            parse_config(tables, "test"),
            house=world,
            with_door=False,
            clock=clock,
            services=[HostedBroker.in_memory(memory)],
            random=random,
        ) as runtime,
        Node(runtime.graph, "owner") as owner,
    ):
        await anyio.sleep(60)
        async with recorded_for_client(owner, lines):
            await anyio.sleep(1740)
            merge = owner.create_client(MergeDevices, MERGE_DEVICES)
            assert (await merge.call(MergeDevicesRequest(devices=("study_moti", "study_relay")))).success
            await anyio.sleep(1800)


@pytest.fixture(scope="module")
def hour() -> Recording:
    lines: list[str] = []
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live(lines))
    return recording_of(lines)


@pytest.mark.rooms("bthome", "homeassistant", "zigbee2mqtt")
def test_the_same_apps_give_the_same_commands_over_all_gateways_whose_devices_are_merged(hour: Recording) -> None:
    assert hour.gateways == ("ble", "mqtt", "observer")
    commanded = {one.command.device for one in hour.commands}
    assert commanded == {"hall_lamp", "study_lamp", "kitchen_lamp"}
    again = replayed(hour)
    diff = difference(hour, again)
    assert (again.crashes, texts(hour, diff)) == ({}, [])
    assert diff.same == len(hour.commands)
    found = {one.id: sorted({each.gateway for each in one.endpoints}) for one in again.devices}
    merged = found.pop("study_moti", None) or found.pop("study_relay")
    assert merged == ["ble", *BOTH]
    assert found == {
        "study_lamp": ["ble"],
        **{name: list(BOTH) for name in ("hall_lamp", "hall_motion", "kitchen_lamp", "kitchen_motion")},
    }


@pytest.mark.rooms("bthome", "homeassistant", "zigbee2mqtt")
def test_a_changed_line_changes_exactly_its_commands_over_all_gateways(hour: Recording, tmp_path: Path) -> None:
    """The app turns lamps off five minutes after the last motion, not after 21; the other app has no part in it.

    The lamp in the study was turned off late in the recording: the merge began its countdown anew. Five minutes end
    before the merge, and once more after it, as the recorded lamp was still on then.
    """
    source = Path(homebot.apps.lights_out.__file__).read_text("utf-8")
    changed = tmp_path / "my_lights_out.py"
    changed.write_text(source.replace("quiet_after: Seconds = 1260.0", "quiet_after: Seconds = 300.0"))
    diff = diff_of(hour, [str(changed)])
    found = [(round(60 + one.given.at), one.kind, one.given.command.device) for one in diff.different]
    assert found == [
        (666, "added", "hall_lamp"),
        (1565, "added", "study_lamp"),
        (1570, "added", "hall_lamp"),
        (2100, "added", "study_lamp"),
        (2765, "added", "kitchen_lamp"),
        (2766, "added", "hall_lamp"),
        (3060, "gone", "study_lamp"),
    ]
    assert diff.same == 0


@nightly
def test_the_same_apps_give_the_same_commands_in_a_day_of_the_mixed_house() -> None:
    """Devices of eight families at one broker, some of which get their id before their name comes."""
    house = tomllib.loads(MIXED.read_text("utf-8"))
    places = {
        "rooms": {room: {} for room in house["rooms"]},
        "devices": {name: {"room": device["room"]} for name, device in house["devices"].items()},
    }
    recording = recorded(load_world(MIXED), tuple(APPS), "24h", config={"places": places})
    diff = diff_of(recording)
    assert texts(recording, diff) == []
    assert diff.same == len(recording.commands) >= 20
