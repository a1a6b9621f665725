"""An endpoint of a Matter node: its attributes, the orders for it, and its abilities. Pure.

Source: Matter 1.4 Core Specification, 7.8 (endpoints), 7.13 (global attributes), 9.5 (Descriptor cluster).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from homebot.conventions.payload import text_of
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

__all__ = [
    "DESCRIPTOR",
    "TAG_LIST",
    "AttributeWrite",
    "ClusterInvocation",
    "MatterAbility",
    "MatterEndpoint",
    "MatterOrder",
    "WriteValue",
]

DESCRIPTOR: Final = 29
_DEVICE_TYPE_LIST, _PARTS_LIST, TAG_LIST = 0, 3, 4
_FEATURE_MAP, _ACCEPTED_COMMANDS = 0xFFFC, 0xFFF9

_NOTHING: Final[Mapping[int, object]] = {}

_TIMED_MS: Final = 1_000


class MatterEndpoint:
    """An endpoint, with its attributes as the server knows them.

    Args:
        id: Its number; 0 is the root of the node.

    Attributes:
        id: The same.
        clusters: Values by cluster and attribute, as JSON has them.
    """

    def __init__(self, id: int) -> None:  # noqa: A002 - Matter's word
        self.id = id
        self.clusters: dict[int, dict[int, object]] = {}

    def has(self, cluster: int, attribute: int | None = None) -> bool:
        """Return whether it has a cluster, or one attribute of it."""
        known = self.clusters.get(cluster)
        return known is not None and (attribute is None or attribute in known)

    def value(self, cluster: int, attribute: int) -> object:
        """Return a value; None if it is null or missing."""
        return self.clusters.get(cluster, _NOTHING).get(attribute)

    def number(self, cluster: int, attribute: int) -> float | None:
        """Return a value that is a number, else None."""
        return finite_number(self.value(cluster, attribute))

    def whole(self, cluster: int, attribute: int) -> int | None:
        """Return a value that is a whole number, such as one of an enumeration, else None."""
        value = self.value(cluster, attribute)
        return value if isinstance(value, int) and not isinstance(value, bool) else None

    def flag(self, cluster: int, attribute: int) -> bool | None:
        """Return a value that is true or false, else None."""
        value = self.value(cluster, attribute)
        return value if isinstance(value, bool) else None

    def text(self, cluster: int, attribute: int) -> str:
        """Return a value that is a text, on one line; empty if it is not a text."""
        return text_of(self.value(cluster, attribute))

    def structs(self, cluster: int, attribute: int) -> Iterator[Mapping[object, object]]:
        """Yield the structs in a value that is a list of structs; their fields are numbers, as text."""
        value = self.value(cluster, attribute)
        for one in value if isinstance(value, list) else ():
            if isinstance(one, dict):
                yield one

    def features(self, cluster: int) -> int:
        """Return the feature map of a cluster; 0 if it has none."""
        return self.whole(cluster, _FEATURE_MAP) or 0

    def accepts(self, cluster: int, command: int) -> bool:
        """Return whether it takes a command of a cluster; true where it does not say which it takes."""
        accepted = self.value(cluster, _ACCEPTED_COMMANDS)
        return command in accepted if isinstance(accepted, list) else True

    @property
    def device_types(self) -> tuple[int, ...]:
        """The numbers of its device types."""
        found = (one.get("0", one.get("deviceType")) for one in self.structs(DESCRIPTOR, _DEVICE_TYPE_LIST))
        return tuple(one for one in found if isinstance(one, int) and not isinstance(one, bool))

    @property
    def tags(self) -> tuple[tuple[int, int], ...]:
        """The namespaces and numbers of its semantic tags."""
        found = (
            (one.get("1", one.get("namespaceID")), one.get("2", one.get("tag")))
            for one in self.structs(DESCRIPTOR, TAG_LIST)
        )
        return tuple((space, tag) for space, tag in found if isinstance(space, int) and isinstance(tag, int))

    @property
    def children(self) -> tuple[int, ...]:
        """The numbers of the endpoints that it is composed of; of the root, all other endpoints."""
        value = self.value(DESCRIPTOR, _PARTS_LIST)
        return tuple(one for one in value if type(one) is int) if isinstance(value, list) else ()


@dataclass(frozen=True, slots=True)
class ClusterInvocation:
    """A command of a cluster.

    Attributes:
        cluster: The number of the cluster.
        command: The name of the command: ``MoveToLevel``.
        payload: Its fields.
        is_timed: Whether it must be sent as a timed interaction, which the specification requires of some.
        is_secret: Whether it contains a code.
    """

    cluster: int
    command: str
    payload: Mapping[str, object] = field(default_factory=dict, repr=False)
    is_timed: bool = False
    is_secret: bool = False

    def server_call(self, node: int, endpoint: int) -> tuple[str, dict[str, object]]:
        """Return the command for the server, and its arguments."""
        args: dict[str, object] = {
            "node_id": node,
            "endpoint_id": endpoint,
            "cluster_id": self.cluster,
            "command_name": self.command,
            "payload": dict(self.payload),
        }
        if self.is_timed:
            args["timed_request_timeout_ms"] = _TIMED_MS
        return "device_command", args


@dataclass(frozen=True, slots=True)
class AttributeWrite:
    """A new value for an attribute.

    Attributes:
        cluster: The number of the cluster.
        attribute: The number of the attribute.
        value: The value.
        is_secret: Always false.
    """

    cluster: int
    attribute: int
    value: object
    is_secret: bool = False

    def server_call(self, node: int, endpoint: int) -> tuple[str, dict[str, object]]:
        """Return the command for the server, and its arguments."""
        path = f"{endpoint}/{self.cluster}/{self.attribute}"
        return "write_attribute", {"node_id": node, "attribute_path": path, "value": self.value}


MatterOrder: TypeAlias = ClusterInvocation | AttributeWrite
"""One order for an endpoint."""

WriteValue: TypeAlias = Callable[[MatterEndpoint, PlainValue, float, str], tuple[MatterOrder, ...]]
"""Takes an endpoint, a value, the transition in seconds and a code; returns the orders that set the value."""


@dataclass(frozen=True, slots=True)
class MatterAbility:
    """One capability of an endpoint.

    Attributes:
        cluster: The cluster that it belongs to.
        capability: The capability.
        read: Returns its value from the known attributes; None if it is never reported.
        write: Returns the orders that set it; None if it cannot be set.
        also_read: A further cluster that it is read from; None if there is none.
        beside: The part of the endpoint that has it, such as ``battery``; empty for the main part.
    """

    cluster: int
    capability: Capability
    read: Callable[[MatterEndpoint], PlainValue] | None = None
    write: WriteValue | None = None
    also_read: int | None = None
    beside: str = ""
