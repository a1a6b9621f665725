"""Runs of routines that homebot ends in the middle, killed or not: what was done is not done again."""

import json
import shutil
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from anyio import to_thread
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest, ListRoutines, RoutinesRequest
from homebot.devices.house_view import HouseView
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES
from homebot.graph import Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import MqttSubscription
from homebot.runtime import Runtime
from homebot.runtime.app_host import STORE_FILE
from homebot.words.queries import parse_query

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant")]

DEVICES = {
    "button/bell": {"name": "Bell", "command_topic": "bell/set"},
    "switch/plug": {"name": "Plug", "command_topic": "plug/set", "state_topic": "plug"},
    "cover/gate": {"name": "Gate", "command_topic": "gate/set", "state_topic": "gate", "device_class": "gate"},
}


class Restarted:
    """A house whose routine is started, and cut off with the command that *cut* is; then it runs again."""

    def __init__(self, broker: MemoryBroker, folder: Path, steps: Sequence[str]) -> None:
        self.heard: list[str] = []
        self._broker = broker
        self._folder = folder
        self._config = parse_config(
            {"gateways": {"mqtt": {}}, "routines": [{"name": "Round", "when": ["23:59"], "do": steps}]}, "test"
        )

    async def notes_after(self, cut: str, *, is_killed: bool, kept: str = "may_repeat") -> list[str]:
        options = MqttOptions(host="memory")
        async with MqttConnection(options, self._broker.make_client, status_topic=None) as field:
            await field.wait_connected()
            await field.subscribe(MqttSubscription("+/set"))
            for topic, told in DEVICES.items():
                kind, name = topic.split("/")
                config = json.dumps({"unique_id": name, "device": {"identifiers": [name]}} | told).encode()
                await field.publish(f"homeassistant/{topic}/config", config, retain=True)
                await field.publish(name, b"OFF" if kind == "switch" else b"closed", retain=True)
            folder = self._folder / "first"
            async with self._running(folder) as node:
                view = HouseView.of(node)
                while len((await view.find(parse_query(""))).devices) < len(DEVICES):  # noqa: ASYNC110 - gateways find them
                    await anyio.sleep(0.05)
                change = node.create_client(ChangeRoutine, CHANGE_ROUTINE)
                assert (await change.call(ChangeRoutineRequest(name="Round", change="run"))).success
                await self._listen(field, cut)
                if is_killed:  # this is what is on the disk then
                    copy = self._folder / "copy"
                    while not await to_thread.run_sync(is_kept, folder, kept):  # noqa: ASYNC110 - a thread writes it
                        await anyio.sleep(0.01)
                    shutil.copytree(folder, copy)
                    folder = copy
            self.heard.append("restart")
            async with self._running(folder) as node:
                listing = node.create_client(ListRoutines, LIST_ROUTINES)
                while True:
                    (found,) = (await listing.call(RoutinesRequest())).routines
                    if not found.is_running and len(found.notes) > 1:
                        break
                    with anyio.move_on_after(0.1):
                        await self._listen(field, "")
            return [one.text for one in found.notes]

    @asynccontextmanager
    async def _running(self, folder: Path) -> AsyncIterator[Node]:
        folder.mkdir(exist_ok=True)
        services = [HostedBroker.in_memory(self._broker)]
        async with (
            Runtime(
                self._config, with_door=False, services=services, trusts_apps=True, index_file=folder / "index.sqlite"
            ) as runtime,
            Node(runtime.graph, "tester") as node,
        ):
            yield node

    async def _listen(self, field: MqttConnection, cut: str) -> None:
        while not cut or cut not in self.heard:
            for message in await field.receive():
                self.heard.append(f"{message.topic.removesuffix('/set')} {message.payload.decode()}")
                if message.topic == "plug/set" and cut != self.heard[-1]:
                    await field.publish("plug", message.payload, retain=True)


def is_kept(folder: Path, place: str) -> bool:
    """Return whether the place of the run is on the disk."""
    return any(place.encode() in file.read_bytes() for file in folder.glob(f"{STORE_FILE}*"))


UNKNOWN = "homebot ended, and whether it was done is unknown, so it is not done again"


@pytest.mark.parametrize("end", ["ended", "killed"])
@pytest.mark.parametrize(
    ("steps", "cut", "heard", "note"),
    [
        (
            ["Plug on", "wait 1s", "Bell press"],
            "plug ON",
            "plug ON, restart, plug ON, bell PRESS",
            "went on at 'Plug on'",
        ),
        (
            ["for each Plug: it on; wait 1s; Bell press"],
            "plug ON",
            "plug ON, restart, plug ON, bell PRESS",
            "went on at 'it on'",
        ),
        (
            ["Bell press", "Gate open"],
            "gate OPEN",
            "bell PRESS, gate OPEN, restart",
            f"stopped in step 2, 'Gate open': {UNKNOWN}",
        ),
        (
            ["Plug toggle", "Bell press"],
            "plug ON",
            "plug ON, restart",
            f"stopped in step 1, 'Plug toggle': {UNKNOWN}",
        ),
    ],
)
async def test_what_acts_each_time_is_done_once(
    tmp_path: Path, steps: list[str], cut: str, heard: str, note: str, end: str
) -> None:
    with anyio.fail_after(PATIENCE):
        async with MemoryBroker() as broker:
            house = Restarted(broker, tmp_path, steps)
            assert (await house.notes_after(cut, is_killed=end == "killed"))[1:] == [note]
            assert ", ".join(house.heard) == heard


async def test_a_wait_goes_on_after_a_sudden_death_soon_after_a_press(tmp_path: Path) -> None:
    with anyio.fail_after(PATIENCE):
        async with MemoryBroker() as broker:
            house = Restarted(broker, tmp_path, ["Bell press", "wait 5s", "Plug on"])
            notes = await house.notes_after("bell PRESS", is_killed=True, kept="step 2, 'wait 5s'")
            assert notes[1:] == ["went on at 'wait 5s'"]
            assert ", ".join(house.heard) == "bell PRESS, restart, plug ON"
