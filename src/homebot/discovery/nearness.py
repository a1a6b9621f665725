"""Devices near a robot: by the ways of the floor plan, the places of devices, poses and doors, as they are now.

Loaded with the first query that asks for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from typing import Final, final

from homebot.devices import Device
from homebot.devices.device import State
from homebot.devices.names import ROBOT_POSES, ROBOTS_NODE
from homebot.devices.query import IsNear, NameIs, Query, query_terms
from homebot.devices.robot_messages import RobotPose
from homebot.discovery.description import position_of
from homebot.discovery.index import DeviceIndex
from homebot.discovery.past_outcomes import PastOutcomes
from homebot.discovery.search.near_rank import CostTerm, Doors, DoorState, NearDevice, ago_text, cost_text, nearest
from homebot.discovery.search.rank import best_score, scorer_of, shortcomings
from homebot.errors import RefusedError, UsageError
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.places import HouseDoor, HousePlan, Position
from homebot.places.floor_plan import FloorPlan
from homebot.places.path import PathFinder, Spot
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["NearAnswer", "Nearness"]

_POSES_QOS: Final = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_ANY_ROBOT: Final = "robot"
_WALL: Final = math.inf

_MOST_LEFT_OUT: Final = 20
"""Devices named that fit, but are not results."""


@dataclass(frozen=True, slots=True)
class NearAnswer:
    """The devices near a robot.

    Attributes:
        found: The best of them, best first.
        total: How many there are.
        left_out: Of some that fit otherwise and may not be commanded, or not be reached, the id and the reason.
        pose: The pose of the robot.
        room: Its room.
        age: Seconds since that was received.
        doors: The state of each door.
    """

    found: list[NearDevice]
    total: int
    left_out: list[tuple[str, str]]
    pose: RobotPose
    room: str
    age: float
    doors: Doors

    @property
    def text(self) -> str:
        """The place of the robot and the age of its pose."""
        pose = self.pose
        at = f" at {pose.x:.1f}, {pose.y:.1f} ±{pose.error:.1f} m" if pose.has_position else ""
        beside = " beside" if pose.is_nearest_room else " in"
        return f"{pose.robot} was{beside} {self.room}{at} {ago_text(self.age)} ({pose.source})"

    def why(self, device: NearDevice, places: Nearness) -> str:
        """Return the cost of a device, with its terms."""
        return cost_text(device, self.doors, is_exact=self.pose.has_position and places.is_exact(device.device))


@final
class Nearness:
    """Finds the devices near a robot.

    Args:
        node: The node of the directory.
        index: The index; all its changes were taken when it is asked.
    """

    def __init__(self, node: Node, index: DeviceIndex) -> None:
        self._clock = node.graph.clock
        self._index = index
        self._outcomes = PastOutcomes(node)
        self._poses: dict[str, RobotPose] = {}
        self._source = node.create_subscription(RobotPose, ROBOT_POSES, qos_profile=_POSES_QOS, from_node=ROBOTS_NODE)
        self._add_poses(iter(self._source.take, None))
        node.create_task(partial(self._source.run_batches, self._add_poses))
        self._plan: HousePlan | None = None
        self._floor_plan = FloorPlan.of(index.owner.plan)
        self._finder = PathFinder({}, ())
        self._doors: dict[str, HouseDoor] = {}
        self._lockable: list[str] = []
        self._static_doors: dict[str, DoorState] = {}
        self._errors: dict[str, CostTerm] = {}
        self._rooms_alone: set[str] = set()
        self._sequence = 0

    def find(self, near: IsNear, rest: Query, found: AbstractSet[str], limit: int = 0) -> NearAnswer:
        """Return the devices near a robot.

        Args:
            near: The robot and the distance.
            rest: The query without it.
            found: The ids of the devices that fit *rest*.
            limit: How many; 0 for all.

        Raises:
            UsageError: There is no such robot, but others.
            RefusedError: Where the robot is, is not known now.
        """
        self._add_poses(iter(self._source.take, None))
        pose = self._pose(near.robot)
        age = max(0.0, self._clock.now() - pose.received_at.to_seconds())
        _check(pose, age)
        self._update_places()
        start = self._start(pose)
        states = _DoorStates(self._static_doors, self._door)
        locked = frozenset(name for name in self._lockable if math.isinf(states[name].metres))
        forbidden = self._forbidden(rest, found)
        wanted = found - {device_id for device_id, _ in forbidden} if forbidden else found
        score_of = scorer_of(rest, self._index.postings)
        best = best_score(rest, wanted, score_of)

        def terms(device_id: str) -> Iterator[CostTerm]:
            if (error := self._errors.get(device_id)) is not None:
                yield error
            if (score := score_of(device_id)) < best:
                yield CostTerm(best - score, shortcomings(self._index.postings.facets(device_id)))
            yield from self._outcomes.term(device_id)

        devices, reached = nearest(
            self._finder,
            start,
            states.__getitem__,
            wanted,
            lambda one: tuple(terms(one)),
            locked=locked,
            within=near.within,
            limit=limit,
        )
        left_out = list(islice(chain(forbidden, self._not_reached(wanted - reached, start, locked)), _MOST_LEFT_OUT))
        return NearAnswer(devices, len(reached), left_out, pose, start.room, age, states.__getitem__)

    def is_exact(self, device_id: str) -> bool:
        """Return whether more is known of the place of a device than its room."""
        return device_id not in self._rooms_alone

    def _add_poses(self, poses: Iterator[RobotPose]) -> None:
        for pose in poses:
            self._poses[fold(pose.robot)] = pose

    def _pose(self, robot: str) -> RobotPose:
        known = self._poses
        pose = known.get(fold(robot))
        if pose is None and fold(robot) == _ANY_ROBOT and len(known) == 1:
            pose = next(iter(known.values()))
        if pose is not None:
            return pose
        if not known:
            raise RefusedError(
                f"what is near {robot!r}",
                "no robot has said where it is; it publishes its pose, for example on /NAME/pose",
            )
        names = [one.robot for one in known.values()]
        hint = did_you_mean(robot, names, f"robots are {', '.join(sorted(names))}")
        raise UsageError(f"there is no robot {robot!r}; {hint}")

    def _start(self, pose: RobotPose) -> Spot:
        """Return the place of a robot on the plan."""
        plan = self._floor_plan
        place = None
        if pose.has_position:
            place = plan.place_of(Position(pose.x, pose.y, pose.floor, pose.error), pose.room)
        elif pose.room:
            place = self._place_in(pose.room)
        if place is None:
            raise RefusedError(f"what is near {pose.robot}", "it is in no room of the plan; see [places]")
        return place

    def _place_in(self, room: str) -> Spot:
        name = self._floor_plan.plan.locate(room)[0]
        centre = self._floor_plan.centre_of(name)
        return Spot(name, None if centre is None else (centre.x, centre.y))

    def _update_places(self) -> None:
        """Spot the devices that changed; all of them on a plan that did."""
        index, plan = self._index, self._index.owner.plan
        recent = index.changes.recent
        if plan is not self._plan or self._sequence < recent.forgotten:
            self._plan, self._floor_plan = plan, FloorPlan.of(plan)
            self._finder = self._floor_plan.path_finder()
            self._doors = {door.name: door for door in plan.doors}
            self._lockable = [door.name for door in plan.doors if door.lock]
            self._static_doors = {
                door.name: self._door(door.name) for door in plan.doors if not (door.lock or door.contact)
            }
            self._errors.clear()
            self._rooms_alone.clear()
            for device in index.devices():
                self._place(device)
        elif self._sequence != index.sequence:
            for change in recent.since(self._sequence):
                now = index.get(change.device.id)
                if now is None:
                    self._finder.discard(change.device.id)
                else:
                    self._place(now)
        self._sequence = index.sequence

    def _place(self, device: Device) -> None:
        """Spot *device* by its position, else in its room."""
        position = position_of(device.facts)
        plan = self._floor_plan
        room = device.area if device.area and fold(device.area) not in self._not_rooms() else ""
        place, error, reason = None, 0.0, ""
        if position is not None:
            place, error = plan.place_of(position, room), position.error
            reason = f"its position may be off ({position.source})"
        if (place is None or place.point is None) and room:
            self._rooms_alone.add(device.id)
            place = self._place_in(room)
            centre = plan.centre_of(place.room)
            error, reason = (0.0 if centre is None else centre.error), "only its room is known"
        else:
            self._rooms_alone.discard(device.id)
        if place is None:
            self._finder.discard(device.id)
        else:
            self._finder.put(device.id, place)
        if error:
            self._errors[device.id] = CostTerm(error, reason)
        else:
            self._errors.pop(device.id, None)

    def _not_rooms(self) -> frozenset[str]:
        plan = self._floor_plan.plan
        return frozenset(map(fold, (plan.home, *plan.floors)))

    def _door(self, name: str) -> DoorState:
        """Return the state of the door *name*: a lock outranks the contact, and one without a contact is open."""
        door = self._doors[name]
        lock = self._state(door.lock, "lock")
        if lock is not None and lock[0].value.plain() == "locked":
            return DoorState((CostTerm(_WALL, f"is locked {self._told(lock, 'lock')}"),))
        cost = self._floor_plan.cost_of(door)
        terms = [CostTerm(cost, "is a way of stairs" if door.cost is None else "counts more")] if cost else []
        contact = self._state(door.contact, "contact")
        if contact is None:
            return DoorState(tuple(terms), "" if cost and not door.contact else "assumed open")
        if contact[0].value.plain() is False:
            return DoorState(
                (*terms, CostTerm(self._index.owner.closed_door, f"is closed {self._told(contact, 'contact')}"))
            )
        is_stale = contact[1].freshness == "stale"
        return DoorState(tuple(terms), f"open {self._told(contact, 'contact')}" if is_stale else "")

    def _told(self, told: tuple[State, Device], by: str) -> str:
        state, device = told
        stale = ", stale" if device.freshness == "stale" else ""
        return f"({by}, {ago_text(self._clock.now() - state.told_at.to_seconds())}{stale})"

    def _state(self, named: str, capability: str) -> tuple[State, Device] | None:
        """Return the newest state of a capability of the device with the id or name *named*."""
        if not named:
            return None
        device = self._index.get(named)
        if device is None:
            found = self._index.find(NameIs(fold(named)))
            device = self._index.get(min(found)) if found else None
        if device is None:
            return None
        states = [state for state in device.states if state.capability == capability]
        return (max(states, key=lambda one: one.told_at.to_seconds()), device) if states else None

    def _forbidden(self, rest: Query, devices: Iterable[str]) -> list[tuple[str, str]]:
        """Return the devices that may not be commanded, unless *rest* asks for them."""
        waiting = self._index.postings.unapproved
        if not waiting or any(term.kind == "unapproved" for term in query_terms(rest)):
            return []
        return [(one, "it waits for the owner's approval") for one in devices if one in waiting]

    def _not_reached(self, devices: AbstractSet[str], start: Spot, locked: frozenset[str]) -> Iterator[tuple[str, str]]:
        """Yield the devices without a way, with the reason; not those that are merely too far away."""
        rooms = self._finder.reachable_rooms(start.room, locked)
        reason = f": {', '.join(sorted(locked))} is locked" if len(locked) == 1 else ""
        for one in devices:
            place = self._finder.place_of(one)
            if place is None:
                yield one, "its room is not known"
            elif place.room not in rooms:
                yield one, f"no way leads to {place.room}{reason}"


@final
class _DoorStates(dict[str, DoorState]):
    """The states of doors during one query, each looked up once; those without a contact and a lock never change."""

    def __init__(self, static: Mapping[str, DoorState], read: Callable[[str], DoorState]) -> None:
        super().__init__()
        self._static = static
        self._read = read

    def __missing__(self, name: str) -> DoorState:
        state = self[name] = self._static.get(name) or self._read(name)
        return state


def _check(pose: RobotPose, age: float) -> None:
    """Check that a pose counts.

    Raises:
        RefusedError: It does not; says how old it is.
    """
    problem = ""
    if not pose.counts:
        problem = f"{pose.robot}'s pose is {age:.0f} s old (limit {pose.limit:g} s)"
    elif not pose.is_sure:
        problem = f"{pose.robot} is not sure where it is; it was moved, or has lost its way"
    if problem:
        raise RefusedError("what is near it", problem)
