"""Entities of the graph: their descriptions, and the index that finds them. Pure."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Literal, NamedTuple, TypeAlias, final

from homebot.graph.qos import QoSProfile
from homebot.support.production_loop import load_beside_loop


class EntityKind(StrEnum):
    """The kinds of entities on the graph."""

    NODE = "node"
    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"
    SERVICE = "service"
    CLIENT = "client"
    ACTION_SERVER = "action server"
    ACTION_CLIENT = "action client"


@dataclass(frozen=True, slots=True)
class EndpointInfo:
    """One entity on the graph.

    Attributes:
        node: Full name of the owning node; for a node its own name.
        name: Full name of its topic, service or action; for a node its own name.
        ros_type: Full ROS type name, empty for a node.
        qos: Offered or requested QoS; None except for publishers and subscriptions.
    """

    kind: EntityKind
    node: str
    name: str
    ros_type: str = ""
    qos: QoSProfile | None = None


class ActionInfo(NamedTuple):
    """One action on the graph.

    Attributes:
        servers: Full names of the serving nodes.
        clients: Full names of the nodes that may send goals.
    """

    name: str
    ros_type: str
    servers: tuple[str, ...]
    clients: tuple[str, ...]


class GraphChange(NamedTuple):
    """An added or removed entity.

    Attributes:
        change: ``added`` or ``removed``.
    """

    change: Literal["added", "removed"]
    entity: EndpointInfo


Entities: TypeAlias = dict[int, EndpointInfo]
_Term: TypeAlias = tuple[dict[Any, Entities], Hashable]


class GraphEntity:
    """An entity that a node creates and closes.

    Args:
        info: The entity as the graph shows it.
        on_close: Called once, with the entity, when it leaves the graph.
    """

    def __init__(self, info: EndpointInfo, on_close: Callable[[Any], None]) -> None:
        self.info = info
        self.is_closed = False
        self._on_close: Callable[[Any], None] | None = on_close

    def close(self) -> None:
        """Leave the graph. Idempotent."""
        self.is_closed = True
        on_close, self._on_close = self._on_close, None  # breaks a reference cycle
        if on_close is not None:
            on_close(self)


@final
class OfferedEntity(GraphEntity):
    """Stands for an action or a service whose server costs memory and time, and is not needed in most runs.

    Attributes:
        load: Loads the modules of the server, in a thread; None if they are loaded.
    """

    def __init__(
        self,
        info: EndpointInfo,
        start: Callable[[], object],
        load: Callable[[], object] | None,
        on_close: Callable[[Any], None],
    ) -> None:
        """Use :meth:`homebot.graph.Node.offer_service` instead."""
        super().__init__(info, on_close)
        self._start = start
        self.load = load

    def start(self) -> None:
        """Create the server in its place. Idempotent."""
        if not self.is_closed:
            self.close()
            self._start()

    async def begin(self) -> None:
        """Create the server when its modules are loaded, for which nothing else waits. Idempotent."""
        if self.load is not None and not self.is_closed:
            await load_beside_loop(self.load)
        self.start()


@final
class EndpointIndex:
    """The descriptions of all entities, in the order in which they were added.

    The cost of a search is proportional to the number of entities with its rarest term.
    """

    def __init__(self) -> None:
        self._all: Entities = {}
        self._by_kind: dict[EntityKind, Entities] = {}
        self._by_name: dict[str, Entities] = {}
        self._by_node: dict[str, Entities] = {}
        self._by_type: dict[EntityKind, dict[str, Entities]] = {kind: {} for kind in EntityKind}

    def add(self, entity: object, info: EndpointInfo) -> None:
        """Add *entity* as *info*."""
        self._all[id(entity)] = info
        for index, term in self._terms_of(info):
            index.setdefault(term, {})[id(entity)] = info

    def remove(self, entity: object) -> EndpointInfo | None:
        """Remove *entity*; return its description, or None if it is unknown."""
        info = self._all.pop(id(entity), None)
        for index, term in () if info is None else self._terms_of(info):
            del index[term][id(entity)]
            if not index[term]:
                del index[term]
        return info

    def find(self, kind: EntityKind | None, name: str | None, node: str | None) -> tuple[EndpointInfo, ...]:
        """Return the entities of one *kind*, *name* and *node*; None means any."""
        terms: tuple[_Term, ...] = ((self._by_kind, kind), (self._by_name, name), (self._by_node, node))
        indexes = [index.get(term, {}) for index, term in terms if term is not None]
        return tuple(
            info
            for info in min(indexes, key=len, default=self._all).values()
            if (kind is None or info.kind is kind)
            and (name is None or info.name == name)
            and (node is None or info.node == node)
        )

    def count_of(self, node: str) -> int:
        """Return how many entities one *node* has."""
        return len(self._by_node.get(node, {}))

    def first_of_each_type(self, kind: EntityKind) -> tuple[EndpointInfo, ...]:
        """Return the oldest entity of one *kind* for each ROS type."""
        return tuple([next(iter(entities.values())) for entities in self._by_type[kind].values()])

    def of_type(self, kind: EntityKind, ros_type: str) -> tuple[EndpointInfo, ...]:
        """Return the entities of one *kind* with the full ROS type *ros_type*."""
        return tuple(self._by_type[kind].get(ros_type, {}).values())

    def _terms_of(self, info: EndpointInfo) -> tuple[_Term, ...]:
        """Return each index that contains an entity, with its term there."""
        by_type = self._by_type[info.kind]
        return (
            (self._by_kind, info.kind),
            (self._by_name, info.name),
            (self._by_node, info.node),
            (by_type, info.ros_type),
        )
