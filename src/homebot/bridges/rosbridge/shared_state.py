"""State that all clients of the door share: counters, their mistakes, topics to come, the door's parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, final

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.client_error_log import ClientErrorLog
from homebot.bridges.rosbridge.backlog import DoorBacklog
from homebot.bridges.rosbridge.settings import DoorSettings
from homebot.bridges.turns import ServerTurns
from homebot.graph import EntityKind, Graph, Node

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
    from homebot.bridges.rosbridge.owned_leases import OwnedLeases
    from homebot.bridges.rosbridge.protocol import Operation
    from homebot.bridges.rosbridge.provided_services import Provisions
    from homebot.bridges.rosbridge.refusals import Refusals
    from homebot.devices.robot_owners import RobotOwners

__all__ = ["DoorCounters", "ExpectedTopics", "SharedState"]


@dataclass(slots=True)
class DoorCounters:
    """Numbers that only grow.

    Attributes:
        clients: Clients that were let in.
        turned_away: Connections that were not: too many, a foreign page, a wrong token.
        frames: Frames that clients sent.
        requests_refused: Number of refused requests among them.
        rights_missing: Number of requests without the right among them.
        slowed_down: Frames that had to wait because their client sends too many.
        clients_cut: Clients cut off because they took no bytes.
        clients_vanished: Clients cut off because they answered no ping while a goal or lease of theirs ran.
        fragments_dropped: Frames in fragments that were given up for newer ones.
        feedback_lost: Feedback messages dropped because a client did not read.
    """

    clients: int = 0
    turned_away: int = 0
    frames: int = 0
    requests_refused: int = 0
    rights_missing: int = 0
    slowed_down: int = 0
    clients_cut: int = 0
    clients_vanished: int = 0
    fragments_dropped: int = 0
    feedback_lost: int = 0


@final
class ExpectedTopics:
    """Calls back when a topic appears; :meth:`run` has to run for that."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._expected: dict[str, dict[Callable[[str], None], None]] = {}

    def expect(self, topic: str, callback: Callable[[str], None]) -> None:
        """Call *callback* once with the full name *topic* when the topic is first used."""
        self._expected.setdefault(topic, {})[callback] = None

    def forget(self, topic: str, callback: Callable[[str], None]) -> None:
        """Do not call *callback* for *topic* any more; one that was not expected is fine."""
        expecting = self._expected.get(topic, {})
        expecting.pop(callback, None)
        if not expecting:
            self._expected.pop(topic, None)

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Watch until cancelled."""
        with self._graph.watch() as changes:
            task_status.started()
            async for change in changes:
                if change.change == "added" and change.entity.kind in {EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION}:
                    for callback in self._expected.pop(change.entity.name, {}):
                        callback(change.entity.name)


@final
class SharedState:
    """The state that all clients of a door share.

    Args:
        owners: Returns the robots of the house, with their topics and frames.

    Attributes:
        expected: Topics to come.
        providers: The connection that provides each service and action, by its full name.
    """

    def __init__(self, node: Node, settings: DoorSettings, owners: Callable[[], RobotOwners]) -> None:
        self.node = node
        self.settings = settings
        self.owners = owners
        self.turns = ServerTurns()
        self.backlog = DoorBacklog(settings.max_waiting_bytes_of_all)
        self.expected = ExpectedTopics(node.graph)
        self.counters = DoorCounters()
        self.error_log = ClientErrorLog(node)
        self.providers: dict[str, Provisions] = {}

    def record_refusal(self, access: ClientAccess, address: str, op: Operation, error: MissingRightError) -> None:
        """Count, log and publish that *op* of a client was refused for want of a right."""
        self.counters.requests_refused += 1
        self.counters.rights_missing += 1
        self._refusals.record(access, address, op, error)

    @cached_property
    def _refusals(self) -> Refusals:
        from homebot.bridges.rosbridge.refusals import Refusals  # noqa: PLC0415 - with the first client

        return Refusals(self.node, self.error_log)

    @cached_property
    def leases(self) -> OwnedLeases:
        """The leases that clients asked for."""
        from homebot.bridges.rosbridge.owned_leases import OwnedLeases  # noqa: PLC0415 - with the first client

        return OwnedLeases(self.node)

    def held_by_all(self) -> int:
        """Return how many entities all clients together hold on the graph."""
        return self.node.graph.count_endpoints(self.node.full_name)
