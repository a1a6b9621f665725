"""Copies of the files of a run: they have what was only in memory."""

import sqlite3
from pathlib import Path
from typing import Any

import anyio
from tests.patience import PATIENCE

from homebot.apps import App
from homebot.config import parse_config
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.names import COPY_FILES, PERFORM_COMMAND
from homebot.graph import Node
from homebot.messages.std_srvs import Trigger, TriggerRequest
from homebot.runtime import Runtime


class Storing(App):
    """Stores a value, and answers when it has."""

    async def run(self) -> None:
        self.store["count"] = self.store.get("count", 0) + 1
        self.node.create_service(Trigger, "/stored", lambda _: Trigger.Response(success=True, message=""))
        await anyio.sleep_forever()


def rows(folder: str, name: str, query: str) -> list[Any]:
    connection = sqlite3.connect(Path(folder) / name)
    try:
        return connection.execute(query).fetchall()
    finally:
        connection.close()


async def test_copies_have_the_commands_and_values_of_the_last_minutes(tmp_path: Path) -> None:
    config = parse_config({"apps": {"storing": {"class": f"{__name__}:Storing"}}}, "test")
    command = CommandRequest(device="lamp", settings=(Setting.of("on_off", plain=True),), issuer="/node")
    for run in (1, 2):  # the first one makes the files
        with anyio.fail_after(PATIENCE):
            async with (
                Runtime(config, with_door=False, index_file=tmp_path / "index.sqlite") as runtime,
                Node(runtime.graph, "node") as node,
            ):
                await node.create_client(Trigger, "/stored").call(TriggerRequest())
                await node.create_client(PerformCommand, PERFORM_COMMAND).call(command)
                answer = await node.create_client(Trigger, COPY_FILES).call(TriggerRequest())
                assert answer.success
                assert rows(answer.message, "apps.sqlite", "SELECT value FROM store") == [(str(run),)]
                assert rows(answer.message, "journal.sqlite", "SELECT count(*) FROM entries") == [(2 * run,)]
