"""The house as it is now, as far as a goal concerns it: its devices, rooms, doors and robots."""

from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass

from homebot.devices import Device
from homebot.devices.device import State
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import GET_PLACES, WHERE_IS_ROBOT
from homebot.devices.places_messages import DoorInfo, GetPlaces, GetPlacesResponse
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.devices.value import PlainValue, Value
from homebot.errors import ServiceUnavailableError, UsageError
from homebot.graph import Node
from homebot.routines.robot_drive import check_drive
from homebot.routines.steps import SendRobot
from homebot.support.folding import fold

__all__ = ["Assumed", "HouseNow", "HouseReader", "with_values"]

Assumed = MutableMapping[tuple[str, str], dict[str, PlainValue]]
"""Values that parts got without reporting them, by device and part."""


@dataclass(frozen=True, slots=True)
class HouseNow:
    """The house at a moment.

    Attributes:
        robots: The room of each robot of the goal, by the name in the goal.
        problems: Why a robot cannot be sent, by that name.
    """

    devices: Sequence[Device]
    doors: Sequence[DoorInfo]
    robots: Mapping[str, str]
    problems: Mapping[str, str]

    def called(self, named: str) -> Device | None:
        """Return the device with that id or name; None if there is none."""
        for one in self.devices if named else ():
            if one.id == named:
                return one
        wanted = fold(named)
        fitting = (one for one in self.devices if wanted in map(fold, (one.name, *one.names)))
        return min(fitting, key=lambda one: one.id, default=None) if named else None


class HouseReader:
    """Reads the house.

    Attributes:
        node: The node that reads it.
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        self._lookup = DeviceLookup(node)
        self._places = node.create_client(GetPlaces, GET_PLACES)
        self._where = node.create_client(WhereIsRobot, WHERE_IS_ROBOT)

    async def places(self) -> GetPlacesResponse:
        """Return the rooms and doors."""
        return await self._places.call(GetPlaces.Request())

    async def read(self, robots: Iterable[tuple[str, str]], assumed: Assumed) -> HouseNow:
        """Return the house with *robots*, each with the room that it is to reach.

        Raises:
            UsageError: There is no such robot, or its room is unknown.
            ServiceError: The directory does not answer.
        """
        devices = [_assuming(one, assumed) for one in await self._lookup.devices()]
        at, problems = dict[str, str](), dict[str, str]()
        for robot, room in robots:
            at[robot] = await self._room_of(robot)
            if fold(at[robot]) != fold(room):
                try:
                    await check_drive(self.node, SendRobot("", robot, room))
                except UsageError as exc:
                    problems[robot] = str(exc)
        doors = (await self.places()).doors if at else ()
        return HouseNow(devices, doors, at, problems)

    async def _room_of(self, robot: str) -> str:
        try:
            found = await self._where.call(WhereIsRobotRequest(robot=robot))
        except ServiceUnavailableError:
            raise UsageError(
                f"there is no robot {robot!r}: none has said where it is, for example on /NAME/pose"
            ) from None
        if not found.success or not found.pose[0].room:
            raise UsageError(found.message or f"the room of {robot} is unknown")
        return found.pose[0].room


def with_values(device: Device, part: str, values: Mapping[str, PlainValue]) -> Device:
    """Return *device* with other values of one part."""
    kept = tuple(one for one in device.states if one.part != part or one.capability not in values)
    at = device.last_seen
    new = tuple(
        State(part=part, capability=name, value=Value.of(value), since=at, told_at=at, live=True)
        for name, value in values.items()
    )
    return device.model_copy(update={"states": (*kept, *new)})


def _assuming(device: Device, assumed: Assumed) -> Device:
    known = {(one.part, one.capability) for one in device.states}
    for part in device.parts:
        values = assumed.get((device.id, part.id), {})
        if unknown := {name: value for name, value in values.items() if (part.id, name) not in known}:
            device = with_values(device, part.id, unknown)
    return device
