"""The house as it is now, as far as a goal concerns it: its devices, doors, scenes and robots."""

from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from homebot.devices import Device, DevicePart
from homebot.devices.capabilities import LIGHTS_UP
from homebot.devices.device import State
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.device_names import devices_called
from homebot.devices.names import GET_PLACES, WHERE_IS_ROBOT
from homebot.devices.places_messages import DoorInfo, GetPlaces, GetPlacesResponse
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.scene_client import Scenes
from homebot.devices.scene_messages import SceneInfo
from homebot.devices.value import PlainValue, Value
from homebot.devices.value_comparison import END_POSITIONS
from homebot.errors import ServiceUnavailableError, UsageError
from homebot.features.goals.operators import PlanStep
from homebot.graph import EntityKind, Node
from homebot.robots.drive import check_move
from homebot.words.steps import SendRobot
from homebot.words.wishes import KnownNames

Assumed = MutableMapping[tuple[str, str], dict[str, PlainValue]]
"""Values that parts got without reporting them, by device and part."""

OPENINGS: Final = frozenset({"movement", "position"})
_NO_ROBOT: Final = "; of devices name the state too, as in 'lights in hall on'"
_DRIVE_ACTIONS: Final = ("/navigate_to_pose", "/dock_robot")


@dataclass(frozen=True, slots=True)
class HouseSnapshot:
    """The house at a moment.

    Attributes:
        devices: By id.
        robots: The room of each robot of the goal, by the name in the goal.
        lost: Why the room of a robot is unknown, by that name.
        problems: Why a robot cannot be sent, by that name.
    """

    devices: Mapping[str, Device]
    doors: Sequence[DoorInfo]
    robots: Mapping[str, str]
    lost: Mapping[str, str]
    problems: Mapping[str, str]

    def called(self, named: str) -> Device | None:
        """Return the first device with that id or name; None if there is none."""
        if not named or named in self.devices:
            return self.devices.get(named)
        return min(devices_called(named, self.devices.values()), key=lambda device: device.id, default=None)

    def after(self, steps: Iterable[PlanStep]) -> "HouseSnapshot":
        """Return the house as it is when *steps* are done."""
        devices, robots = dict(self.devices), dict(self.robots)
        for step in steps:
            if step.kind == "drive":
                robots[step.place] = step.room
            for device, part, settings in step.parts:
                if device in devices and (known := devices[device].part(part)) is not None:
                    devices[device] = _with_values(devices[device], part, _implied(known, dict(settings)))
        return replace(self, devices=devices, robots=robots)


class HouseReader:
    """Reads the house.

    Attributes:
        node: The node that reads it.
        lookup: The look-up of its devices.
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        self.lookup = DeviceLookup(node)
        self._places = node.create_client(GetPlaces, GET_PLACES)
        self._where = node.create_client(WhereIsRobot, WHERE_IS_ROBOT)

    async def places(self) -> GetPlacesResponse:
        """Return the rooms and doors."""
        return await self._places.call(GetPlaces.Request())

    async def scenes(self) -> tuple[SceneInfo, ...]:
        """Return the scenes; none in a house without the service."""
        try:
            return await Scenes(self.node).list()
        except ServiceUnavailableError:
            return ()

    async def names(self, scenes: Iterable[SceneInfo]) -> KnownNames:
        """Return the names that a wish may have."""
        rooms = (await self.places()).rooms
        areas = dict.fromkeys(room.name for room in rooms) | dict.fromkeys(room.floor for room in rooms)
        areas |= dict.fromkeys(device.area for device in await self.lookup.devices())
        actions = [endpoint.name for endpoint in self.node.graph.get_endpoints(kind=EntityKind.ACTION_SERVER)]
        robots = [
            name.removesuffix(action).rpartition("/")[2] or "robot"
            for name in actions
            for action in _DRIVE_ACTIONS
            if name.endswith(action)
        ]
        return KnownNames(
            [room.name for room in rooms], [area for area in areas if area], robots, [scene.name for scene in scenes]
        )

    async def read(self, robots: Iterable[tuple[str, str]], assumed: Assumed) -> HouseSnapshot:
        """Return the house with *robots*, each with the room that it is to reach.

        Raises:
            UsageError: There is no such robot.
            ServiceError: The directory does not answer.
        """
        devices = {device.id: _assuming(device, assumed) for device in await self.lookup.devices()}
        at, lost, problems = dict[str, str](), dict[str, str](), dict[str, str]()
        for robot, room in robots:
            where = await self._robot(robot)
            if where.success and where.pose[0].room:
                at[robot] = where.pose[0].room
            else:
                lost[robot] = where.message or f"the room of {robot} is unknown"
            try:
                await check_move(self.node, SendRobot("", robot, room))
            except UsageError as exc:
                problems[robot] = str(exc)
        return HouseSnapshot(devices, (await self.places()).doors, at, lost, problems)

    async def _robot(self, robot: str) -> WhereIsRobotResponse:
        try:
            where = await self._where.call(WhereIsRobotRequest(robot=robot))
        except ServiceUnavailableError:
            raise UsageError(
                f"there is no robot {robot!r}: none has said where it is, for example on /NAME/pose{_NO_ROBOT}"
            ) from None
        if where.is_mistake:
            raise UsageError(f"{where.message}{_NO_ROBOT}")
        return where


def _with_values(device: Device, part: str, values: Mapping[str, PlainValue]) -> Device:
    kept = tuple(state for state in device.states if state.part != part or state.capability not in values)
    at = device.last_seen
    new = tuple(
        State(part=part, capability=name, value=Value.of(value), since=at, told_at=at, live=True)
        for name, value in values.items()
    )
    return device.model_copy(update={"states": (*kept, *new)})


def _implied(part: DevicePart, settings: Mapping[str, PlainValue]) -> dict[str, PlainValue]:
    """Return the values of *part* after a command with *settings*."""
    able = {capability.name for capability in part.part.capabilities}
    values: dict[str, PlainValue] = {}
    for capability, value in settings.items():
        if capability in LIGHTS_UP and "on_off" in able:
            values["on_off"] = value != 0
        if capability in OPENINGS:
            is_open = value != 0 if capability == "position" else value == "open"
            said: dict[str, PlainValue] = {"movement": "open" if is_open else "closed", "contact": is_open}
            values |= {capability: said[capability] for capability in said if capability in able}
            if capability == "movement" and "position" in able and value in END_POSITIONS:
                values["position"] = END_POSITIONS[value]
    return {**values, **settings}


def _assuming(device: Device, assumed: Assumed) -> Device:
    known = {(state.part, state.capability) for state in device.states}
    for part in device.parts:
        values = assumed.get((device.id, part.id), {})
        if unknown := {name: value for name, value in values.items() if (part.id, name) not in known}:
            device = _with_values(device, part.id, unknown)
    return device
