"""The rosbridge player of Foxglove and Lichtblick at the door: types as texts, messages as ROS 2 writes them."""

import json
import subprocess
from pathlib import Path

import anyio
import pytest
from tests.bridges.conftest import OpenHouse, open_house
from tests.messages.test_ros_packages import sample
from tests.peers.node_package import node_folder

from homebot.graph import qos_profile_latched
from homebot.messages.interfaces import find_message
from homebot.messages.json import message_to_json

__all__ = ["open_house"]

TYPES = ("nav_msgs/OccupancyGrid", "nav_msgs/Odometry", "sensor_msgs/LaserScan", "tf2_msgs/TFMessage")


@pytest.fixture(scope="session")
def foxglove() -> Path:
    """Return the folder of its libraries."""
    return node_folder(Path(__file__).parent / "foxglove")


async def test_foxglove_reads_topics(foxglove: Path, open_house: OpenHouse) -> None:
    messages = {f"/{name.lower()}": sample(find_message(name)) for name in TYPES}
    async with open_house() as house, house.node("robot") as robot:
        for topic, message in messages.items():
            robot.create_publisher(type(message), topic, qos_profile_latched).publish(message)
        command = ["node", "player.mjs", str(house.server.port), *messages]
        with anyio.fail_after(60):
            done = await anyio.run_process(command, cwd=foxglove, check=False, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    told = json.loads(done.stdout.decode().strip().splitlines()[-1])
    assert told == {topic: message_to_json(message) for topic, message in messages.items()}
