"""A robot: it says where it is, asks for the nearest lamp that is off, looks whether it is that, and turns it on."""

import os
import time
from typing import Any

import roslibpy

DOOR = os.environ.get("HOMEBOT_DOOR", "127.0.0.1:9090")
TOKEN = os.environ.get("ROSIE_TOKEN", "")
EYE = "hall_lux"  # a robot with a light sensor or a camera of its own gives the topic of that
MAP_POSE = {"position": {"x": 3.5, "y": 1.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}

host, _, port = DOOR.rpartition(":")
ros = roslibpy.Ros(host, int(port), headers={"Authorization": f"Bearer {TOKEN}"} if TOKEN else None)
ros.run()
pose = roslibpy.Topic(ros, "/rosie/pose", "geometry_msgs/PoseStamped")
query = roslibpy.Service(ros, "/discovery/query", "homebot/QueryDevices")
command = roslibpy.Service(ros, "/devices/command", "homebot/CommandDevices")
identify = roslibpy.ActionClient(ros, "/devices/identify", "homebot/action/IdentifyDevice")
seen: dict[str, Any] = {}

try:
    pose.publish({"header": {"frame_id": "map"}, "pose": MAP_POSE})  # counts for 5 seconds
    time.sleep(0.5)
    found = query.call({"query": "off light near rosie", "limit": 3}, timeout=5)
    if not found["results"]:
        raise SystemExit(found["message"])
    for one in found["results"]:
        print(one["device"]["id"], "-", one["reasons"][0])
    lamp = found["results"][0]["device"]["id"]
    asked = {"candidates": lamp, "topic": EYE, "at_night": True}
    identify.wait_goal(identify.send_goal(asked, seen.update, lambda _: None, print), 90)
    if seen["values"]["device"] != lamp:  # it is not in view, or not sure
        raise SystemExit(f"{lamp} stays as it is: {seen['values']['message']}")
    print(seen["values"]["message"])
    result = command.call({"target": lamp, "command": "on"}, timeout=30)["results"][0]["result"]
    print(f"{lamp} is on: {result['outcome']}, evidence {result['evidence']}")
finally:
    ros.terminate()
