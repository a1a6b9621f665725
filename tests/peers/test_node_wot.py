"""Eclipse Thingweb node-wot reads homebot's directory of things, and commands a lamp in it."""

import json
import subprocess
from pathlib import Path

import anyio
import pytest
from tests.bridges.thing_directory.conftest import OpenHouse, served_house
from tests.peers.node_package import node_folder

__all__ = ["served_house"]


@pytest.fixture(scope="session")
def node_wot() -> Path:
    """Return the folder of its program."""
    return node_folder(Path(__file__).parent / "node_wot")


async def test_node_wot_lists_reads_and_commands_a_device(
    node_wot: Path,
    served_house: OpenHouse,
) -> None:
    async with served_house() as house:
        with anyio.fail_after(60):
            done = await anyio.run_process(
                ["node", "client.mjs", house.url, "Hall lamp"], cwd=node_wot, check=False, stderr=subprocess.PIPE
            )
        assert done.returncode == 0, done.stderr.decode()[-2000:]
        told = json.loads(done.stdout.decode().strip().splitlines()[-1])
        assert sorted(told["titles"]) == ["Attic", "Hall lamp"]
        assert (told["before"], told["after"]) == (40, {"on_off": False, "level": 70})
        assert [one.capability for one in house.gateway.commands] == ["level", "on_off"]
