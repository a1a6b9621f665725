"""Twenty lamps behind a bridge whose radio loses frames, through the real gateway and directory; in virtual time."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from random import Random
from typing import Any

import anyio
import pytest
from anyio.abc import TaskGroup

from homebot.config import parse_config
from homebot.devices.command_messages import (
    CommandDevices,
    CommandDevicesRequest,
    CommandDevicesResponse,
    CommandRequest,
    PerformCommand,
    Setting,
)
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.journal_messages import JournalEntry, ReadJournal, ReadJournalRequest
from homebot.devices.names import APPLY_SCENE, COMMAND_DEVICES, LIST_SCENES, PERFORM_COMMAND, READ_JOURNAL
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest, ListScenes, ScenesRequest
from homebot.graph import Node
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = pytest.mark.virtual_time

LAMPS = tuple(f"lamp {number}" for number in range(20))
GROUP = "living room"
TRIES = 2
"""Of a frame to one lamp, which acknowledges it (IEEE 802.15.4 has four); a frame to a group is sent once."""
SCENES = [{"id": 3, "name": "Film"}]
FEATURES = [
    {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"},
    {"type": "numeric", "name": "brightness", "property": "brightness", "access": 7, "value_max": 254},
]


class Bridge:
    """Zigbee2MQTT with lamps: it reports for the members of a group what it told them, heard or not.

    Attributes:
        commands: The names that were set, oldest first.
        lit: The lamps that are really on.
        asked: What was asked for.
    """

    def __init__(self, link: MqttConnection, tasks: TaskGroup, loss: float, seed: int) -> None:
        self._link, self._tasks = link, tasks
        self._loss, self._random = loss, Random(seed)  # noqa: S311 - a radio, no secret
        self.commands: list[str] = []
        self.asked: set[str] = set()
        self.lit: set[str] = set()
        self._known: dict[str, str] = {}

    async def announce(self) -> None:
        devices = [
            {
                "ieee_address": f"0x{0x00158D0000000000 + number:016x}",
                "friendly_name": name,
                "type": "Router",
                "power_source": "Mains (single phase)",
                "definition": {"vendor": "v", "model": "m", "exposes": [{"type": "light", "features": FEATURES}]},
            }
            for number, name in enumerate(LAMPS)
        ]
        members = [{"ieee_address": one["ieee_address"], "endpoint": 1} for one in devices]
        for topic, payload in (
            ("bridge/state", {"state": "online"}),
            ("bridge/info", {"config": {"availability": False}}),
            ("bridge/devices", devices),
            ("bridge/groups", [{"id": 1, "friendly_name": GROUP, "members": members, "scenes": SCENES}]),
        ):
            await self._link.publish(f"zigbee2mqtt/{topic}", json.dumps(payload).encode(), qos=1, retain=True)
        await self._link.subscribe(MqttSubscription("zigbee2mqtt/+/set"), MqttSubscription("zigbee2mqtt/+/get"))

    async def serve(self) -> None:
        while True:
            messages = await self._link.receive()
            self._link.ack(messages)
            for one in messages:
                _, name, action = one.topic.split("/")
                wanted = json.loads(one.payload)
                await (self._set(name, wanted) if action == "set" else self._read(name, wanted))

    async def _set(self, name: str, wanted: dict[str, Any]) -> None:
        self.commands.append(name)
        if "scene_recall" in wanted:  # of a scene that lights all lamps; it was made elsewhere
            self.lit.update(LAMPS)
            return
        for lamp in LAMPS if name == GROUP else (name,):
            is_heard = self._is_heard(tries=1 if name == GROUP else TRIES)
            if is_heard:
                (self.lit.add if wanted["state"] == "ON" else self.lit.discard)(lamp)
            if name == GROUP or (is_heard and self._is_heard()):  # the acknowledgement of a single lamp
                await self.publish(lamp, wanted["state"])
        if name == GROUP:
            await self.publish(GROUP, wanted["state"])

    async def _read(self, name: str, wanted: dict[str, Any]) -> None:
        self.asked.update(wanted)
        if self._is_heard() and self._is_heard():
            self._tasks.start_soon(self._answer, name)

    async def _answer(self, name: str) -> None:
        await anyio.sleep(0.05)
        await self.publish(name, "ON" if name in self.lit else "OFF")

    async def publish(self, name: str, state: str) -> None:
        await self._link.publish(f"zigbee2mqtt/{name}", json.dumps({"state": state, "brightness": 200}).encode())

    def _is_heard(self, tries: int = TRIES) -> bool:
        return any(self._random.random() >= self._loss for _ in range(tries))


@asynccontextmanager
async def house(loss: float, seed: int = 1, **tables: object) -> AsyncIterator[tuple[Bridge, Node]]:
    config = parse_config({"gateways": {"mqtt": {"url": "embedded"}}, **tables}, "homebot.toml")
    async with (
        MemoryBroker() as broker,
        Runtime(config, with_door=False, services=[HostedBroker.in_memory(broker)]) as runtime,
        MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as link,
        Node(runtime.graph, "client") as client,
        anyio.create_task_group() as tasks,
    ):
        await link.wait_connected()
        bridge = Bridge(link, tasks, loss, seed)
        await bridge.announce()
        tasks.start_soon(bridge.serve)
        await anyio.sleep(5)
        for name in LAMPS:
            await bridge.publish(name, "OFF")
        await anyio.sleep(90)  # the reports are no longer fresh
        yield bridge, client
        tasks.cancel_scope.cancel()


async def turn_on(client: Node, target: str = "lights", **more: Any) -> CommandDevicesResponse:
    words = client.create_client(CommandDevices, COMMAND_DEVICES)
    return await words.call(CommandDevicesRequest(target=target, command="on", issuer="client:me", **more), timeout=120)


async def changes(client: Node) -> list[JournalEntry]:
    await anyio.sleep(60)
    journal = client.create_client(ReadJournal, READ_JOURNAL)
    entries = (await journal.call(ReadJournalRequest())).entries
    return [one for one in entries if one.kind in {"changed", "reported"}]


async def test_without_losses_one_message_is_told_and_each_of_twenty_lamps_proves_it() -> None:
    async with house(0.0) as (bridge, client):
        answer = await turn_on(client)
        assert bridge.commands == [GROUP]
        assert [one.result.outcome for one in answer.results] == ["confirmed"] * 20
        assert {one.result.evidence for one in answer.results} == {3}
        assert {one.cause for one in await changes(client)} <= {"command", "echo"}


@pytest.mark.parametrize("seed", range(10))
async def test_with_a_tenth_of_the_frames_lost_all_twenty_prove_it_and_those_that_missed_it_are_repaired(
    seed: int,
) -> None:
    async with house(0.1, seed) as (bridge, client):
        answer = await turn_on(client)
        assert bridge.commands[0] == GROUP
        assert GROUP not in bridge.commands[1:]
        assert len(bridge.commands) < 20
        assert bridge.lit == set(LAMPS)
        assert [one.result.outcome for one in answer.results] == ["confirmed"] * 20
        assert {one.result.evidence for one in answer.results} == {3}
        assert "person" not in {one.cause for one in await changes(client)}


@pytest.mark.parametrize("delay", [0.3, 0.9, 1.5, 2.5, 5.0])
async def test_a_person_who_turns_a_lamp_off_after_a_command_to_its_group_is_never_overridden(delay: float) -> None:
    """The wall switch cuts in while a part of the lamps has still to be heard."""
    async with house(0.3, seed=3) as (bridge, client):
        perform = client.create_client(PerformCommand, PERFORM_COMMAND)
        (group,) = await DeviceLookup(client).find_called(GROUP)
        request = CommandRequest(device=group.id, settings=(Setting.of("on_off", True),), issuer="/app")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(partial(perform.call, request, timeout=120))
            await anyio.sleep(delay)
            bridge.lit.discard(LAMPS[0])
            await bridge.publish(LAMPS[0], "OFF")
        (lamp,) = await DeviceLookup(client).find_called(LAMPS[0])
        causes = [one.cause for one in await changes(client) if one.device == lamp.id]
        assert LAMPS[0] not in bridge.lit
        assert causes[-1] in {"person", "unknown"}


@pytest.mark.rooms("scenes")
async def test_a_scene_is_recalled_by_one_message_and_the_members_are_asked_for_their_values() -> None:
    """The bridge does not tell what a scene that was made elsewhere sets."""
    async with house(0.0) as (bridge, client):
        scenes = client.create_client(ApplyScene, APPLY_SCENE)
        bridge.asked.clear()
        answer = await scenes.call(ApplySceneRequest(name="Film", issuer="/app"), timeout=120)
        assert answer.success, answer.message
        assert bridge.commands == [GROUP]
        assert {one.cause for one in await changes(client)} == {"command"}
        assert bridge.asked == {"state", "brightness"}
        shown = await client.create_client(ListScenes, LIST_SCENES).call(ScenesRequest(name="film"))
        assert len(shown.scenes[0].parts) == 20
        await scenes.call(ApplySceneRequest(name="Film", issuer="/app", undo=True), timeout=120)
        assert bridge.lit == set()
