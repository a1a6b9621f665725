"""Robots as clients of a running homebot: roslibpy with and without the right, and one that dies."""

import json
import sys
import textwrap
from pathlib import Path

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.bridges.rosbridge import Door
from homebot.config import parse_config
from homebot.devices.names import ROBOT_POSES
from homebot.devices.robot_messages import RobotPose
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.runtime import Runtime

pytestmark = pytest.mark.system

CLIENT = textwrap.dedent(
    """
    import json, sys, time, roslibpy

    ros = roslibpy.Ros(f"ws://127.0.0.1:{sys.argv[1]}/?token={sys.argv[2]}")
    ros.run(timeout=40)
    stamp, turn = {"sec": 0, "nanosec": 0}, {"x": 0, "y": 0, "z": 0, "w": 1}
    topics = {
        "/robot/pose": ("geometry_msgs/PoseStamped", {"header": {"stamp": stamp, "frame_id": "map"}, "pose": {
            "position": {"x": float(sys.argv[3]), "y": 1, "z": 0}, "orientation": turn}}),
        "/rosie/room": ("homebot/RobotRoom", {"robot": "rosie", "room": "Cellar"}),
        "/tf": ("tf2_msgs/TFMessage", {"transforms": [{"header": {"stamp": stamp, "frame_id": "map"},
            "child_frame_id": "base_link", "transform": {"translation": {"x": 9, "y": 9, "z": 0}, "rotation": turn}}]}),
    }
    for name in sys.argv[4:]:
        ros_type, message = topics[name]
        roslibpy.Topic(ros, name, ros_type).publish(roslibpy.Message(message))
    where = roslibpy.Service(ros, "/robots/where", "homebot/srv/WhereIsRobot")
    time.sleep(0.5)
    print(json.dumps(dict(where.call(roslibpy.ServiceRequest({}), timeout=40))), flush=True)
    ros.terminate()
    """
)


async def test_only_the_client_with_the_right_says_where_the_robot_is(tmp_path: Path) -> None:
    tokens = {}
    for name, scope in (("rosie", ["read", "robot: rosie"]), ("guest", ["read", "act: all", "manage", "raw"])):
        file = tmp_path / name
        file.touch(mode=0o600)
        file.write_text(f"{name}-secret\n")
        tokens[name] = {"token_file": str(file), "scope": scope}
    config = parse_config({"door": {"port": 0, "tokens": tokens}}, "homebot.toml", tmp_path)
    with anyio.fail_after(PATIENCE):
        async with Runtime(config) as runtime, Node(runtime.graph, "watcher") as watcher:
            assert isinstance(runtime.door, Door)
            kept = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            poses = watcher.create_subscription(RobotPose, ROBOT_POSES, None, kept)

            port = runtime.door.port

            async def client(name: str, x: float, *topics: str) -> dict[str, object]:
                arguments = (sys.executable, "-c", CLIENT, str(port), f"{name}-secret", str(x), *topics)
                done = await anyio.run_process(arguments, check=False)
                assert done.stdout, done.stderr.decode()
                answer: dict[str, object] = json.loads(done.stdout)
                return answer

            refused = await client("guest", 7.0, "/robot/pose", "/rosie/room", "/tf")
            assert refused["message"] == "the position of rosie is not known yet"
            told = await client("rosie", 3.0, "/robot/pose")
            assert told["success"] is True
            await client("guest", 7.0, "/robot/pose", "/rosie/room", "/tf")
            assert {(pose.x, pose.source) for pose in iter(poses.take, None)} == {(3.0, "/robot/pose")}
