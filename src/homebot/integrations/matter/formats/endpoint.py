"""Endpoint of a Matter node: its attributes, and the orders for it. Pure.

Source: Matter 1.4 Core Specification, 7.8 (endpoints), 7.13 (global attributes), 9.5 (Descriptor cluster).
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple, TypeAlias

from homebot.conventions.payload import text_of
from homebot.support.numbers import finite_number, whole_number

DESCRIPTOR: Final = 29
_DEVICE_TYPE_LIST, _PARTS_LIST, TAG_LIST = 0, 3, 4
_FEATURE_MAP, ACCEPTED_COMMANDS = 0xFFFC, 0xFFF9
_NOTHING: Final[Mapping[int, object]] = {}
_TIMED_MS: Final = 1_000


class MatterScene(NamedTuple):
    """A scene of an endpoint.

    Attributes:
        group: The number of its group; 0 for none.
        clusters: The values that it sets, by cluster and attribute.
    """

    group: int
    number: int
    name: str
    clusters: Mapping[int, Mapping[int, object]]

    @property
    def part_id(self) -> str:
        """The end of the id of the part that recalls it."""
        return f"scene-{self.group}-{self.number}"


class MatterEndpoint:
    """An endpoint (0 is the root of the node), with the server's JSON values by cluster and attribute.

    Attributes:
        scenes: The scenes that it keeps, as far as they were asked for.
    """

    def __init__(self, id: int) -> None:  # noqa: A002 - Matter's word
        self.id = id
        self.scenes: tuple[MatterScene, ...] = ()
        self.clusters: dict[int, dict[int, object]] = {}

    def has(self, cluster: int, attribute: int | None = None) -> bool:
        """Return whether it has a cluster, or one attribute of it."""
        known = self.clusters.get(cluster)
        return known is not None and (attribute is None or attribute in known)

    def value(self, cluster: int, attribute: int) -> object:
        """Return a value; None if it is null or missing."""
        return self.clusters.get(cluster, _NOTHING).get(attribute)

    def number(self, cluster: int, attribute: int, least: float = -math.inf, most: float = math.inf) -> float | None:
        """Return a number from *least* to *most*; None for another value."""
        number = finite_number(self.value(cluster, attribute))
        return number if number is not None and least <= number <= most else None

    def whole(self, cluster: int, attribute: int) -> int | None:
        """Return a whole number, such as one of an enumeration; None for another value."""
        return whole_number(self.value(cluster, attribute))

    def flag(self, cluster: int, attribute: int) -> bool | None:
        """Return a boolean; None for another value."""
        value = self.value(cluster, attribute)
        return value if isinstance(value, bool) else None

    def text(self, cluster: int, attribute: int) -> str:
        """Return a text on one line; empty for another value."""
        return text_of(self.value(cluster, attribute))

    def structs(self, cluster: int, attribute: int) -> Iterator[Mapping[object, object]]:
        """Yield the structs of a list; see :func:`field_of`."""
        value = self.value(cluster, attribute)
        return (struct for struct in (value if isinstance(value, list) else ()) if isinstance(struct, dict))

    def features(self, cluster: int) -> int:
        """Return the feature map of a cluster; 0 for none."""
        return self.whole(cluster, _FEATURE_MAP) or 0

    def accepts(self, cluster: int, command: int) -> bool:
        """Return whether it accepts a command of a cluster; true if it has no list of accepted commands."""
        accepted = self.value(cluster, ACCEPTED_COMMANDS)
        return command in accepted if isinstance(accepted, list) else True

    @property
    def device_types(self) -> tuple[int, ...]:
        """The numbers of its device types."""
        numbers = (
            whole_number(field_of(struct, 0, "deviceType")) for struct in self.structs(DESCRIPTOR, _DEVICE_TYPE_LIST)
        )
        return tuple(number for number in numbers if number is not None)

    @property
    def tags(self) -> tuple[tuple[int, int], ...]:
        """The namespaces and numbers of its semantic tags."""
        tags = (
            (field_of(struct, 1, "namespaceID"), field_of(struct, 2, "tag"))
            for struct in self.structs(DESCRIPTOR, TAG_LIST)
        )
        return tuple((space, tag) for space, tag in tags if isinstance(space, int) and isinstance(tag, int))

    @property
    def children(self) -> tuple[int, ...]:
        """The numbers of the endpoints below it; of the root, all other endpoints."""
        value = self.value(DESCRIPTOR, _PARTS_LIST)
        return tuple(number for number in value if type(number) is int) if isinstance(value, list) else ()


def field_of(struct: Mapping[object, object] | Mapping[str, object], number: int, name: str) -> object:
    """Return a field of a struct; the server names it by its number, as text, or by its name."""
    return struct.get(str(number), struct.get(name))


@dataclass(frozen=True, slots=True)
class ClusterInvocation:
    """A command of a cluster: ``MoveToLevel``; timed where the specification requires that, secret with a code."""

    cluster: int
    command: str
    payload: Mapping[str, object] = field(default_factory=dict, repr=False)
    is_timed: bool = False
    is_secret: bool = False

    def server_call(self, node: int, endpoint: int) -> tuple[str, dict[str, object]]:
        """Return the server's command and its arguments."""
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
    """A new value for an attribute; never secret."""

    cluster: int
    attribute: int
    value: object
    is_secret: bool = False

    def server_call(self, node: int, endpoint: int) -> tuple[str, dict[str, object]]:
        """Return the server's command and its arguments."""
        path = f"{endpoint}/{self.cluster}/{self.attribute}"
        return "write_attribute", {"node_id": node, "attribute_path": path, "value": self.value}


MatterOrder: TypeAlias = ClusterInvocation | AttributeWrite
MatterOrders: TypeAlias = tuple[MatterOrder, ...]
"""Orders for one endpoint, in their order."""
