"""Devices near a robot: by paths on the floor plan and the current places of devices, poses and doors.

Loaded with the first such query.
"""

import math
from collections.abc import Callable, Generator, Iterator
from itertools import starmap
from operator import is_not
from typing import Final, NamedTuple, final

from homebot.clock import TimeSlice
from homebot.devices.device import Device
from homebot.devices.device_names import name_query
from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import IsNear, IsUnapproved, Query
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest
from homebot.devices.services import QueryDevicesResponse
from homebot.devices.value import PlainValue
from homebot.devices.wording.time_format import age_text, ago
from homebot.discovery.description import position_of
from homebot.discovery.index import DeviceIndex
from homebot.discovery.past_outcomes import PastOutcomes
from homebot.discovery.search.near_rank import CostTerm, DoorState, NearDevice, cost_text, nearest
from homebot.discovery.search.rank import least_shortcoming, shortcomings
from homebot.discovery.search.unknown_words import area_problem
from homebot.errors import RefusedError, ServiceUnavailableError, UsageError
from homebot.graph import Node
from homebot.messages.key_value import KeyValue
from homebot.places import HouseDoor, HousePlan, Position
from homebot.places.floor_plan import FloorPlan
from homebot.places.path import PathFinder, Spot
from homebot.support.folding import fold

_MAX_LEFT_OUT: Final = 20
"""Most matching devices that are named though they are not results."""


class NearDevices(NamedTuple):
    """The devices near a robot.

    Attributes:
        devices: The devices, best first.
        why: Returns the cost of a device, with its terms.
        answer: The answer in words, without the devices.
    """

    devices: list[NearDevice]
    why: Callable[[NearDevice], str]
    answer: QueryDevicesResponse


@final
class Nearness:
    """Finds the devices near a robot.

    Args:
        index: The index, whose changes must have been popped before a query.
    """

    def __init__(self, node: Node, index: DeviceIndex) -> None:
        self._clock = node.graph.clock
        self._index = index
        self._outcomes = PastOutcomes(node)
        self._where = node.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        self._plan: HousePlan | None = None
        self._floor_plan = FloorPlan.of(index.owner.plan)
        self._finder = PathFinder({})
        self._doors: dict[str, HouseDoor] = {}
        self._tolls: dict[str, tuple[float, tuple[Device | None, ...]]] = {}
        self._named: dict[str, str] = {}
        self._errors: dict[str, CostTerm] = {}
        self._rooms_alone: set[str] = set()
        self._nowhere: set[str] = set()
        self._moved: dict[str, None] = {}
        self._sequence = -1

    async def find(self, near: IsNear, rest: Query, limit: int = 0) -> NearDevices:
        """Return the devices near a robot.

        Args:
            limit: Most devices; 0 for all.

        Raises:
            UsageError: There is no such robot.
            RefusedError: The robot's position is not known now.
            ServiceError: The node that tracks it does not answer.
        """
        try:
            answer = await self._where.call(WhereIsRobotRequest(robot=near.robot))
        except ServiceUnavailableError:
            remedy = "no robot has said where it is; it publishes its pose, for example on /NAME/pose"
            raise RefusedError(f"what is near {near.robot}", remedy) from None
        if answer.is_mistake:
            raise UsageError(answer.message)
        if not answer.success or answer.message:
            raise RefusedError(f"what is near {near.robot}", answer.message)
        pose, age = answer.pose[0], answer.age
        await TimeSlice(self._clock).do(self._prepare())
        return self._answer(near, rest, limit, pose, age)

    def _answer(self, near: IsNear, rest: Query, limit: int, pose: RobotPose, age: float) -> NearDevices:
        start = self._in_room(pose.room) if pose.room else None
        if pose.has_position:
            start = self._floor_plan.place_of(Position(pose.x, pose.y, pose.floor, pose.error), pose.room)
        elif problem := area_problem(fold(pose.room), self._index.postings, self._floor_plan.plan):
            raise RefusedError(f"what is near {pose.robot}", problem)
        if start is None:
            has_no_floor = not pose.floor and len(self._floor_plan.plan.floors) > 1
            problem = f"the house has several floors; state its floor in [robots.{pose.robot}]"
            reason = problem if has_no_floor else "it is in no room of the plan; see [places]"
            raise RefusedError(f"what is near {pose.robot}", reason)
        index = self._index
        wanted = index.find(rest)
        asks_for_them = any(term.kind == "unapproved" for term in query_terms(rest))
        forbidden = frozenset[str]() if asks_for_them else wanted & index.find(IsUnapproved())
        wanted = wanted - forbidden if forbidden else wanted
        locked = frozenset(
            door.name for door in self._doors.values() if door.lock and math.isinf(self._toll(door.name))
        )

        def terms(device_id: str) -> tuple[CostTerm, ...]:
            error = self._errors.get(device_id)
            worse = shortcomings(rest, index.postings.facets(device_id))
            return (*([] if error is None else [error]), *starmap(CostTerm, worse), *self._outcomes.term(device_id))

        def why(device: NearDevice) -> str:
            return cost_text(device, self._door, is_exact=pose.has_position and device.device not in self._rooms_alone)

        unreachable = sorted(wanted & (self._nowhere | self._finder.unreachable(start.room, locked)))
        best, total = nearest(
            self._finder,
            start,
            self._toll,
            wanted,
            terms,
            total=len(wanted) - len(unreachable),
            within=near.within,
            least=least_shortcoming(wanted, index.postings),
            limit=limit,
        )
        left_out = [(device_id, "it waits for the owner's approval") for device_id in sorted(forbidden)]
        left_out += self._no_ways(unreachable[:_MAX_LEFT_OUT], start.room, locked)
        answer = QueryDevicesResponse(
            success=True,
            message=_text(pose, start.room, age),
            total=total,
            pose_age=age,
            left_out=tuple(KeyValue(key=key, value=reason) for key, reason in left_out[:_MAX_LEFT_OUT]),
        )
        return NearDevices(best, why, answer)

    def _in_room(self, room: str) -> Spot:
        name, _ = self._floor_plan.plan.locate(room)
        centre = self._floor_plan.centre_of(name)
        return Spot(name, None if centre is None else (centre.x, centre.y))

    def _prepare(self) -> Generator[None, None, None]:
        """Locate new and changed devices; on a changed plan all devices and doors. In small steps."""
        while (plan := self._index.owner.plan) is not self._plan:
            floor_plan = FloorPlan.of(plan)
            finder = yield from floor_plan.path_finder()
            self._plan, self._floor_plan, self._finder = plan, floor_plan, finder
            self._doors = {door.name: door for door in plan.doors}
            self._tolls.clear()
            self._sequence = -1
            for name in tuple(self._doors):
                self._toll(name)
                yield
        while self._spot_next():
            yield

    def _spot_next(self) -> bool:
        """Locate one new or changed device; return False if there is none."""
        index, recent = self._index, self._index.changes.recent
        if self._sequence < recent.forgotten:
            self._moved = dict.fromkeys(index.ids)
        elif self._sequence != index.sequence:
            self._moved |= dict.fromkeys(change.device.id for change in recent.since(self._sequence))
        if self._sequence != index.sequence:
            self._named.clear()
        self._sequence = index.sequence
        if self._moved:
            self._spot(self._moved.popitem()[0])
        return bool(self._moved)

    def _spot(self, device_id: str) -> None:
        """Locate a device by its position or else its room; remove it if it is gone."""
        device, plan = self._index.get(device_id), self._floor_plan
        self._finder.discard(device_id)
        self._errors.pop(device_id, None)
        self._rooms_alone.discard(device_id)
        self._nowhere.discard(device_id)
        if device is None:
            return
        position = position_of(device.facts)
        room = self._room_of(device)
        place = None if position is None else plan.place_of(position, room)
        if room and (place is None or place.point is None):
            place = self._in_room(room)
            position, reason = plan.centre_of(place.room), "only its room is known"
            self._rooms_alone.add(device_id)
        else:
            reason = "" if position is None else f"its position may be off ({position.source})"
        if place is None:
            self._nowhere.add(device_id)
        else:
            self._finder.put(device_id, place)
        if position is not None and position.error:
            self._errors[device_id] = CostTerm(position.error, reason)

    def _room_of(self, device: Device) -> str:
        """Return its room; empty if only its floor or the home is known."""
        plan = self._floor_plan.plan
        return "" if fold(device.area) in map(fold, (plan.home, *plan.floors)) else device.area

    def _toll(self, name: str) -> float:
        """Return the cost of a door in metres, computed again if its lock or contact has changed."""
        known, door = self._tolls.get(name), self._doors[name]
        if known is not None and not known[1]:
            return known[0]
        now = tuple([self._device(device_id) for device_id in (door.lock, door.contact) if device_id])
        if known is None or any(map(is_not, known[1], now)):
            known = self._tolls[name] = self._door(name).metres, now
        return known[0]

    def _door(self, name: str) -> DoorState:
        """Return the state of a door: its lock outranks its contact, and without a contact it counts as open."""
        door = self._doors[name]
        lock, contact = self._state(door.lock, "lock"), self._state(door.contact, "contact")
        if lock is not None and lock[0] == "locked":
            return DoorState((CostTerm(math.inf, f"is locked {lock[1]}"),))
        cost = self._floor_plan.cost_of(door)
        terms = [CostTerm(cost, "is a way of stairs" if door.cost is None else "counts more")] if cost else []
        if contact is None:
            return DoorState(tuple(terms), "" if cost and not door.contact else "assumed open")
        is_open, how = contact
        if is_open is False:
            return DoorState((*terms, CostTerm(self._index.owner.closed_door, f"is closed {how}")))
        return DoorState(tuple(terms), f"open {how}" if "stale" in how else "")

    def _state(self, named: str, capability: str) -> tuple[PlainValue, str] | None:
        """Return the newest value of a capability of the device with the id or name *named*, and its age."""
        device = self._device(named) if named else None
        states = [] if device is None else [state for state in device.states if state.capability == capability]
        if device is None or not states:
            return None
        newest = max(states, key=lambda state: state.told_at.to_seconds())
        stale = ", stale" if device.freshness == "stale" else ""
        return (
            newest.value.plain(),
            f"({capability}, {ago(newest.told_at, self._clock.now())}{stale})",
        )

    def _device(self, named: str) -> Device | None:
        """Return the device with the id or name *named*."""
        if (device_id := self._named.get(named)) is None:
            called = self._index.find(name_query(named))
            device_id = self._named[named] = named if named in called else min(called, default="")
        return self._index.get(device_id)

    def _no_ways(self, devices: list[str], room: str, locked: frozenset[str]) -> Iterator[tuple[str, str]]:
        """Yield each of *devices* with the reason why no path leads from *room* to it."""
        apart = self._finder.unreachable(room) if devices and locked else set()  # even with all doors unlocked
        for device_id in devices:
            place = self._finder.place_of(device_id)
            reason = f": {', '.join(locked)} is locked" if len(locked) == 1 and device_id not in apart else ""
            yield device_id, "its room is not known" if place is None else f"no way leads to {place.room}{reason}"


def _text(pose: RobotPose, room: str, age: float) -> str:
    """Return the place of a robot and the age of its pose."""
    at = f" at {pose.x:.1f}, {pose.y:.1f} ±{pose.error:.1f} m" if pose.has_position else ""
    beside = "beside" if pose.is_nearest_room else "in"
    return f"{pose.robot} was {beside} {room}{at} {age_text(age)} ago ({pose.source})"
