"""A robot in a process of its own: it says where it is, asks for the nearest lamp that is off, and turns it on."""

import os
import time
from typing import Any

import roslibpy

DOOR = os.environ.get("HOMEBOT_DOOR", "127.0.0.1:9090")
TOKEN = os.environ.get("ROSIE_TOKEN", "")
MAP_POSE = {"position": {"x": 3.5, "y": 1.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}

host, _, port = DOOR.rpartition(":")
ros = roslibpy.Ros(host, int(port), headers={"Authorization": f"Bearer {TOKEN}"} if TOKEN else None)
ros.run()
pose = roslibpy.Topic(ros, "/rosie/pose", "geometry_msgs/PoseStamped")
query = roslibpy.Service(ros, "/discovery/query", "homebot/QueryDevices")
command = roslibpy.Service(ros, "/devices/command", "homebot/CommandDevices")


def find(text: str) -> dict[str, Any]:
    pose.publish({"header": {"frame_id": "map"}, "pose": MAP_POSE})  # counts for 5 seconds
    time.sleep(0.5)
    answer: dict[str, Any] = query.call({"query": text, "limit": 3}, timeout=5)
    return answer


try:
    found = find("off light near rosie")
    if not found["results"]:
        raise SystemExit(found["message"])
    for one in found["results"]:
        print(one["device"]["id"], "-", one["reasons"][0])
    lamp = found["results"][0]["device"]["id"]
    result = command.call({"target": lamp, "command": "on"}, timeout=30)["results"][0]["result"]
    print(f"{lamp} is on: {result['outcome']}, evidence {result['evidence']}")
finally:
    ros.terminate()
