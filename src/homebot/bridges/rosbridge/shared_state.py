"""The state shared by all clients of the rosbridge server: counters, mistakes, expected topics, servers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, TypeAlias, final

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.client_error_log import ClientErrorLog
from homebot.bridges.rosbridge.backlog import TotalBacklog
from homebot.bridges.rosbridge.heartbeat import OwnedLeases
from homebot.bridges.rosbridge.settings import RosbridgeSettings
from homebot.bridges.time_slices import ServerTurns
from homebot.graph import EntityKind, Graph, Node, Publisher
from homebot.support.bounded_map import BoundedMap
from homebot.support.counters import fault, loss

if TYPE_CHECKING:
    from homebot.devices.access_messages import AccessRefused
    from homebot.devices.robot_owners import RobotOwners
    from homebot.graph import Service
    from homebot.graph.actions import ActionServer

_MAX_ADVERTISED: Final = 1000
_Server: TypeAlias = "Service[Any, Any] | ActionServer[Any, Any, Any]"


@dataclass(slots=True)
class RosbridgeCounters:
    """Counters of the rosbridge server since its start.

    Attributes:
        clients: Admitted clients.
        turned_away: Refused connections: too many, a foreign page, a wrong token.
        frames: Frames received from clients.
        requests_refused: Refused requests among them.
        rights_missing: Requests refused for lack of a right.
        slowed_down: Frames delayed because their client sends too many.
        clients_cut: Clients cut off because they did not read.
        clients_vanished: Clients cut off because they did not answer a ping while they had a goal or lease.
        feedback_lost: Feedback dropped because a client did not read.
    """

    clients: int = 0
    turned_away: int = 0
    frames: int = 0
    requests_refused: int = fault()
    rights_missing: int = 0
    slowed_down: int = 0
    clients_cut: int = fault()
    clients_vanished: int = 0
    feedback_lost: int = loss()


@final
class ExpectedTopics:
    """Callbacks for topics that do not exist yet; needs :meth:`run`."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._expected: dict[str, dict[Callable[[str], None], None]] = {}

    def expect(self, topic: str, callback: Callable[[str], None]) -> None:
        """Call *callback* once with the full name *topic* when the topic is first used."""
        self._expected.setdefault(topic, {})[callback] = None

    def forget(self, topic: str, callback: Callable[[str], None]) -> None:
        """Cancel *callback* for *topic*, if it is expected."""
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
class Provisions:
    """The servers of one connection of a client, by full name.

    A newer connection of the same client takes over names of an older one, because a client that reconnects after a
    network failure offers its services before its old connection is known to be dead.

    Attributes:
        on_taken: Called with each name that a newer connection takes over.
    """

    def __init__(self, client: str, providers: dict[str, Provisions], on_taken: Callable[[str], None]) -> None:
        self.client = client
        self._providers = providers
        self.on_taken = on_taken
        self._servers: dict[str, _Server] = {}

    def __len__(self) -> int:
        return len(self._servers)

    def add(self, name: str, create: Callable[[], _Server]) -> None:
        """Serve *name*. Idempotent."""
        if name in self._servers:
            return
        older = self._providers.get(name)
        if older is not None and older.client == self.client:
            older.remove(name)
            older.on_taken(name)
        self._servers[name] = create()
        self._providers[name] = self

    def remove(self, name: str) -> bool:
        """Withdraw the server of *name*; return whether there was one."""
        server = self._servers.pop(name, None)
        if server is None:
            return False
        del self._providers[name]
        server.close()
        return True

    def close_one(self) -> bool:
        """Withdraw one server; return whether there was one."""
        return bool(self._servers) and self.remove(next(reversed(self._servers)))


@final
class SharedState:
    """The state shared by all clients of a rosbridge server.

    Attributes:
        advertised: The types of the topics that clients advertised last, for publishing on a new connection: in the
            original server, the publisher of the last one remains for ten seconds.
        kept: The latched messages of all clients.
        providers: The connection that provides each service or action, by full name.
        refusals: The publisher of refusals for lack of a right; None before the first one.
    """

    def __init__(self, node: Node, settings: RosbridgeSettings, owners: Callable[[], RobotOwners]) -> None:
        self.node = node
        self.settings = settings
        self.owners = owners
        self.turns = ServerTurns()
        self.backlog = TotalBacklog(settings.max_waiting_bytes_of_all)
        self.kept = TotalBacklog(settings.max_kept_bytes_of_all)
        self.expected = ExpectedTopics(node.graph)
        self.counters = RosbridgeCounters()
        self.error_log = ClientErrorLog(node)
        self.advertised: BoundedMap[str, str] = BoundedMap(_MAX_ADVERTISED)
        self.providers: dict[str, Provisions] = {}
        self.refusals: Publisher[AccessRefused] | None = None

    @cached_property
    def leases(self) -> OwnedLeases:
        """The leases requested by clients."""
        return OwnedLeases(self.node)
