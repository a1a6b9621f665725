"""Rows: the capabilities of clusters, with their readers and encoders. Pure."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeAlias, TypeVar

from homebot.conventions.capability_row import CapabilityRow
from homebot.conventions.command_values import require_option
from homebot.devices.gateway_messages import Command
from homebot.devices.part import CodeKind
from homebot.devices.value import PlainValue
from homebot.integrations.matter.formats.endpoint import AttributeWrite, MatterEndpoint, MatterOrder, MatterOrders
from homebot.support.numbers import finite_number, whole_number

Reader: TypeAlias = Callable[[MatterEndpoint, object], PlainValue]
"""Returns the value of a capability from an endpoint and the raw value of the row's attribute; None for unknown. Never
raises."""

RawT = TypeVar("RawT", int, str)

Writer: TypeAlias = Callable[[MatterEndpoint, Command], MatterOrders]


ClusterRow: TypeAlias = CapabilityRow[MatterEndpoint, Callable[[MatterEndpoint], PlainValue], Writer]
"""A capability of an endpoint; it is watched by the numbers of its clusters, its own first."""


def cluster_row(
    cluster: int,
    attribute: int | None,
    capability: str,
    read: Reader | None = None,
    write: Writer | None = None,
    feature: int = 0,
    when: Callable[[MatterEndpoint], object] | None = None,
    orders: Callable[[MatterEndpoint], Mapping[str, MatterOrder]] | None = None,
    options: tuple[str, ...] | Callable[[MatterEndpoint], tuple[str, ...]] = (),
    bounds: tuple[float, ...] | Callable[[MatterEndpoint], tuple[float, ...]] = (),
    grid: tuple[float, ...] | Callable[[MatterEndpoint], tuple[float, ...]] = (),
    unit: str | Callable[[MatterEndpoint], str] = "",
    accepts: int | None = None,
    also_read: int | None = None,
    part: str = "",
    spare_part: str = "",
    code: CodeKind | Callable[[MatterEndpoint], CodeKind] = "",
) -> ClusterRow:
    """Return the row of a cluster; an endpoint with the attribute, the feature and the condition has it.

    Args:
        attribute: Its attribute; None if the cluster is enough.
        feature: Bits of the cluster's feature map, one of which is needed; 0 for none.
        orders: Returns the order of each text that it can be set to, in place of *write*.
        options: All of its texts; by default those of *orders*.
        accepts: The number of the command that it needs to be settable.
        also_read: A further cluster of its value.
    """

    def applies(endpoint: MatterEndpoint) -> object:
        has_it = endpoint.has(cluster, attribute) and (not feature or endpoint.features(cluster) & feature)
        return has_it and (when is None or when(endpoint))

    def order(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
        known = orders(endpoint) if orders else {}
        return (known[require_option(capability, command.value.text, known)],)

    return ClusterRow(
        capability,
        read and (lambda endpoint: read(endpoint, None if attribute is None else endpoint.value(cluster, attribute))),
        write or (order if orders else None),
        applies,
        options or (lambda endpoint: tuple(orders(endpoint)) if orders else ()),
        bounds,
        unit,
        grid,
        settable=lambda endpoint: accepts is None or endpoint.accepts(cluster, accepts),
        watched=(cluster,) if also_read is None else (cluster, also_read),
        part=part,
        spare_part=spare_part,
        code=code,
    )


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
    *,
    feature: int = 0,
    accepts: int | None = None,
) -> ClusterRow:
    """Return the row of a choice: a value of an attribute, each with one of the *names* of an endpoint.

    Args:
        order: Returns the order of a value; by default it is written into the attribute.
    """
    tell = order or partial(AttributeWrite, cluster, attribute)
    return cluster_row(
        cluster,
        attribute,
        capability,
        lambda endpoint, raw: next((name for known, name in names(endpoint).items() if known == raw), None),
        feature=feature,
        when=names,
        orders=lambda endpoint: {name: tell(known) for known, name in names(endpoint).items()},
        accepts=accepts,
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
