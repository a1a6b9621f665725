"""Zigbee2MQTT's own code with twenty lamps in a group, whose radio loses three of ten frames to the group."""

import json
import signal
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream
from tests.patience import PATIENCE
from tests.peers.node_package import node_folder

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest, CommandDevicesResponse
from homebot.devices.handles import Light
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import APPLY_SCENE, COMMAND_DEVICES, LIST_SCENES, READ_JOURNAL
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest, ListScenes, ScenesRequest
from homebot.graph import Node
from homebot.mqtt.broker import Broker
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

LAMPS = {f"lamp_{number}" for number in range(1, 21)}


@pytest.fixture(scope="session")
def lamps_js() -> Path:
    return node_folder(Path(__file__).parent / "lamps_js")


class Lamps:
    """The lamps behind Zigbee2MQTT, and what was sent to them."""

    def __init__(self, process: Process) -> None:
        assert process.stdout is not None
        self._process = process
        self._lines = TextReceiveStream(process.stdout)
        self._rest = ""
        self.sent: list[dict[str, Any]] = []

    async def until(self, key: str) -> Any:
        """Return the value of the next line with *key*; the others are kept."""
        with anyio.fail_after(PATIENCE):
            while True:
                while "\n" not in self._rest:
                    self._rest += await self._lines.receive()
                line, _, self._rest = self._rest.partition("\n")
                told = json.loads(line) if line.startswith("{") else {}
                if key in told:
                    return told[key]
                self.sent.append(told)

    async def lit(self) -> set[str]:
        self._process.send_signal(signal.SIGUSR2)
        return set(await self.until("lit"))


@asynccontextmanager
async def lamps_at(url: str, program: Path, folder: Path, loss: float, seed: int) -> AsyncIterator[Lamps]:
    command = ["node", "lamps.mjs", str(folder), url, str(len(LAMPS)), str(loss), str(seed)]
    async with await anyio.open_process(command, cwd=program, stderr=subprocess.STDOUT) as process:
        try:
            lamps = Lamps(process)
            await lamps.until("ready")
            yield lamps
        finally:
            process.kill()


@asynccontextmanager
async def house(program: Path, folder: Path, loss: float, seed: int) -> AsyncIterator[tuple[Lamps, Node, str]]:
    """Run Zigbee2MQTT and homebot until all lamps have told their states; yield the address of their broker too."""
    async with Broker() as broker:
        config = parse_config({"gateways": {"mqtt": {"url": broker.url, "act": True}}}, "homebot.toml")
        async with (
            lamps_at(broker.url, program, folder / "data", loss, seed) as lamps,
            Runtime(config, with_door=False) as runtime,
            Node(runtime.graph, "client") as client,
        ):
            await until_all(client, True, False)
            await lamps.lit()
            lamps.sent.clear()
            yield lamps, client, broker.url


async def until_all(client: Node, *states: bool) -> None:
    """Wait until all lamps have told that they are in one of these states."""
    answered: set[str] = set()
    with anyio.fail_after(PATIENCE):
        async for change in Devices(client).follow(Light):
            answered |= {change.handle.name} if change.handle.on in states else set()
            if len(answered) == len(LAMPS):
                return


async def turn(client: Node, word: str) -> CommandDevicesResponse:
    words = client.create_client(CommandDevices, COMMAND_DEVICES)
    return await words.call(CommandDevicesRequest(target="lights", command=word), timeout=60)


async def causes(client: Node) -> set[str]:
    entries = (await client.create_client(ReadJournal, READ_JOURNAL).call(ReadJournalRequest())).entries
    return {one.cause for one in entries}


@pytest.mark.parametrize("seed", [1, 2, 3])
async def test_one_message_is_sent_all_prove_it_and_those_that_missed_it_are_repaired(
    lamps_js: Path, tmp_path: Path, seed: int
) -> None:
    async with house(lamps_js, tmp_path, 0.3, seed) as (lamps, client, _):
        answer = await turn(client, "on")
        assert {(one.result.outcome, one.result.evidence) for one in answer.results} == {("confirmed", 3)}
        assert await lamps.lit() == LAMPS
        told = [one for one in lamps.sent if one["command"] != "read"]
        assert told[0]["to"] == "group 1"
        assert {one["to"] for one in told[1:]} >= {f"lamp_{number}" for number in told[0]["missed"]}
        assert len(told) <= len(LAMPS) / 2 + 1  # a lamp that is slow to answer may be told again
        assert "person" not in await causes(client)


async def test_a_scene_of_the_group_is_recalled_by_one_message_and_undone(lamps_js: Path, tmp_path: Path) -> None:
    async with house(lamps_js, tmp_path, 0.0, 1) as (lamps, client, url):
        await turn(client, "on")
        async with MqttConnection(MqttOptions.from_url(url), AiomqttClient, status_topic=None) as link:
            await link.wait_connected()
            stored = {"scene_store": {"ID": 4, "name": "Film"}}
            await link.publish("zigbee2mqtt/living/set", json.dumps(stored).encode(), qos=1)
        scenes = client.create_client(ListScenes, LIST_SCENES)
        with anyio.fail_after(PATIENCE):
            while not (found := (await scenes.call(ScenesRequest())).scenes):  # noqa: ASYNC110 - of another program
                await anyio.sleep(0.1)
        assert [(one.name, len(one.parts)) for one in found] == [("Film", len(LAMPS))]
        await turn(client, "off")
        assert await lamps.lit() == set()
        lamps.sent.clear()

        apply = client.create_client(ApplyScene, APPLY_SCENE)
        answer = await apply.call(ApplySceneRequest(name="Film", issuer="/app"), timeout=60)
        assert answer.success, answer.message
        assert await lamps.lit() == LAMPS
        assert [one["to"] for one in lamps.sent if one["command"] != "read"] == ["group 1"]
        await until_all(client, True)
        undone = await apply.call(ApplySceneRequest(name="Film", issuer="/app", undo=True), timeout=60)
        assert [one.result.outcome for one in undone.results] == ["confirmed"] * len(LAMPS)
        assert await lamps.lit() == set()
        assert "person" not in await causes(client)
