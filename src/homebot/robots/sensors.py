"""Positions of robots from other sources: motion sensors, tags that a robot reads, and poses over MQTT."""

from collections.abc import Iterable

from pydantic import ValidationError

from homebot.conventions.payload import clean_text
from homebot.conventions.robot_pose import pose_readers
from homebot.devices.devices import Devices, MessageHandler
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.handles.sensors import OccupancySensor
from homebot.devices.names import TagNames
from homebot.devices.tags import TagTap
from homebot.errors import RefusedError, ServiceError
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.messages.json import validation_problem
from homebot.places.rigid import MapPose
from homebot.robots.robot import MOTION_LIMIT, TAG_LIMIT, TrackedRobot
from homebot.robots.settings import JsonPose
from homebot.support.folding import fold

NOT_READ = "robots.not_read"

_MAX_POSE = 4096

_ERROR = 0.5
"""The error of a position in metres if its source states none."""


def read_tags(node: Node, robot: TrackedRobot) -> None:
    """Place *robot* in the room of each tag that it reads."""

    def on_tap(tap: TagTap) -> None:
        if tap.reader == robot.settings.tag_reader and tap.area:
            robot.place(f"tag {tap.tag}", TAG_LIMIT, room=tap.area)

    node.create_subscription(TagTap, TagNames("nfc").taps, on_tap)


async def follow_motion(devices: Devices, robots: Iterable[TrackedRobot]) -> None:
    """Place each of *robots* in the room of its motion sensors when these begin to detect motion; until cancelled."""
    by_sensor = _by_sensor(robots)
    since: dict[str, float] = {}
    async for change in devices.follow(OccupancySensor, optional=True):
        handle = change.handle
        robot = by_sensor.get(handle.id) or by_sensor.get(fold(handle.name))
        if robot is None or change.kind == "removed" or handle.since("occupancy") == since.get(handle.id):
            continue  # other changes, as of its link, are no motion
        since[handle.id] = handle.since("occupancy")
        if handle.area and handle.occupied and handle.freshness == "fresh":
            robot.place(handle.id, MOTION_LIMIT, room=handle.area, by_robot=False)


def _by_sensor(robots: Iterable[TrackedRobot]) -> dict[str, TrackedRobot]:
    """Return the robots by the ids, names and folded names of their motion sensors."""
    return {key: robot for robot in robots for name in robot.settings.motion_sensors for key in (name, fold(name))}


async def read_poses(node: Node, devices: Devices, robot: TrackedRobot) -> None:
    """Place *robot* according to the poses on its topic, of a form that an integration reads, or our own."""
    log, settings, readers = LogLimit(node.graph.clock), robot.settings, pose_readers()
    lies_at = MapPose(*settings.map_transform or (0.0, 0.0, 0.0))

    def on_pose(message: RawMessage) -> None:
        if message.retained:  # its age is not known
            return
        stated = next((one for reader in readers if (one := reader.read(message.payload)) is not None), None)
        if stated is not None:
            if stated.at is None:
                robot.drop(settings.topic)
            else:
                limit = settings.limit if stated.limit is None else stated.limit
                robot.place(settings.topic, limit, lies_at.then(stated.at), error=_ERROR, floor=settings.floor)
            return
        try:
            reported = JsonPose.model_validate_json(message.payload[:_MAX_POSE])
        except ValidationError as exc:
            if log.allows(NOT_READ) is not None:
                problem = validation_problem(exc)
                node.log.warning(NOT_READ, message=f"a pose on {message.address} is not read: {problem}")
            return
        limit = settings.limit if reported.limit is None else reported.limit
        place: dict[str, object] = {"room": clean_text(reported.room), "floor": clean_text(reported.floor)}
        at = None if reported.x is None or reported.y is None else MapPose(reported.x, reported.y, reported.yaw)
        if at is not None:
            place["error"] = reported.error
        robot.place(settings.topic, limit, at, age=0.0, by_robot=True, **place)

    await listen(node, devices, settings.gateway, settings.topic, on_pose)


async def listen(node: Node, devices: Devices, gateway: str, topic: str, handler: MessageHandler) -> None:
    """Call *handler* with the messages on *topic* of *gateway*."""
    try:
        await devices.listen_to(topic, handler, gateway)
    except (RefusedError, ServiceError) as exc:
        node.log.warning(NOT_READ, message=f"{topic} is not read: {exc}", topic=topic)
