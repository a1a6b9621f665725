"""The devices near a robot for a live query, updated when the robot moves and when doors open or close."""

from collections.abc import Callable, Iterable
from typing import Final, final

import anyio

from homebot.devices.device import StateChange
from homebot.devices.house_view import HouseView
from homebot.devices.names import ROBOT_POSES, ROBOTS_NODE
from homebot.devices.query.terms import Query
from homebot.devices.robot_messages import RobotPose
from homebot.errors import RefusedError, ServiceError
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.log import LogLimit

NOT_KNOWN: Final = "devices.near_unknown"

_PAUSE: Final = 0.5
"""Seconds between two requests, except after a change of a door."""

_DOORS: Final = frozenset({"contact", "lock"})
_QOS: Final = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@final
class NearWatch:
    """The devices near a robot while its task runs; empty while the position of the robot is unknown.

    Args:
        changed: Called with the ids of the devices that came near or left.
    """

    def __init__(self, node: Node, view: HouseView, query: Query, changed: Callable[[Iterable[str]], None]) -> None:
        self.ids: frozenset[str] = frozenset()
        self._node = node
        self._clock = node.graph.clock
        self._view = view
        self._query = query
        self._changed = changed
        self._due, self._urgent = anyio.Event(), anyio.Event()
        self._scope = anyio.CancelScope()
        self._limit = LogLimit(node.graph.clock)
        self._poses = node.create_subscription(RobotPose, ROBOT_POSES, self._on_pose, _QOS, from_node=ROBOTS_NODE)
        self.ask()
        node.create_task(self._run)

    def close(self) -> None:
        """End the requests; idempotent."""
        self._scope.cancel()
        self._poses.close()

    def ask(self) -> None:
        """Schedule a request, because a device changed."""
        self._due.set()

    def on_values(self, change: StateChange) -> None:
        """Send a request at once if the values may be those of a door."""
        if any(reading.capability in _DOORS for reading in change.readings):
            self._due.set()
            self._urgent.set()

    def _on_pose(self, _: RobotPose) -> None:
        self._due.set()

    async def _run(self) -> None:
        with self._scope:
            while True:
                await self._due.wait()
                self._due, self._urgent = anyio.Event(), anyio.Event()
                before, self.ids = self.ids, frozenset()
                try:
                    self.ids = frozenset([device.id for device in (await self._view.find_near(self._query)).devices])
                except (RefusedError, ServiceError) as exc:
                    if self._limit.allows(NOT_KNOWN) is not None:
                        self._node.log.warning(NOT_KNOWN, message=f"nothing counts as near: {exc}")
                if changed := before ^ self.ids:
                    self._changed(sorted(changed))
                with anyio.move_on_after(_PAUSE):
                    await self._urgent.wait()
