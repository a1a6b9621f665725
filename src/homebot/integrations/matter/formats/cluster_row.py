"""Rows: the capabilities of clusters, with their readers and encoders. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias, TypeVar

from homebot.conventions.command_values import require_option
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.integrations.matter.formats.endpoint import AttributeWrite, MatterEndpoint, MatterOrder, MatterOrders
from homebot.support.numbers import finite_number, whole_number

__all__ = [
    "ClusterRow",
    "Reader",
    "Writer",
    "any_bit",
    "choice",
    "choice_row",
    "flag",
    "number",
    "number_writer",
    "one_of",
]

Reader: TypeAlias = Callable[[MatterEndpoint, object], PlainValue]
"""Returns the value of a capability from an endpoint and the raw value of the row's attribute; None for unknown. Never
raises."""

RawT = TypeVar("RawT", int, str)

Writer: TypeAlias = Callable[[MatterEndpoint, Command], MatterOrders]


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
    write: Writer | None = None
    feature: int = 0
    when: Callable[[MatterEndpoint], object] | None = None
    orders: Callable[[MatterEndpoint], Mapping[str, MatterOrder]] | None = None
    options: tuple[str, ...] | Callable[[MatterEndpoint], tuple[str, ...]] = ()
    bounds: Callable[[MatterEndpoint], tuple[float, ...]] | None = None
    grid: Callable[[MatterEndpoint], tuple[float, ...]] | None = None
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
            grid=() if self.grid is None else self.grid(endpoint),
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


def number_writer(cluster: int, attribute: int, factor: int = 1) -> Writer:
    """Return a writer of numbers into an attribute, in steps of one part of *factor*."""
    return lambda _at, command: (AttributeWrite(cluster, attribute, round(command.value.number * factor)),)


def choice_row(
    cluster: int,
    attribute: int,
    names: Callable[[MatterEndpoint], Mapping[RawT, str]],
    order: Callable[[RawT], MatterOrder] | None = None,
    capability: str = "option",
) -> ClusterRow:
    """Return the row of a choice: a value of an attribute, each with one of the *names* of an endpoint.

    Args:
        order: Returns the order of a value; by default it is written into the attribute.
    """
    tell = order or partial(AttributeWrite, cluster, attribute)
    return ClusterRow(
        cluster,
        attribute,
        capability,
        lambda one, raw: next((name for known, name in names(one).items() if known == raw), None),
        when=names,
        orders=lambda one: {name: tell(known) for known, name in names(one).items()},
    )


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
