"""What a robot that streams costs while nobody reads."""

import json
import os
import time
from pathlib import Path

import pytest
from tests.patience import PATIENCE
from tests.system.attack_probe import attacked
from tests.turns import slowness
from websockets.sync.client import ClientConnection, connect

pytestmark = [pytest.mark.system, pytest.mark.no_cover]

MOST_BUSY = 0.05
"""Of a core of the reference machine."""

SECONDS = 5
HEADER = {"stamp": {"sec": 1, "nanosec": 5}, "frame_id": "odom"}
POINT = {"x": 1.23456789, "y": 2.3456789, "z": 0.0}
TURN = {"x": 0.0, "y": 0.0, "z": 0.123123123, "w": 0.99123123}
POSE = {"pose": {"position": POINT, "orientation": TURN}, "covariance": [0.001] * 36}
TWIST = {"twist": {"linear": POINT, "angular": POINT}, "covariance": [0.001] * 36}
TF = {
    "transforms": [{"header": HEADER, "child_frame_id": "base", "transform": {"translation": POINT, "rotation": TURN}}]
}
ODOMETRY = {"header": HEADER, "child_frame_id": "base", "pose": POSE, "twist": TWIST}
SCAN = {
    "header": HEADER,
    **dict.fromkeys(("angle_min", "angle_max", "angle_increment", "time_increment", "scan_time"), 0.1),
    "range_min": 0.1,
    "range_max": 12.0,
    "ranges": [number / 77 for number in range(720)],
    "intensities": [],
}
STREAMS = (
    ("/streams/transforms", "tf2_msgs/TFMessage", 50, TF),
    ("/streams/odometry", "nav_msgs/Odometry", 30, ODOMETRY),
    ("/streams/scan", "sensor_msgs/LaserScan", 10, SCAN),
)


def test_a_robot_whose_streams_nobody_reads_costs_a_twentieth_of_a_core(tmp_path: Path) -> None:
    with attacked(tmp_path) as homebot, connect(homebot.url, proxy=None, compression=None) as robot:
        frames = []
        for topic, ros_type, rate, message in STREAMS:
            robot.send(json.dumps({"op": "advertise", "topic": topic, "type": ros_type}))
            text = json.dumps({"op": "publish", "topic": topic, "msg": message})
            robot.send(text)
            frames += [(number / rate, text) for number in range(rate * SECONDS)]
        settle(robot)
        time.sleep(SECONDS)  # homebot starts up meanwhile
        before, began = processor_time(homebot.pid), time.monotonic()
        for due, text in sorted(frames):
            time.sleep(max(0.0, began + due - time.monotonic()))
            robot.send(text)
        settle(robot)
        after = processor_time(homebot.pid)
        time.sleep(SECONDS)
        idle = processor_time(homebot.pid) - after
    share = (after - before - idle) / SECONDS
    print(f"\na robot that streams costs {share:.1%} of a core")
    assert share < MOST_BUSY * slowness()


def settle(robot: ClientConnection) -> None:
    robot.send(json.dumps({"op": "call_service", "id": "settle", "service": "/rosapi/get_time"}))
    while json.loads(robot.recv(timeout=PATIENCE)).get("id") != "settle":
        pass


def processor_time(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
