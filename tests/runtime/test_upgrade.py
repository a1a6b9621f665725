"""Data that earlier versions wrote: each folder of ``written_by`` is a ``HOMEBOT_DATA`` as that version left it.

They hold a lamp with a further name and a tag, a thermometer that the owner placed, a lock that was approved, and the
journal of two commands.
"""

import shutil
from pathlib import Path

import pytest
from anyio import to_thread

from homebot.config import load_config
from homebot.devices import Devices
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import READ_JOURNAL
from homebot.graph import Node
from homebot.runtime import Runtime
from homebot.runtime.home_folder import settle_home
from homebot.version import __version__

WRITTEN = Path(__file__).parent / "written_by"
CONFIG = '[home]\nname = "upgrade"\n\n[gateways.mqtt]\nurl = "mqtt://127.0.0.1:18873"\n'


@pytest.mark.parametrize("version", sorted(folder.name for folder in WRITTEN.iterdir()))
async def test_data_of_an_earlier_version_are_taken_over_and_nothing_is_lost(
    version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, file = tmp_path / "data", tmp_path / "homebot.toml"
    shutil.copytree(WRITTEN / version, data)
    monkeypatch.setenv("HOMEBOT_DATA", str(data))
    file.write_text(CONFIG)
    for _ in ("first", "again"):
        config = await to_thread.run_sync(load_config, file)
        index_file = await to_thread.run_sync(settle_home, config, file)
        runtime = Runtime(config, with_door=False, index_file=index_file)
        async with runtime, Node(runtime.graph, "asker") as asker:
            devices = Devices(asker)
            (lamp,), (lock,), (thermometer,) = [
                await devices.find(kind) for kind in ("light", "door_lock", "temperature_sensor")
            ]
            assert (lamp.name, lamp.names, lamp.area, lamp.tags) == (
                "Ceiling lamp",
                ("Ceiling lamp", "Kitchen lamp"),
                "Kitchen",
                ("cosy",),
            )
            assert (thermometer.name, thermometer.area) == ("Attic thermometer", "Attic")
            assert {fact.name: fact.value for fact in lock.facts}["approved"] == "yes"
            journal = await asker.create_client(ReadJournal, READ_JOURNAL).call(ReadJournalRequest())
            assert [entry.kind for entry in journal.entries if entry.device == lamp.id].count("outcome") == 2


def test_there_are_data_of_each_version_that_was_released() -> None:
    changelog = (Path(__file__).parents[2] / "CHANGELOG.md").read_text()
    released = [line.split()[1] for line in changelog.splitlines() if line.startswith("## ") and line[3].isdigit()]
    assert released[0] == __version__
    assert released[1:] == sorted((folder.name for folder in WRITTEN.iterdir()), reverse=True)
