"""roslib, the library of web pages, at the door: topics in every form it reads, and services both ways."""

import json
import subprocess
from pathlib import Path

import anyio
import pytest
from tests.bridges.conftest import OpenHouse, open_house
from tests.bridges.fibonacci import server
from tests.peers.node_package import node_folder

from homebot.graph import qos_profile_latched
from homebot.messages import SetBool, String
from homebot.messages.std_srvs import SetBoolResponse

__all__ = ["open_house"]


@pytest.fixture(scope="session")
def roslib() -> Path:
    """Return the folder of its program."""
    return node_folder(Path(__file__).parent / "roslib")


@pytest.mark.parametrize("version", ["1", "2"])
async def test_roslib_reads_publishes_calls_and_serves(roslib: Path, open_house: OpenHouse, version: str) -> None:
    async with open_house() as house, house.node("lamp") as lamp:
        state = "Küche: " + "on " * 40
        lamp.create_publisher(String, "/state", qos_profile_latched).publish(String(data=state))
        echoed = lamp.create_publisher(String, "/echoed")
        lamp.create_subscription(String, "/hello", lambda heard: echoed.publish(String(data=f"you said {heard.data}")))
        lamp.create_service(SetBool, "/switch", lambda asked: SetBoolResponse(success=asked.data, message="done"))
        with anyio.fail_after(60):
            done = await anyio.run_process(
                ["node", "client.mjs", version, str(house.server.port)], cwd=roslib, check=False, stderr=subprocess.PIPE
            )
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    told = json.loads(done.stdout.decode().strip().splitlines()[-1])
    assert told.pop("latched") == dict.fromkeys(["none", "png", "cbor"], state)
    assert told.pop("absent").startswith("service /nobody has no server now")
    assert told == {
        "echoed": "you said hi",
        "called": "done",
        "served": "served by roslib",
        "driven": -0.3,
        "sum": 3,
    }


async def test_roslib_sends_goals_and_executes_them(roslib: Path, open_house: OpenHouse) -> None:
    async with open_house() as house, server(house.graph):
        with anyio.fail_after(60):
            done = await anyio.run_process(
                ["node", "actions.mjs", str(house.server.port)], cwd=roslib, check=False, stderr=subprocess.PIPE
            )
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    told = json.loads(done.stdout.decode().strip().splitlines()[-1])
    counted, cancelled, failed, refused = told["client"]
    assert counted == ["result", {"sequence": [0, 1, 1]}, [[0], [0, 1], [0, 1, 2]]]
    assert (cancelled[0], "canceled" in cancelled[1]) == ("failed", True)
    assert (failed[0], "aborted" in failed[1]) == ("failed", True)
    assert (refused[0], "rejected" in refused[1]) == ("failed", True)
    counted, cancelled, failed = told["server"]
    assert counted == ["result", {"sequence": [0, 1]}, [[2]]]
    assert (cancelled[0], "canceled" in cancelled[1]) == ("failed", True)
    assert (failed[0], "aborted" in failed[1]) == ("failed", True)
