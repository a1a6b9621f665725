"""A robot vacuum with Valetudo: its map, with rooms as segments, and its position on it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import anyio
from anyio import to_thread

from homebot.conventions.valetudo import VacuumMap, VacuumSegment, read_map
from homebot.devices.gateway_messages import RawMessage
from homebot.errors import UsageError, WireError
from homebot.graph import Node
from homebot.places.outline import simplified
from homebot.places.plan import HouseRoom
from homebot.robots.evidence import MapPose, PoseEvidence
from homebot.robots.gateway_topics import GatewayTopics
from homebot.robots.settings import RobotSettings

if TYPE_CHECKING:
    from homebot.robots.tracker import RobotTracker

__all__ = ["Vacuum"]

MAP_REFUSED = "robots.map_refused"
MAP_CHANGED = "robots.map_changed"

_MAP_TOPICS: Final = ("MapData/map-data", "MapData/map-data-hass")
_STATE: Final = "$state"
_STATUS: Final = "StatusStateAttribute/status"

_ACTIVE: Final = frozenset({"cleaning", "manual_control", "moving", "returning"})
_ACTIVE_LIMIT: Final = 12.0
"""Seconds: three maps, of which an active robot sends one in 2 s, or in 4 s from a small computer."""

_LARGE: Final = 145.0
"""Square metres above which maps come half as often."""

_IDLE_LIMIT: Final = 200.0
_ERROR: Final = 0.25


class Vacuum:
    """Reads the topics of one vacuum into a tracker.

    Args:
        tracker: The tracker.
        node: Its node.
        robot: The name of the robot.
        settings: The robot's table.
        on_rooms: Takes the rooms of each new map.
    """

    def __init__(
        self,
        tracker: RobotTracker,
        node: Node,
        robot: str,
        settings: RobotSettings,
        on_rooms: Callable[[str, list[HouseRoom]], None],
    ) -> None:
        self._tracker = tracker
        self._node = node
        self._clock = node.graph.clock
        self._robot = robot
        self._settings = settings
        self._on_rooms = on_rooms
        self._source = f"{settings.vacuum}/MapData"
        self._map_topic = ""
        self._map: VacuumMap | None = None
        self._received_at = 0.0
        self._state = self._status = ""
        self._waiting: bytes | None = None
        self._arrived = anyio.Event()

    def read(self, topics: GatewayTopics) -> None:
        """Read its topics."""
        gateway, base = self._settings.gateway, self._settings.vacuum
        for name in _MAP_TOPICS:
            topics.read(gateway, f"{base}/{name}", self._on_map)
        topics.read(gateway, f"{base}/{_STATE}", self._on_state)
        topics.read(gateway, f"{base}/{_STATUS}", self._on_status)

    async def run(self) -> None:
        """Decode maps in a thread, the newest only, until cancelled."""
        while True:
            await self._arrived.wait()
            self._arrived = anyio.Event()
            payload, self._waiting = self._waiting, None
            if payload is None:
                continue
            try:
                found, rooms = await to_thread.run_sync(self._decoded, payload, self._map)
            except (UsageError, WireError) as exc:
                self._node.log.warning(MAP_REFUSED, message=f"a map of {self._robot} is not read: {exc}")
                continue
            self._warn_of_new_map(found)
            self._map, self._received_at = found, self._clock.monotonic()
            if rooms is not None:
                self._on_rooms(self._robot, rooms)
            self._update()

    def _on_map(self, message: RawMessage) -> None:
        """Take a map; of the two topics that have one the first that is heard."""
        self._map_topic = self._map_topic or message.address
        if message.address == self._map_topic:
            self._waiting = message.payload
            self._arrived.set()

    def _on_state(self, message: RawMessage) -> None:
        self._state = message.text()[:40]
        self._update()

    def _on_status(self, message: RawMessage) -> None:
        self._status = message.text()[:40]
        self._tracker.add_life(self._robot)

    def _update(self) -> None:
        """State where the robot is by the last map, as long as the vacuum is there."""
        if self._map is None or self._map.robot is None or self._state != "ready":
            self._tracker.drop(self._robot, self._source)
            return
        at = self._map.robot
        limit = _IDLE_LIMIT
        if self._status in _ACTIVE:
            limit = _ACTIVE_LIMIT * (2 if self._map.area > _LARGE else 1)
        found = self._map.segment_at(at.x, at.y)
        position = self._in_house(at.x, at.y, at.yaw or 0.0)
        floor = self._tracker.floor_of(self._robot)
        evidence = PoseEvidence(self._source, self._received_at, limit, _ERROR, position, floor=floor)
        if found is not None:
            room = self._room_of(found.segment)
            error = _ERROR if position is not None else self._tracker.rooms.error_in(room)
            evidence = evidence._replace(room=room, is_nearest_room=found.distance > 0, error=error)
        elif position is None:
            return
        self._tracker.add(self._robot, evidence)

    def _room_of(self, segment: VacuumSegment) -> str:
        return self._settings.segments.get(segment.id) or segment.name or f"{self._robot} room {segment.id}"

    def _in_house(self, x: float, y: float, yaw: float) -> MapPose | None:
        """Return a pose on its map in the house's frame ``map``, if the owner stated how these lie."""
        if self._settings.map_transform is None:
            return None
        left, up, turn = self._settings.map_transform
        cosine, sine = math.cos(turn), math.sin(turn)
        return MapPose(left + cosine * x - sine * y, up + sine * x + cosine * y, math.remainder(yaw + turn, math.tau))

    def _decoded(self, payload: bytes, before: VacuumMap | None) -> tuple[VacuumMap, list[HouseRoom] | None]:
        """Return the map in *payload*, and its rooms if they are not those of the map *before*; in a thread."""
        found = read_map(payload)
        if self._settings.map_transform is None or (before is not None and before.segments == found.segments):
            return found, None
        floor = self._settings.floor
        rooms = []
        for segment in found.segments:
            corners = [self._in_house(x, y, 0.0) for x, y in found.outline(segment)]
            ring = simplified([(one.x, one.y) for one in corners if one is not None])
            if ring:
                rooms.append(HouseRoom(self._room_of(segment), floor, polygons=((ring,),)))
        return found, rooms

    def _warn_of_new_map(self, found: VacuumMap) -> None:
        before = self._map
        if before is not None and before.vendor_id != found.vendor_id:
            text = f"{self._robot} uses another map now; check map_transform and segments in [robots.{self._robot}]"
            self._node.log.warning(MAP_CHANGED, message=text, robot=self._robot)
