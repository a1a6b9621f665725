"""Drives of robots that are devices, such as those of a fleet: ``navigate_to_pose`` and ``dock_robot``, as in Nav2.

Such a device has a part ``x_robot`` that reports beside the ``topic`` of the robot: its ``option`` is what it does, and
takes ``idle``, which gives up its order, and ``charging``. A further one, a setting, takes where it may go.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, ClassVar, Final, TypeAlias, final

import anyio

from homebot.devices.devices import Devices
from homebot.devices.handles.handle import Handle
from homebot.errors import DuplicateNameError, RefusedError
from homebot.graph import Node
from homebot.graph.actions import ActionServer, Preemption, ServerGoal
from homebot.messages.definition import zero_message
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message
from homebot.places import HousePlan
from homebot.places.floor_plan import FloorPlan
from homebot.robots.robot import TrackedRobot
from homebot.support.folding import fold

NOT_SERVED = "robots.not_served"

_UNDER_WAY: Final = frozenset({"working", "paused"})
_CANCEL_S: Final = 20.0
"""Seconds that a robot has to give up its order."""

_UNREACHABLE: Final = 1
_Goal: TypeAlias = ServerGoal[Any, Any, Any]


class _RobotHandle(Handle):
    service_types: ClassVar[frozenset[str]] = frozenset({"x_robot"})

    @property
    def activity(self) -> str:
        """The activity, such as ``idle`` or ``working``."""
        return self._text("option") or ""

    @property
    def place(self) -> str:
        """The node on which it stands; empty while it drives."""
        return self._text("place") or ""


@final
class DeviceDrive:
    """Serves the actions of one robot while the house has its device; a new goal of either ends the last one."""

    def __init__(self, node: Node, devices: Devices, robot: TrackedRobot, house: Callable[[], HousePlan]) -> None:
        self._node, self._devices, self._robot, self._house = node, devices, robot, house
        self._device: _RobotHandle | None = None
        self._servers: list[ActionServer[Any, Any, Any]] = []
        self._changed = anyio.Event()
        self._goal: _Goal | None = None
        self._turn = anyio.Lock()

    @property
    def reachable(self) -> bool | None:
        """True if the device is reachable by its own connection; None while that is unknown, or it is not there."""
        return None if self._device is None else self._device.reachable

    async def run(self) -> None:
        """Serve until cancelled."""
        async for change in self._devices.follow(_RobotHandle, optional=True):
            part = change.handle.device.part(change.handle.part_id)
            if change.kind == "removed":
                if change.handle == self._device:
                    self._device = None
                    for server in self._servers:
                        server.close()
                    self._servers = []
            elif part is not None and change.handle.can("option") and self._is_beside(part.part.reads):
                is_new, self._device = self._device is None, change.handle
                if is_new:
                    self._serve()
            self._changed.set()
            self._changed = anyio.Event()

    def _is_beside(self, topics: Iterable[str]) -> bool:
        """Return whether the topic of the robot is one of its device, which are on one level."""
        base = self._robot.settings.topic.rpartition("/")[0]
        return bool(base) and base in {topic.rpartition("/")[0] for topic in topics}

    def _serve(self) -> None:
        try:
            for action, kind, execute in (
                ("navigate_to_pose", "NavigateToPose", self._navigate),
                ("dock_robot", "DockRobot", self._charge),
            ):
                action_type, path = find_action(f"nav2_msgs/action/{kind}"), f"/{self._robot.name}/{action}"
                self._servers.append(ActionServer(self._node, action_type, path, execute, preemption=Preemption.ABORT))
        except DuplicateNameError as exc:  # the robot has one of its own
            self._node.log.warning(NOT_SERVED, message=str(exc))

    async def _navigate(self, goal: _Goal) -> Message:
        pose = goal.request.pose
        if pose.header.frame_id.removeprefix("/") not in {"", "map"}:
            return self._end(goal, f"the frame {pose.header.frame_id[:100]!r} is not map")
        parts = await self._devices.find(_RobotHandle, category="config", optional=True)
        handle = next((part for part in parts if self._device and part.device.id == self._device.device.id), None)
        options = () if handle is None else next(one.options for one in handle.capabilities if one.name == "option")
        plan, settings = FloorPlan.of(self._house()), self._robot.settings
        at = plan.room_at(pose.pose.position.x, pose.pose.position.y, plan.level(settings.floor))
        room = "" if at is None else at.room
        named = (one for one in options if room and fold(settings.segments.get(one, one)) == fold(room))
        target = next(named, "")
        if handle is None or not target:
            known = f"of {', '.join(options)} none is {room or 'there'}" if options else "it takes no destinations"
            return self._end(goal, f"{self._robot.name} cannot go there: {known}; see segments of its table")
        return await self._drive(goal, handle, target, lambda one: one.place == target, handle, room)

    async def _charge(self, goal: _Goal) -> Message:
        if self._device is None:
            return self._end(goal, "it is gone")
        return await self._drive(goal, self._device, "charging", lambda one: one.activity == "charging")

    async def _drive(
        self,
        goal: _Goal,
        handle: _RobotHandle,
        target: str,
        is_done: Callable[[_RobotHandle], bool],
        heading: _RobotHandle | None = None,
        room: str | None = None,
    ) -> Message:
        """Command *handle* to *target*, and return when the robot is there, or does not go on."""
        if self._goal is not None and self._goal.is_active:
            self._goal.preempt()
        self._goal = goal
        async with self._turn:
            self._robot.head_for(room)
            try:
                problem = await self._reach(handle, target, is_done, heading)
            finally:
                self._robot.head_for(None)
                if goal.is_cancel_requested or goal.is_preempted:
                    await self._stop_device()
        return self._end(goal, problem)

    async def _reach(
        self,
        handle: _RobotHandle,
        target: str,
        is_done: Callable[[_RobotHandle], bool],
        heading: _RobotHandle | None,
    ) -> str:
        """Return why the robot is not there; empty if it is."""
        try:
            with anyio.CancelScope(shield=True):  # else nobody would know whether the robot has the order
                outcome = await handle.command("option", target)
        except RefusedError as exc:
            return str(exc)
        why = "" if outcome.succeeded else outcome.text
        while (robot := self._device) is not None:
            changed = self._changed
            if robot.freshness == "stale":
                return "it has been silent for too long"
            if heading is not None and heading.activity != target:
                return why or "it was sent elsewhere"
            if robot.activity not in _UNDER_WAY:
                return "" if is_done(robot) else why or f"it is {robot.activity} now"
            await changed.wait()
        return "it is gone"

    async def _stop_device(self) -> None:
        with anyio.move_on_after(_CANCEL_S, shield=True):
            if self._device is not None and self._device.activity in _UNDER_WAY:
                await self._device.command("option", "idle")

    def _end(self, goal: _Goal, problem: str = "") -> Message:
        """End *goal*, and return its result."""
        kind: type[Message] = goal.action_type.Result
        stated = {"error_code": _UNREACHABLE if problem else 0, "error_msg": problem, "success": not problem}
        result: Message = zero_message(kind).model_copy(
            update={name: value for name, value in stated.items() if name in kind.model_fields}
        )
        (goal.abort if problem else goal.succeed)(result)
        return result
