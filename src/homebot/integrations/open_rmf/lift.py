"""One lift for Open-RMF: its state, and the sessions of robots, one after the other.

Source: ``rmf_lift_msgs`` of rmf_internal_msgs, and ``lift_supervisor`` of rmf_ros2, without which this app is one.
"""

from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import Annotated, Any, Final, Self, TypeAlias, final

import anyio
from pydantic import Field, model_validator

from homebot.apps.base import App, AppSettings
from homebot.devices.handles.handle import Handle
from homebot.devices.lift import DOOR, is_open, why_it_stays
from homebot.devices.requesters import Requesters
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.graph import GraphEntity, Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.interfaces import find_message
from homebot.messages.message import Message
from homebot.support.folding import fold
from homebot.support.names import did_you_mean
from homebot.units import Seconds

_EVERY: Final = 1.0
"""Seconds between two states."""

_AGAIN: Final = 60.0
"""Seconds after which a lift that is not there is sent again, as somebody may have pressed a button in it."""

_REFUSED: Final = 5.0
"""Seconds after a refusal until the next attempt."""

_MAX_SESSIONS: Final = 100
_MAX_FLOORS: Final = 100
_Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]
_END, _AGV, _HUMAN = range(3)
_CLOSED, _MOVING, _OPEN = range(3)
_STOPPED, _UP, _DOWN, _UNKNOWN = range(4)
_NO_MODE, _BY_PERSONS, _BY_ROBOT, _, _OFFLINE = range(5)
_FLOOR_RANKS: Final = ("floor", "option", "number", "movement")
"""The capabilities by which a part takes the floor, best first."""

_ENDS: Final = ("closed", "open")


class LiftSettings(AppSettings):
    """The keys of the table of :class:`RmfLift`; devices are named by a name or id of the device or part.

    Attributes:
        name: The name of the lift for robots; by default that of the app.
        floor: The lift, or another device that takes the floor: as a choice, as a number counted from the lowest floor
            as 0, or, of a lift with two floors, as ``closed`` and ``open``.
        floors: The floors from the lowest to the highest, as robots name them; by default the choices.
        at: A device that reports the floor where the lift is, if ``floor`` reports the one to which it was sent.
        door: The motor of its door, or a contact of a door that moves by itself; by default that of the device, if it
            has one.
        doors: Those of floors with a door of their own, by floor.
        held_for: Seconds after which a session ends without a further request, although its robot is connected.
        supervised: True if a lift supervisor of Open-RMF runs: it hears robots, and its ``/lift_requests`` are served.
    """

    name: str = ""
    floor: _Name
    floors: Annotated[tuple[_Name, ...], Field(max_length=_MAX_FLOORS)] = ()
    at: str = ""
    door: str = ""
    doors: Annotated[Mapping[str, _Name], Field(max_length=_MAX_FLOORS)] = Field(default_factory=dict)
    held_for: Annotated[Seconds, Field(ge=5)] = 600.0
    supervised: bool = False

    @model_validator(mode="after")
    def _check_floors(self) -> Self:
        if len(self.floors) == 1 or len({*self.floors}) < len(self.floors):
            raise ValueError(f"floors are at least two, each once, got {list(self.floors)}")
        if self.floors and (unknown := sorted({*self.doors} - {*self.floors})):
            raise ValueError(f"doors has {unknown[0]!r}, which is none of floors: {', '.join(self.floors)}")
        return self


@dataclass(eq=False)
class _LiftSession:
    """The session of one robot.

    Attributes:
        scope: The scope in which it is served; its end ends the session.
        sender: The publisher of its last request.
    """

    id: str
    floor: str
    is_open: bool
    ends_at: float
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    sender: GraphEntity | None = None


@final
class RmfLift(App[LiftSettings]):
    """Publishes ``/lift_states`` of one lift, and serves requests for it.

    The first session has the lift until its ``REQUEST_END_SESSION``, or the end of its connection, or of that of the
    robot of its name; others wait in the order of their first requests. Meanwhile the floor and the door are held for
    it: the lift is sent to its floor with the door closed, and the door is open while it is there.
    """

    def __init__(self, node: Node, settings: LiftSettings) -> None:
        super().__init__(node, settings)
        self._settings = settings
        self._name = settings.name or node.name
        self._requesters = Requesters(node)
        self._parts: dict[str, Handle] = {}
        self._sessions: dict[str, _LiftSession] = {}
        self._floor = ""
        self._changed = anyio.Event()
        self._state_type: Any = find_message("rmf_lift_msgs/msg/LiftState")
        self._states = node.create_publisher(self._state_type, "/lift_states", 100)
        requests = "/lift_requests" if settings.supervised else "/adapter_lift_requests"
        self._requests = node.create_subscription(
            find_message("rmf_lift_msgs/msg/LiftRequest"), requests, self._request, names_sender=True
        )

    async def run(self) -> None:
        """Publish the state once a second, and serve one session after the other."""
        settings = self._settings
        named = {"floor": settings.floor, "at": settings.at, "door": settings.door or settings.floor, **settings.doors}
        async with anyio.create_task_group() as tasks:
            for role, name in named.items():
                if name:
                    tasks.start_soon(self._follow, role, name)
            tasks.start_soon(self._serve)
            while True:
                for session in tuple(self._sessions.values()):
                    is_gone = await self._requesters.is_gone(session.id, session.sender)
                    if is_gone or session.ends_at <= anyio.current_time():
                        why = "its connection has ended" if is_gone else "it was not heard for too long"
                        self._warn(f"the session of {session.id} ends: {why}")
                        self._end(session.id)
                self._wake()
                self._states.publish(self._state())
                await anyio.sleep(_EVERY)

    async def _follow(self, role: str, name: str) -> None:
        """Keep the part that *name* means: of a device with several the one that a lift needs there."""
        ranks = _FLOOR_RANKS if role == "floor" else DOOR if role != "at" else ()
        async for change in self.devices.follow(Handle, name=name):
            handle, known = change.handle, self._parts.get(role)
            if change.kind == "removed":
                if handle == known:
                    del self._parts[role]
            elif _rank(handle, ranks) < (max(1, len(ranks)) if known is None else _rank(known, ranks)):
                self._parts[role] = handle
            self._wake()

    def _wake(self) -> None:
        self._changed.set()
        self._changed = anyio.Event()

    @property
    def _car(self) -> Handle | None:
        return self._parts.get("floor")

    def _floors(self) -> tuple[str, ...]:
        car = () if self._car is None else self._car.capabilities
        options = next((one.options for one in car if one.name in _FLOOR_RANKS and one.options), ())
        return self._settings.floors or options

    def _current(self) -> str:
        """Return the floor where the lift is, else the last one."""
        handle, floors = self._parts.get("at" if self._settings.at else "floor"), self._floors()
        has = [] if handle is None else [one.name for one in handle.capabilities if one.readable]
        values = () if handle is None else map(handle.value, ["floor"] if "floor" in has else has)
        for value in values:
            index = _ENDS.index(value) if value in _ENDS and len(floors) == len(_ENDS) else value
            if value in floors:
                self._floor = str(value)
            elif isinstance(index, int | float) and not isinstance(index, bool) and index in range(len(floors)):
                self._floor = floors[int(index)]
        return self._floor

    def _word(self, floor: str) -> str:
        """Return what the device takes for *floor*."""
        index = self._floors().index(floor)
        kind = "" if self._car is None else _FLOOR_RANKS[_rank(self._car, _FLOOR_RANKS)]
        return {"number": str(index), "movement": ("close", "open")[min(index, 1)]}.get(kind, floor)

    def _door(self, floor: str) -> Handle | None:
        """Return the door at *floor*; None if it has none, as a motor that is the lift itself."""
        door = self._parts.get(floor if floor in self._settings.doors else "door")
        return None if door is None or (door == self._car and not door.can("floor")) else door

    def _door_state(self) -> int:
        """Return the state of the door where the lift is; one without a door is open while it stands still.

        A door of which nothing is known is neither open nor closed.
        """
        if door := _values(self._door(self._current()), DOOR):
            return {False: _CLOSED, True: _OPEN, None: _MOVING}[is_open(door)]
        return _CLOSED if self._direction() else _OPEN

    def _may_go(self) -> bool:
        return not why_it_stays(_values(self._car, ("session",)), _values(self._door(self._current()), DOOR))

    def _direction(self) -> int:
        """Return whether the lift moves, and where to."""
        floors, target = self._floors(), self._target()
        here = self._current()
        if not {here, target} <= {*floors}:
            return _UNKNOWN
        return _STOPPED if here == target else _UP if floors.index(target) > floors.index(here) else _DOWN

    def _first(self) -> _LiftSession | None:
        return next(iter(self._sessions.values()), None)

    def _target(self) -> str:
        first = self._first()
        return self._current() if first is None else first.floor

    def _state(self) -> Message:
        first, car = self._first(), self._car
        is_away = car is None or car.reachable is False
        mode = _OFFLINE if is_away else _NO_MODE if not self._current() else _BY_ROBOT if first else _BY_PERSONS
        state: Message = self._state_type(
            lift_time=Time.from_seconds(self.node.graph.clock.now()),
            lift_name=self._name,
            available_floors=self._floors(),
            current_floor=self._current(),
            destination_floor=self._target(),
            door_state=self._door_state(),
            motion_state=_UNKNOWN if is_away else self._direction(),
            available_modes=bytes((_BY_PERSONS, _BY_ROBOT)),
            current_mode=mode,
            session_id=first.id if first else str(_values(car, ("session",)).get("session") or ""),
        )
        return state

    def _request(self, request: Message) -> None:
        stated: Any = request
        if fold(stated.lift_name) != fold(self._name):
            return
        name, floors = stated.session_id.strip()[:100], self._floors()
        floor = next((one for one in floors if fold(one) == fold(stated.destination_floor)), "")
        if not name:
            self._warn("a request was refused: no session is stated")
        elif stated.request_type == _END:
            self._end(name)
        elif stated.request_type not in {_AGV, _HUMAN}:
            self._warn(f"a request of {name} was refused: its request_type is {stated.request_type}, not 0, 1 or 2")
        elif not floor:
            hint = did_you_mean(stated.destination_floor[:100], floors, f"it has {', '.join(floors) or 'none yet'}")
            self._warn(f"a request of {name} was refused: {stated.destination_floor[:100]!r} is no floor; {hint}")
        elif stated.request_type == _HUMAN and stated.door_state not in {_CLOSED, _OPEN}:
            self._warn(f"a request of {name} was refused: its door_state is {stated.door_state}, not 0 or 2")
        elif name not in self._sessions and len(self._sessions) >= _MAX_SESSIONS:
            self._warn(f"a request of {name} was refused: {_MAX_SESSIONS} others wait")
        else:
            is_open = stated.request_type == _AGV or stated.door_state == _OPEN
            session = self._sessions.setdefault(name, _LiftSession(name, floor, is_open, 0.0))
            session.floor, session.is_open = floor, is_open
            session.sender, session.ends_at = self._requests.sender, anyio.current_time() + self._settings.held_for
        self._wake()

    def _end(self, name: str) -> None:
        if (session := self._sessions.pop(name, None)) is not None:
            session.scope.cancel()

    async def _serve(self) -> None:
        while True:
            session = self._first()
            if session is None:
                await self._changed.wait()
                continue
            with session.scope:
                while True:
                    try:
                        await self._carry(session, session.floor)
                    except RefusedError as exc:
                        self._warn(f"it is not moved for {session.id}: {exc}")
                        await anyio.sleep(_REFUSED)
            await self._make_ready()

    async def _carry(self, session: _LiftSession, floor: str) -> None:
        """Bring the lift to *floor*, and hold it and its door there until the session wants another one."""
        while (car := self._car) is None:
            await self._changed.wait()
        if self._current() != floor:
            await self._make_ready()
        async with car.hold(self._word(floor), by=session.id):
            with anyio.move_on_after(_AGAIN):
                while self._current() != floor and session.floor == floor:
                    await self._changed.wait()
            while self._current() == floor == session.floor:
                async with self._opened(session, floor):
                    is_open = session.is_open
                    while session.floor == floor == self._current() and session.is_open is is_open:
                        await self._changed.wait()

    @asynccontextmanager
    async def _opened(self, session: _LiftSession, floor: str) -> AsyncIterator[None]:
        """Hold the door open, if the session wants it so and the door has a motor."""
        door = self._door(floor)
        if door is None or not _has_motor(door):
            yield
        elif not session.is_open:
            await self._make_ready()
            yield
        else:
            async with door.hold("open", by=session.id) as hold:
                if not hold.succeeded:
                    self._warn(f"the door is not open for {session.id}: {hold.outcome.text}")
                yield

    async def _make_ready(self) -> None:
        """Close the door where the lift is, and return when nothing is in the way of the lift."""
        while not self._may_go():
            with anyio.move_on_after(_AGAIN):
                door = self._door(self._current())
                if door is not None and _has_motor(door) and self._door_state() != _CLOSED:
                    with suppress(RefusedError):
                        by_movement = door.can("movement")
                        await door.command(*(("movement", "closed") if by_movement else ("position", 0.0)))
                while not self._may_go():
                    await self._changed.wait()

    def _warn(self, message: str) -> None:
        self.node.log.warning("rmf_lift.refused", message=f"{self._name}: {message}")


def _rank(handle: Handle, ranks: tuple[str, ...]) -> int:
    """Return the first of *ranks* that the part has, and can set if it is no door; their number for none."""
    has = {one.name for one in handle.capabilities if one.settable or ranks is DOOR}
    return next((rank for rank, name in enumerate(ranks) if name in has), len(ranks))


def _values(part: Handle | None, names: Iterable[str]) -> dict[str, PlainValue]:
    """Return the values of *part* among the capabilities *names*, None for unknown ones."""
    return {} if part is None else {one.name: part.value(one.name) for one in part.capabilities if one.name in names}


def _has_motor(door: Handle) -> bool:
    return door.can("movement") or door.can("position")
