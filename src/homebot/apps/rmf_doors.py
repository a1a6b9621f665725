"""Doors as Open-RMF knows them: their states, and requests of robots to hold them open."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any, Final, TypeVar

import anyio
from anyio.abc import TaskGroup

from homebot.apps.base import App, AppSettings
from homebot.devices.handles import DoorLock, Handle
from homebot.devices.handles.sensors import ContactSensor
from homebot.devices.names import GET_PLACES
from homebot.devices.places_messages import DoorInfo, GetPlaces, GetPlacesRequest
from homebot.errors import RefusedError, ServiceError
from homebot.graph import Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.interfaces import find_message
from homebot.messages.message import Message
from homebot.support.folding import fold
from homebot.units import Seconds

__all__ = ["RmfDoors", "RmfDoorsSettings"]

HandleT = TypeVar("HandleT", bound=Handle)

_EVERY: Final = 1.0
_CLOSED, _OPEN, _OFFLINE, _UNKNOWN = 0, 2, 3, 4
_MODES: Final = {None: _UNKNOWN, True: _OPEN, False: _CLOSED}
_MOST_HOLDERS: Final = 100


class RmfDoorsSettings(AppSettings):
    """The keys of the table of :class:`RmfDoors`.

    Attributes:
        held_for: Seconds for which a request holds a door open, unless it is repeated.
    """

    held_for: Seconds = 120.0


class RmfDoors(App):
    """Publishes ``/door_states`` and serves ``/adapter_door_requests`` for each door of the plan with a device.

    A door with a lock is open while that is unlocked; of another its contact says so. ``MODE_OPEN`` holds the lock
    unlocked for the requester; ``MODE_CLOSED`` of a requester releases its hold, and after the last one locks it.
    """

    Settings = RmfDoorsSettings

    def __init__(self, node: Node, settings: RmfDoorsSettings) -> None:
        super().__init__(node, settings)
        self._held_for = settings.held_for
        self._places = node.create_client(GetPlaces, GET_PLACES)
        self._doors: tuple[DoorInfo, ...] = ()
        self._holds: dict[tuple[str, str], anyio.CancelScope] = {}
        self._state_type: Any = find_message("rmf_door_msgs/msg/DoorState")
        self._mode_type: Any = find_message("rmf_door_msgs/msg/DoorMode")
        self._states = node.create_publisher(self._state_type, "/door_states", 100)
        self._tasks: TaskGroup | None = None
        node.create_subscription(find_message("rmf_door_msgs/msg/DoorRequest"), "/adapter_door_requests", self._request)

    async def run(self) -> None:
        """Publish the states of all doors once a second."""
        async with anyio.create_task_group() as tasks:
            self._tasks = tasks
            while True:
                try:
                    answer = await self._places.call(GetPlacesRequest(), timeout=5.0)
                    self._doors = tuple(door for door in answer.doors if door.lock or door.contact)
                except ServiceError as exc:
                    self.node.log.warning("rmf_doors.no_places", message=str(exc))
                for door in self._doors:
                    await self._publish(door)
                await anyio.sleep(_EVERY)

    async def _publish(self, door: DoorInfo) -> None:
        mode = self._mode_type(value=await self._mode(door))
        time = Time.from_seconds(self.node.graph.clock.now())
        self._states.publish(self._state_type(door_time=time, door_name=door.name, current_mode=mode))

    async def _mode(self, door: DoorInfo) -> int:
        if door.lock:
            lock = _named(await self.devices.find(DoorLock), door.lock)
            is_open = None if lock is None or lock.locked is None else not lock.locked
            return _OFFLINE if lock is None or lock.reachable is False else _MODES[is_open]
        contact = _named(await self.devices.find(ContactSensor), door.contact)
        is_open = None if contact is None else contact.is_open
        return _OFFLINE if contact is None or contact.reachable is False else _MODES[is_open]

    def _request(self, request: Message) -> None:
        """Begin, renew or end the hold of one requester."""
        stated: Any = request
        door = next((one for one in self._doors if fold(one.name) == fold(stated.door_name)), None)
        if door is None or not door.lock or not stated.requester_id.strip() or self._tasks is None:
            problem = "no requester is stated" if door and door.lock else f"{stated.door_name[:100]!r} has no lock"
            self.node.log.warning("rmf_doors.refused", message=f"a request for a door was refused: {problem}")
            return
        key = door.name, stated.requester_id[:100]
        before = self._holds.get(key)
        if stated.requested_mode.value == _OPEN:
            deadline = anyio.current_time() + self._held_for
            if before is not None:
                before.deadline = deadline
            elif len(self._holds) < _MOST_HOLDERS:
                self._holds[key] = scope = anyio.CancelScope(deadline=deadline)
                self._tasks.start_soon(partial(self._hold, key, door.lock, scope))
        elif stated.requested_mode.value == _CLOSED and before is not None:
            before.cancel()

    async def _hold(self, key: tuple[str, str], name: str, scope: anyio.CancelScope) -> None:
        """Hold a lock unlocked until *scope* ends; lock it after the last holder."""
        try:
            lock = _named(await self.devices.find(DoorLock), name)
            with scope:
                if lock is not None:
                    async with lock.hold("unlock", by=key[1]):
                        await anyio.sleep_forever()
        except RefusedError as exc:
            self.node.log.warning("rmf_doors.refused", message=f"{key[0]} is not opened for {key[1]}: {exc}")
            return
        finally:
            self._holds.pop(key, None)
        if lock is not None and not any(door == key[0] for door, _ in self._holds):
            await lock.lock()


def _named(handles: Iterable[HandleT], name: str) -> HandleT | None:
    return next((one for one in handles if fold(name) in {fold(one.id), fold(one.name)}), None)
