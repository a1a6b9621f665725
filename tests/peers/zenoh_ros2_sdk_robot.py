"""A robot by zenoh-ros2-sdk, in a process of its own because its threads do not end: ``zenoh_ros2_sdk_robot.py PORT``.

It prints what it finds at the house, then each number that it hears.
"""

import json
import sys
import threading
from typing import Any

import zenoh_ros2_sdk as sdk

STRING = ("std_msgs/msg/String", "string data")
NUMBER = ("std_msgs/msg/Int32", "int32 data")
TRIGGER = "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
TYPES = {
    "srv_type": "rcl_interfaces/srv/GetParameterTypes",
    "request_definition": "string[] names",
    "response_definition": "uint8[] types",
    "type_hash": "RIHS01_da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
}
LATCHED = ":1:,1:,:,:,,"


def main(port: int) -> None:
    sdk.ZenohSession.get_instance("127.0.0.1", port)
    service: dict[str, Any] = {
        "srv_type": "std_srvs/srv/Trigger",
        "request_definition": "",
        "response_definition": "bool success\nstring message",
        "type_hash": TRIGGER,
        "namespace": "/rosie",
        "node_name": "brain",
    }
    words = publisher("/rosie/words")
    rooms, has_rooms = [], threading.Event()

    def got_rooms(message: Any) -> None:
        rooms.append(message.data)
        has_rooms.set()

    kept: list[Any] = [sdk.ROS2ServiceServer("/rosie/dock", callback=lambda _: docked(kept[0]), **service)]
    light = sdk.ROS2ServiceClient("/house/light", **service)
    response: Any = light.call(structure_needs_at_least_one_member=0)
    types: Any = sdk.ROS2ServiceClient("/app/get_parameter_types", **{**service, **TYPES}).call(names=["speed"])
    kept.append(sdk.ROS2Subscriber("/map", STRING[0], got_rooms, STRING[1], qos=LATCHED))
    kept.append(sdk.ROS2Subscriber("/house/number", NUMBER[0], lambda one: tell(str(one.data)), NUMBER[1]))
    has_rooms.wait(30)
    facts = {
        "map": rooms[0],
        "light": [response.success, response.message],
        "types": [int(one) for one in types.types],
        "topics": sorted(name for name, _ in sdk.get_topic_names_and_types()),
        "services": sorted(name for name, _ in sdk.get_service_names_and_types()),
    }
    tell(json.dumps(facts))
    while True:
        words.publish(data="hello")
        threading.Event().wait(0.1)


def publisher(topic: str) -> Any:
    return sdk.ROS2Publisher(topic, *STRING, namespace="/rosie", node_name="brain")


def docked(server: Any) -> Any:
    return server.response_msg_class(success=True, message="docked")


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(int(sys.argv[1]))
