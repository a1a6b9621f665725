"""A robot vacuum: its map, with rooms as segments, and its position on it."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

import anyio
from anyio import to_thread

from homebot.conventions.vacuum_map import VacuumMap, VacuumSegment, map_readers
from homebot.devices.devices import Devices
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.names import CHANGE_ROOM, IMPORT_PLACES
from homebot.devices.places_messages import ChangeRoom, ChangeRoomRequest, ImportPlaces, ImportPlacesRequest
from homebot.errors import ConfigError, PluginError, ServiceError, WireError
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.places import places_text
from homebot.places.floor_plan import FloorPlan
from homebot.places.outline import simplified
from homebot.places.plan import HousePlan, HouseRoom
from homebot.places.polygon import Polygon
from homebot.places.rigid import MapPose, fitted_pose
from homebot.robots.robot import TrackedRobot
from homebot.robots.sensors import listen
from homebot.support.folding import fold

MAP_REFUSED = "robots.map_refused"
MAP_CHANGED = "robots.map_changed"
NO_ROOMS = "robots.no_rooms"

_ACTIVE: Final = frozenset({"cleaning", "manual_control", "moving", "returning"})
_ACTIVE_LIMIT: Final = 24.0
_IDLE_LIMIT: Final = 200.0
"""Seconds for three maps: a docked robot sends one a minute, an active one every 2 s, or 8 s in a large home."""

_ERROR: Final = 0.25

_SAME: Final = 0.1
"""Metres by which corners may differ and still belong to the same area."""


class Vacuum:
    """Reads the topics of one vacuum."""

    def __init__(self, node: Node, devices: Devices, robot: TrackedRobot, house: Callable[[], HousePlan]) -> None:
        self._node, self._devices, self._robot, self._house = node, devices, robot, house
        readers = map_readers()
        if not readers:
            raise PluginError(
                robot.settings.vacuum, "needs an integration that reads the maps of vacuums; none is installed"
            )
        self._reader = readers[0]
        self._source = f"{robot.settings.vacuum}/{self._reader.map_topic.partition('/')[0]}"
        self._rooms = _ImportedRooms(node, house, robot.name)
        self._map: VacuumMap | None = None
        self._first_id: str | None = None
        self._shapes: Mapping[str, Polygon] = {}
        self._joined: tuple[tuple[str, str], ...] = ()
        self._lies_at: MapPose | None = None
        self._received_at = 0.0
        self._state = self._status = ""
        self._waiting = b""
        self._arrived = anyio.Event()
        self._log = LogLimit(node.graph.clock)

    async def run(self) -> None:
        """Read maps until cancelled, only the newest; they are decoded in a thread."""
        base = self._robot.settings.vacuum
        for name, handle in (
            (self._reader.state_topic, self._on_state),
            (self._reader.status_topic, self._on_status),
            (self._reader.map_topic, self._on_map),
        ):
            await listen(self._node, self._devices, self._robot.settings.gateway, f"{base}/{name}", handle)
        while True:
            await self._arrived.wait()
            self._arrived = anyio.Event()
            try:
                new_map = await to_thread.run_sync(self._reader.read, self._waiting)
                if self._map is None or self._map.segments != new_map.segments:
                    self._shapes, self._joined = await to_thread.run_sync(_rooms_of, new_map)
            except WireError as exc:
                if self._log.allows(MAP_REFUSED) is not None:
                    self._node.log.warning(MAP_REFUSED, message=f"a map of {self._robot.name} is not read: {exc}")
                continue
            self._first_id = new_map.vendor_id if self._first_id is None else self._first_id
            if self._map is not None and self._map.vendor_id != new_map.vendor_id:
                table = f"[robots.{self._robot.name}]"
                text = (
                    f"{self._robot.name} uses another map now; map_transform and segments of {table} do not apply to it"
                )
                self._node.log.warning(MAP_CHANGED, message=text, robot=self._robot.name)
            self._map, self._received_at = new_map, self._robot.now()
            self._lies_at = self._place_of_map(new_map)
            if self._lies_at is not None:
                await self._rooms.renew(self._house_rooms(new_map, self._lies_at))
            self._update()

    def _on_map(self, message: RawMessage) -> None:
        self._waiting = message.payload
        self._arrived.set()

    def _on_state(self, message: RawMessage) -> None:
        self._state = message.text()[:40]
        self._update()

    def _on_status(self, message: RawMessage) -> None:
        self._status = message.text()[:40]
        self._robot.add_life()

    def _place_of_map(self, vacuum_map: VacuumMap) -> MapPose | None:
        """Return the pose of the map in the house: as stated by the owner, or fitted to rooms of the same names."""
        stated, plan = self._robot.settings.map_transform, FloorPlan.of(self._house())
        if stated is not None and vacuum_map.vendor_id == self._first_id:
            return MapPose(*stated)
        pairs = []
        for segment in vacuum_map.segments:
            there = plan.centre_of(self._name_of(segment))
            if there is not None and segment.id in self._shapes:
                here = self._shapes[segment.id]
                pairs.append((complex(*here.nearest_inside(*here.centroid())), complex(there.x, there.y)))
        return fitted_pose(pairs)

    def _house_rooms(self, vacuum_map: VacuumMap, lies_at: MapPose) -> list[HouseRoom]:
        """Return the named rooms, in the frame ``map`` of the house, with doors where they touch."""
        rooms = []
        names = {segment.id: self._name_of(segment) for segment in vacuum_map.segments if segment.id in self._shapes}
        for segment in vacuum_map.segments:
            if name := names.get(segment.id):
                doors = (names.get(other) for pair in self._joined for other in pair if segment.id in pair)
                corners = (lies_at.then(MapPose(x, y)) for x, y in self._shapes[segment.id].rings[0])
                ring = tuple((round(corner.x, 3), round(corner.y, 3)) for corner in corners)
                to = tuple(other for other in doors if other and fold(other) != fold(name))
                rooms.append(HouseRoom(name, self._robot.settings.floor, to, ((ring,),)))
        return rooms

    def _name_of(self, segment: VacuumSegment) -> str:
        """Return the name of a segment; empty without one."""
        is_first = self._map is None or self._map.vendor_id == self._first_id
        return (self._robot.settings.segments.get(segment.id) if is_first else "") or segment.name

    def _update(self) -> None:
        """Update the robot's pose from the last map while the vacuum is reachable."""
        vacuum_map, robot = self._map, self._robot
        at = None if vacuum_map is None else vacuum_map.robot
        if vacuum_map is None or at is None or self._state != "ready":
            robot.drop(self._source)
            return
        position: MapPose | None = None
        place: dict[str, object] = {}
        if self._lies_at is not None:
            position, place["error"] = self._lies_at.then(at), _ERROR
        if (here := vacuum_map.segment_at(at.x, at.y)) is not None:
            room = self._name_of(here[0]) or f"{robot.name} room {here[0].id}"
            place.update(room=room, is_nearest_room=here[1] > 0)
        if not place:
            robot.drop(self._source)
            return
        limit = _ACTIVE_LIMIT if self._status in _ACTIVE else _IDLE_LIMIT
        robot.place(self._source, limit, position, age=robot.now() - self._received_at, by_robot=True, **place)


def _rooms_of(vacuum_map: VacuumMap) -> tuple[Mapping[str, Polygon], tuple[tuple[str, str], ...]]:
    """Return the areas of the segments of a map by their ids, and which of them a doorway joins."""
    outlines = ((segment.id, simplified(vacuum_map.outline(segment))) for segment in vacuum_map.segments)
    return {number: Polygon(ring) for number, ring in outlines if ring}, tuple(vacuum_map.joined())


class _ImportedRooms:
    """The rooms of one map in the house, including those of an earlier run. A room with another area keeps it."""

    def __init__(self, node: Node, house: Callable[[], HousePlan], robot: str) -> None:
        self._node, self._house, self._robot = node, house, robot
        self._import = node.create_client(ImportPlaces, IMPORT_PLACES)
        self._change = node.create_client(ChangeRoom, CHANGE_ROOM)
        self._before: dict[str, HouseRoom] | None = None

    async def renew(self, rooms: Iterable[HouseRoom]) -> None:
        """Import *rooms* in place of those of the previous map."""
        plan, wanted = self._house(), {fold(room.name): room for room in rooms}
        if wanted == self._before:
            return
        self._before = wanted
        try:
            for room in plan.rooms:
                if room.source == self._robot and fold(room.name) not in wanted:
                    self._report((await self._change.call(ChangeRoomRequest(room=room.name))).message)
            if new := [room for room in wanted.values() if self._may_replace(plan.room(room.name), room)]:
                request = ImportPlacesRequest(text=_text(plan.home, new), source=self._robot)
                self._report((await self._import.call(request)).message)
        except (ConfigError, ServiceError) as exc:
            self._report(str(exc))

    def _may_replace(self, known: HouseRoom | None, new: HouseRoom) -> bool:
        """Return whether *known*, a room of the house, has no area, or a different one from an earlier map."""
        if known is None or not known.polygons:
            return True
        has_doors = {*map(fold, new.doors)} <= {*map(fold, known.doors)}
        return known.source == self._robot and not (has_doors and _is_same(new, known))

    def _report(self, problem: str) -> None:
        if problem:
            self._node.log.warning(NO_ROOMS, message=f"the rooms of a map do not match the house: {problem}")


def _text(home: str, rooms: Sequence[HouseRoom]) -> str:
    """Return the text of *rooms*, and of the names of those to which their doors lead."""
    return places_text(HousePlan(home, (*rooms, *(HouseRoom(to) for room in rooms for to in room.doors))))


def _is_same(first: HouseRoom, second: HouseRoom) -> bool:
    corners, others = (
        [corner for rings in room.polygons for ring in rings for corner in ring] for room in (first, second)
    )
    return len(corners) == len(others) and all(math.dist(*pair) < _SAME for pair in zip(corners, others, strict=True))
