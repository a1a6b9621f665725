"""Doors for Open-RMF: their states, and requests of robots to hold them open."""

from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from typing import Any, Final, TypeAlias

import anyio
from anyio.abc import TaskGroup

from homebot.apps.base import App, AppSettings
from homebot.devices.handles import Closure, DoorLock
from homebot.devices.handles.sensors import ContactSensor
from homebot.devices.names import GET_PLACES
from homebot.devices.places_messages import GetPlaces, GetPlacesRequest
from homebot.devices.requesters import Requesters
from homebot.errors import RefusedError, ServiceError
from homebot.graph import GraphEntity, Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.interfaces import find_message
from homebot.messages.message import Message
from homebot.support.folding import fold
from homebot.support.names import did_you_mean
from homebot.units import Seconds

_Part: TypeAlias = Closure | DoorLock | ContactSensor

_EVERY: Final = 1.0
_CLOSED, _MOVING, _OPEN, _OFFLINE, _UNKNOWN = range(5)
_MODES: Final = {
    **dict.fromkeys(("closed", "locked"), _CLOSED),
    **dict.fromkeys(("opening", "closing", "unlocking", "locking"), _MOVING),
    **dict.fromkeys(("open", "unlocked"), _OPEN),
}
_TAGS: Final = {"door", "garage_door", "garage", "gate"}
_MAX_HOLDERS: Final = 100


class RmfDoorsSettings(AppSettings):
    """The keys of the table of :class:`RmfDoors`.

    Attributes:
        held_for: Seconds after which a request that is not repeated no longer holds a door open, although its requester
            is connected.
        supervised: True if a door supervisor of Open-RMF runs: it hears robots, and its ``/door_requests`` are served.
    """

    held_for: Seconds = 3600.0
    supervised: bool = False


@dataclass(eq=False, slots=True)
class _DoorHold:
    """The hold of one requester on one door.

    Attributes:
        since: The time of its first request.
        sender: The publisher of its last request.
    """

    since: Time
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    sender: GraphEntity | None = None


class RmfDoors(App[RmfDoorsSettings]):
    """Publishes ``/door_states`` and serves requests of robots, for doors in the plan and other doors.

    Without a door supervisor it is one: it serves ``/adapter_door_requests``, and lists the holds in
    ``/door_supervisor_heartbeat``.

    A door in the plan is represented by its lock or motor, else by its contact. Locks, motors and contacts that are in
    no plan are doors under their own names. ``MODE_OPEN`` holds a lock unlocked or a motor open for the requester;
    ``MODE_CLOSED``, or the end of the connection of the requester, or of the robot of that name, releases its hold, and
    locks or closes the door after the last one.
    """

    def __init__(self, node: Node, settings: RmfDoorsSettings) -> None:
        super().__init__(node, settings)
        self._held_for = settings.held_for
        self._places = node.create_client(GetPlaces, GET_PLACES)
        self._requesters = Requesters(node)
        self._doors: dict[str, _Part | None] = {}
        self._holds: dict[tuple[str, str], _DoorHold] = {}
        self._state_type: Any = find_message("rmf_door_msgs/msg/DoorState")
        self._mode_type: Any = find_message("rmf_door_msgs/msg/DoorMode")
        self._states = node.create_publisher(self._state_type, "/door_states", 100)
        self._tasks: TaskGroup | None = None
        requests = "/door_requests" if settings.supervised else "/adapter_door_requests"
        self._requests = node.create_subscription(
            find_message("rmf_door_msgs/msg/DoorRequest"), requests, self._request, names_sender=True
        )
        self._beat_type: Any = find_message("rmf_door_msgs/msg/SupervisorHeartbeat")
        self._beats = (
            None if settings.supervised else node.create_publisher(self._beat_type, "/door_supervisor_heartbeat")
        )

    async def run(self) -> None:
        """Publish the states of all doors once a second."""
        async with anyio.create_task_group() as self._tasks:
            while True:
                try:
                    self._doors = await self._find_doors()
                except ServiceError as exc:
                    self._warn(str(exc))
                for (door, requester), hold in tuple(self._holds.items()):
                    if not hold.scope.cancel_called and await self._requesters.is_gone(requester, hold.sender):
                        self._warn(f"the hold of {requester} on {door} ends: its connection has ended")
                        hold.scope.cancel()
                time = Time.from_seconds(self.node.graph.clock.now())
                for name, part in self._doors.items():
                    mode = self._mode_type(value=_mode(part))
                    self._states.publish(self._state_type(door_time=time, door_name=name, current_mode=mode))
                if self._beats is not None:
                    self._beats.publish(self._beat_type(all_sessions=self._sessions()))
                await anyio.sleep(_EVERY)

    def _sessions(self) -> tuple[Message, ...]:
        sessions: Any = find_message("rmf_door_msgs/msg/DoorSessions")
        session: Any = find_message("rmf_door_msgs/msg/Session")
        return tuple(
            sessions(
                door_name=door,
                sessions=tuple(session(request_time=self._holds[key].since, requester_id=key[1]) for key in keys),
            )
            for door, keys in groupby(sorted(self._holds), lambda key: key[0])
        )

    async def _find_doors(self) -> dict[str, _Part | None]:
        """Return each door with its lock or motor, else its contact; None if that is not known yet."""
        find, plan = self.devices.find, await self._places.call(GetPlacesRequest(), timeout=5.0)
        planned = {fold(device): door.name for door in plan.doors for device in (door.contact, door.lock) if device}
        doors: dict[str, _Part | None] = dict.fromkeys(planned.values())
        parts: list[_Part] = [
            part for kind in (ContactSensor, Closure, DoorLock) for part in await find(kind, optional=True)
        ]
        for part in parts:
            names = map(fold, (part.id, part.name, part.device.id, part.device.name))
            name = next((planned[name] for name in names if name in planned), "")
            if not name and _is_door(part):
                same = doors.get(part.device.name)
                name = part.device.name if same is None or same.device.id == part.device.id else part.id
            if name:
                doors[name] = part
        return doors

    def _request(self, request: Message) -> None:
        stated: Any = request
        name = next((door for door in self._doors if fold(door) == fold(stated.door_name)), "")
        part, key = self._doors.get(name), (name, stated.requester_id.strip()[:100])
        hold, mode = self._holds.get(key), stated.requested_mode.value
        if not key[1] or self._tasks is None or not isinstance(part, Closure | DoorLock):
            all_doors = did_you_mean(stated.door_name[:100], self._doors, "/door_states lists all doors")
            hint = "its device is only a contact, or is not known yet" if name else all_doors
            problem = f"{stated.door_name[:100]!r} is not a door with a lock or motor; {hint}"
            self._warn(f"a request for a door was refused: {problem if key[1] else 'no requester is stated'}")
            return
        if mode not in {_CLOSED, _OPEN}:
            self._warn(f"a request of {key[1]} for {name} was refused: its mode is {mode}, not 0 (closed) or 2 (open)")
        elif mode == _CLOSED:
            if hold is not None:
                hold.scope.cancel()
        elif hold is None and len(self._holds) >= _MAX_HOLDERS:
            self._warn(f"a request of {key[1]} for {name} was refused: {_MAX_HOLDERS} others hold doors")
        else:
            if hold is None:
                hold = self._holds[key] = _DoorHold(stated.request_time)
                self._tasks.start_soon(partial(self._hold, key, part, hold.scope))
            hold.scope.deadline, hold.sender = anyio.current_time() + self._held_for, self._requests.sender

    async def _hold(self, key: tuple[str, str], part: Closure | DoorLock, scope: anyio.CancelScope) -> None:
        """Hold a door open until *scope* ends; close it after the last holder."""
        try:
            with scope:
                async with part.hold("unlock" if isinstance(part, DoorLock) else "open", by=key[1]) as hold:
                    if not hold.succeeded:
                        self._warn(f"{key[0]} is not open for {key[1]}: {hold.outcome.text}")
                    await anyio.sleep_forever()
            del self._holds[key]
            if not any(door == key[0] for door, _ in self._holds):
                await (part.lock() if isinstance(part, DoorLock) else part.close())
        except RefusedError as exc:
            self._holds.pop(key, None)
            self._warn(f"{key[0]} is not moved for {key[1]}: {exc}")

    def _warn(self, message: str) -> None:
        self.node.log.warning("rmf_doors.refused", message=message)


def _is_door(part: _Part) -> bool:
    device_part = part.device.part(part.part_id)
    return isinstance(part, DoorLock) or (device_part is not None and device_part.part.tag in _TAGS)


def _mode(part: _Part | None) -> int:
    if part is None or part.reachable is False:
        return _OFFLINE
    if isinstance(part, ContactSensor):
        return _UNKNOWN if part.is_open is None else _OPEN if part.is_open else _CLOSED
    return _MODES.get((part.state if isinstance(part, DoorLock) else part.movement) or "", _UNKNOWN)
