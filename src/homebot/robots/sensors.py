"""Places of robots from other sources of the house: motion sensors, tags that a robot reads, and poses by MQTT."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from homebot.conventions.payload import parse_object, text_of
from homebot.devices.devices import Devices
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.handles.sensors import OccupancySensor
from homebot.devices.names import TagNames
from homebot.devices.tags import TagTap
from homebot.errors import WireError
from homebot.graph import Node
from homebot.robots.evidence import MOTION_LIMIT, TAG_LIMIT, MapPose, PoseEvidence
from homebot.support.folding import fold
from homebot.support.numbers import finite_number

if TYPE_CHECKING:
    from homebot.robots.tracker import RobotTracker

__all__ = ["follow_motion", "read_pose", "read_tags"]

_ERROR: Final = 0.5
_LONGEST_LIMIT: Final = 3600.0
_LONGEST_POSE: Final = 4096


def read_tags(tracker: RobotTracker, node: Node, robot: str, reader: str) -> None:
    """Place *robot* in the room of each tag that its *reader* reads."""

    def on_tap(tap: TagTap) -> None:
        if tap.reader == reader and tap.area:
            tracker.add_room(robot, f"tag {tap.tag}", tap.area, TAG_LIMIT)

    node.create_subscription(TagTap, TagNames("nfc").taps, on_tap)


async def follow_motion(tracker: RobotTracker, node: Node, sensors: dict[str, str]) -> None:
    """Place the robot of each of *sensors*, by name or id, in its room while it detects motion; until cancelled."""
    async for change in Devices(node).follow(OccupancySensor):
        handle = change.handle
        robot = sensors.get(handle.id) or sensors.get(fold(handle.name))
        if robot and handle.area and handle.occupied and change.kind != "removed":
            tracker.add_room(robot, handle.id, handle.area, MOTION_LIMIT)


def read_pose(tracker: RobotTracker, node: Node, robot: str, message: RawMessage) -> None:
    """Place *robot* by a pose as JSON.

    Raises:
        WireError: It has neither numbers ``x`` and ``y`` nor a room, or a number is out of its range.
    """
    values = parse_object(message.payload, _LONGEST_POSE)
    number = partial(_number, values)
    room, stated = text_of(values.get("room")), values.keys() & {"x", "y"}
    if not stated and not room:
        raise WireError("the pose has neither x and y nor a room")
    limit = number("limit", 0.1, _LONGEST_LIMIT, tracker.settings[robot].limit)
    if not stated:
        tracker.add_room(robot, message.address, room, limit)
        return
    position = MapPose(number("x", -10_000, 10_000), number("y", -10_000, 10_000), number("yaw", -7, 7, 0.0))
    floor = text_of(values.get("floor")) or tracker.floor_of(robot)
    error = number("error", 0.0, 1000.0, _ERROR)
    now = node.graph.clock.monotonic()
    tracker.add(robot, PoseEvidence(message.address, now, limit, error, position, room, floor))


def _number(values: dict[str, object], key: str, least: float, most: float, default: float | None = None) -> float:
    value = values.get(key, default)
    number = finite_number(value)
    if number is None or not least <= number <= most:
        raise WireError(f"{key} is {value!r:.40}, not a number from {least:g} to {most:g}")
    return number
