"""Endpoint of a Matter node: its attributes, the orders for it, and its capabilities as rows of clusters. Pure.

Source: Matter 1.4 Core Specification, 7.8 (endpoints), 7.13 (global attributes), 9.5 (Descriptor cluster).
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from homebot.conventions.command_values import require_option
from homebot.conventions.payload import text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number, whole_number

__all__ = [
    "ACCEPTED_COMMANDS",
    "DESCRIPTOR",
    "TAG_LIST",
    "AttributeWrite",
    "ClusterInvocation",
    "ClusterRow",
    "MatterEndpoint",
    "MatterOrder",
    "MatterOrders",
    "any_bit",
    "choice",
    "field_of",
    "flag",
    "number",
    "one_of",
]

DESCRIPTOR: Final = 29
_DEVICE_TYPE_LIST, _PARTS_LIST, TAG_LIST = 0, 3, 4
_FEATURE_MAP, ACCEPTED_COMMANDS = 0xFFFC, 0xFFF9
_NOTHING: Final[Mapping[int, object]] = {}
_TIMED_MS: Final = 1_000


class MatterEndpoint:
    """An endpoint (0 is the root of the node), with the server's JSON values by cluster and attribute."""

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
        found = (whole_number(field_of(one, 0, "deviceType")) for one in self.structs(DESCRIPTOR, _DEVICE_TYPE_LIST))
        return tuple(one for one in found if one is not None)

    @property
    def tags(self) -> tuple[tuple[int, int], ...]:
        """The namespaces and numbers of its semantic tags."""
        found = (
            (field_of(one, 1, "namespaceID"), field_of(one, 2, "tag")) for one in self.structs(DESCRIPTOR, TAG_LIST)
        )
        return tuple((space, tag) for space, tag in found if isinstance(space, int) and isinstance(tag, int))

    @property
    def children(self) -> tuple[int, ...]:
        """The numbers of the endpoints below it; of the root, all other endpoints."""
        value = self.value(DESCRIPTOR, _PARTS_LIST)
        return tuple(one for one in value if type(one) is int) if isinstance(value, list) else ()


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


Reader: TypeAlias = Callable[[MatterEndpoint, object], PlainValue]
"""Returns the value of a capability from an endpoint and the raw value of the row's attribute; None for unknown. Never
raises."""


@dataclass(frozen=True, slots=True)
class ClusterRow:
    """A capability of a cluster; an endpoint with the attribute, the feature and the condition has it.

    Attributes:
        attribute: Its attribute; None if the cluster is enough.
        read: The reader; None if it is never reported.
        write: Returns the orders of a command that fits the capability; raises RefusedError.
        orders: Returns the order of each text that it can be set to, instead of that.
        feature: Bits of the cluster's feature map, one of which is needed; 0 for none.
        options: All of its texts; by default those of *orders*.
        accepts: The number of the command that it needs to be settable.
        also_read: A further cluster of its value.
        part_suffix: The part of the endpoint with it, such as ``battery``; empty for the main part.
        spare_suffix: The part with it if another row gives the main part its capability; empty for none.
    """

    cluster: int
    attribute: int | None
    capability: str
    read: Reader | None = None
    write: Callable[[MatterEndpoint, Command], MatterOrders] | None = None
    feature: int = 0
    when: Callable[[MatterEndpoint], object] | None = None
    orders: Callable[[MatterEndpoint], Mapping[str, MatterOrder]] | None = None
    options: tuple[str, ...] | Callable[[MatterEndpoint], tuple[str, ...]] = ()
    bounds: Callable[[MatterEndpoint], tuple[float, ...]] | None = None
    unit: str | Callable[[MatterEndpoint], str] = ""
    accepts: int | None = None
    also_read: int | None = None
    part_suffix: str = ""
    spare_suffix: str = ""

    def describe(self, endpoint: MatterEndpoint) -> Capability | None:
        """Return the capability of *endpoint* by this row; None if it has none."""
        if not self._is_on(endpoint):
            return None
        is_settable = self.is_settable(endpoint)
        return Capability(
            name=self.capability,
            readable=self.read is not None or not is_settable,
            settable=is_settable,
            unit=self.unit if isinstance(self.unit, str) else self.unit(endpoint),
            bounds=() if self.bounds is None else self.bounds(endpoint),
            options=self._options(endpoint),
        )

    def is_settable(self, endpoint: MatterEndpoint) -> bool:
        """Return whether an endpoint with the capability lets it be set."""
        can_be = self.write is not None or self.orders is not None
        return can_be and (self.accepts is None or endpoint.accepts(self.cluster, self.accepts))

    def read_value(self, endpoint: MatterEndpoint) -> PlainValue:
        """Return the value of the capability; None for unknown, and for one that is never reported."""
        raw = None if self.attribute is None else endpoint.value(self.cluster, self.attribute)
        return None if self.read is None else self.read(endpoint, raw)

    def orders_of(self, endpoint: MatterEndpoint, command: Command) -> MatterOrders:
        """Return the orders of a command that fits the capability; raise RefusedError for what cannot be done now."""
        if self.write is not None:
            return self.write(endpoint, command)
        known = {} if self.orders is None else self.orders(endpoint)
        return (known[require_option(self.capability, command.value.text, known)],)

    def _options(self, endpoint: MatterEndpoint) -> tuple[str, ...]:
        if self.orders is not None and not self.options:
            return tuple(self.orders(endpoint))
        return self.options if isinstance(self.options, tuple) else self.options(endpoint)

    def _is_on(self, endpoint: MatterEndpoint) -> bool:
        if not endpoint.has(self.cluster, self.attribute):
            return False
        has_feature = not self.feature or endpoint.features(self.cluster) & self.feature
        return bool(has_feature and (self.when is None or self.when(endpoint)))


def number(divisor: float = 1, least: float = -1e12, most: float = 1e12) -> Reader:
    """Return a reader of raw numbers from *least* to *most*."""

    def read(_at: MatterEndpoint, raw: object) -> PlainValue:
        value = finite_number(raw)
        return round(value / divisor, 6) if value is not None and least <= value <= most else None

    return read


def flag(*, means: bool = True) -> Reader:
    """Return a reader of booleans; the value *means* is true."""
    return lambda _at, raw: raw is means if isinstance(raw, bool) else None


def _of_whole(meaning: Callable[[int], PlainValue]) -> Reader:
    def read(_at: MatterEndpoint, raw: object) -> PlainValue:
        value = whole_number(raw)
        return None if value is None else meaning(value)

    return read


def choice(meanings: Mapping[int, PlainValue]) -> Reader:
    """Return a reader of an enumeration; other numbers are unknown."""
    return _of_whole(meanings.get)


def one_of(*values: int) -> Reader:
    """Return a reader of an enumeration into whether it is one of *values*."""
    return _of_whole(lambda value: value in values)


def any_bit(mask: int = -1) -> Reader:
    """Return a reader of a bitmap into whether it has a bit of *mask*, which is of all bits unless given."""
    return _of_whole(lambda bits: bool(bits & mask))
