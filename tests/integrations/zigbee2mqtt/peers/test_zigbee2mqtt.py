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
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.handles import Light
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import COMMAND_DEVICES, READ_JOURNAL
from homebot.graph import Node
from homebot.mqtt.broker import Broker
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
async def lamps_at(url: str, program: Path, folder: Path, seed: int) -> AsyncIterator[Lamps]:
    command = ["node", "lamps.mjs", str(folder), url, str(len(LAMPS)), "0.3", str(seed)]
    async with await anyio.open_process(command, cwd=program, stderr=subprocess.STDOUT) as process:
        lamps = Lamps(process)
        try:
            await lamps.until("ready")
            yield lamps
        finally:
            process.kill()


@pytest.mark.parametrize("seed", [1, 2, 3])
async def test_one_message_is_sent_all_prove_it_and_those_that_missed_it_are_repaired(
    lamps_js: Path, tmp_path: Path, seed: int
) -> None:
    async with Broker() as broker:
        config = parse_config({"gateways": {"mqtt": {"url": broker.url, "act": True}}}, "homebot.toml")
        async with (
            lamps_at(broker.url, lamps_js, tmp_path / "data", seed) as lamps,
            Runtime(config, with_door=False) as runtime,
            Node(runtime.graph, "client") as client,
        ):
            answered: set[str] = set()
            with anyio.fail_after(PATIENCE):
                async for change in Devices(client).follow(Light):
                    answered |= {change.handle.name} if change.handle.on is not None else set()
                    if len(answered) == len(LAMPS):
                        break
            await lamps.lit()
            lamps.sent.clear()
            words = client.create_client(CommandDevices, COMMAND_DEVICES)
            answer = await words.call(CommandDevicesRequest(target="lights", command="on"), timeout=60)
            assert {(one.result.outcome, one.result.evidence) for one in answer.results} == {("confirmed", 3)}
            assert await lamps.lit() == LAMPS
            told = [one for one in lamps.sent if one["command"] != "read"]
            assert told[0]["to"] == "group 1"
            assert {one["to"] for one in told[1:]} >= {f"lamp_{number}" for number in told[0]["missed"]}
            assert len(told) <= len(LAMPS) / 2 + 1  # a lamp that is slow to answer may be told again
            entries = (await client.create_client(ReadJournal, READ_JOURNAL).call(ReadJournalRequest())).entries
            assert "person" not in {one.cause for one in entries}
