"""The groups of a house, as facts of their members: the owner's, which have a query, and those of gateways. Pure."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Final, NamedTuple, final

from pydantic import BaseModel, ConfigDict

from homebot.config import parse_settings
from homebot.devices import Device, DevicePart, Fact
from homebot.devices.device import is_commanded
from homebot.devices.device_lookup import references
from homebot.devices.names import GROUP, OWNER
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import (
    And,
    FactIs,
    FreshnessIs,
    IsDisputed,
    IsNear,
    IsUnapproved,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    leaves,
)
from homebot.errors import ConfigError, UsageError
from homebot.messages import Time
from homebot.places import check_name
from homebot.support.folding import fold, is_room_typo
from homebot.words.queries import parse_query

_PASSING: Final = (StateIs, FreshnessIs, ReachableIs, IsNear, IsDisputed, IsUnapproved)
"""Terms with matches that change from moment to moment."""

_SOURCE: Final = "configuration"
_MAX_GROUPS: Final = 100
"""The limit of groups: each is a fact of its members, of which a device has 200."""


class GroupSettings(BaseModel):
    """A table ``[[groups]]``.

    Attributes:
        name: Its name for people, by which queries find its members.
        members: The query for its members, by type, room, name, tag or another group.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    name: str
    members: str


def read_groups(tables: Sequence[object], source: str) -> Mapping[str, str]:
    """Return the queries in the tables ``[[groups]]``, by the name of the group.

    Args:
        tables: The tables; None for one that was left out.

    Raises:
        ConfigError: A name is missing, wrong or given twice, or *members* is no query, or depends on states or, by way
            of other groups, on the group itself; the message names the key.
    """
    if len(tables) > _MAX_GROUPS:
        raise ConfigError(source, "groups", f"there are {len(tables)} groups; {_MAX_GROUPS} is the limit")
    groups: dict[str, str] = {}
    numbers: dict[str, int] = {}
    for number, table in enumerate(tables):
        if table is None:
            continue
        settings = parse_settings(GroupSettings, table, source, f"groups.{number}")
        try:
            name = check_name(settings.name)
        except UsageError as exc:
            raise ConfigError(source, f"groups.{number}.name", str(exc)) from exc
        if fold(name) in map(fold, groups):
            raise ConfigError(source, f"groups.{number}.name", f"there is a group {name!r} already")
        groups[name], numbers[name] = settings.members, number
    for name, number in numbers.items():
        try:
            _members(name, groups)
        except UsageError as exc:
            raise ConfigError(source, f"groups.{number}.members", str(exc)) from exc
    return groups


class _NativeGroup(NamedTuple):
    device: str
    name: str
    gateways: frozenset[str]
    said_at: Time


@final
class HouseGroups:
    """The groups of a house.

    Attributes:
        queries: The queries for the members of the owner's, by name, as :func:`read_groups` returns them.
        has_changed: Whether a gateway's group changed; to be reset once the members have their new facts.
    """

    def __init__(self) -> None:
        self.has_changed = False
        self.queries: Mapping[str, str] = {}
        self._members: Mapping[str, Query] = {}
        self._said_at = Time.from_seconds(0.0)
        self._native: dict[str, tuple[tuple[_NativeGroup, tuple[str, ...]], ...]] = {}
        self._by_member: dict[str, dict[_NativeGroup, None]] = {}

    def configure(self, queries: Mapping[str, str], read_at: float) -> None:
        """Take the owner's groups, read at *read_at*, in seconds since the Unix epoch."""
        self.queries, self._said_at = queries, Time.from_seconds(read_at)
        self._members = {name: _members(name, queries) for name in queries}

    def put(self, device: Device) -> None:
        """Take the groups that *device* is now, such as one of lamps."""
        groups = tuple(
            (group, part.part.members)
            for part in device.parts
            if part.part.is_group and part.routes
            for group in [_native_group(device, part)]
        )
        if self._native.get(device.id, ()) == groups:
            return
        self.discard(device.id)
        if groups:
            self._native[device.id], self.has_changed = groups, True
        for group, members in groups:
            for member in members:
                self._by_member.setdefault(member, {})[group] = None

    def discard(self, device_id: str) -> None:
        """Forget the groups that a device was."""
        for group, members in self._native.pop(device_id, ()):
            self.has_changed = True
            for member in members:
                groups = self._by_member.get(member, {})
                groups.pop(group, None)
                if not groups:
                    self._by_member.pop(member, None)

    def native_facts(self, device: Device) -> tuple[Fact, ...]:
        """Return a fact for each gateway's group of which *device* is a member, unless the owner's has its name."""
        parts: dict[_NativeGroup, list[str]] = {}
        for part in device.parts if self._native and not _is_group(device) else ():
            if is_commanded(part.part):
                for group in dict.fromkeys(self._groups_with(device, part)):
                    parts.setdefault(group, []).append(part.id)
        own = set(map(fold, self.queries))
        return tuple(
            [
                _fact(group.name, "", _key(group.device, device, ids), group.said_at)
                for group, ids in parts.items()
                if fold(group.name) not in own
            ]
        )

    def _groups_with(self, device: Device, part: DevicePart) -> Iterator[_NativeGroup]:
        gateways = {route.gateway for route in part.routes}
        for name in references(device, part, gateways):
            for group in self._by_member.get(name, ()):
                if not (name.startswith("#") and group.gateways.isdisjoint(gateways)):
                    yield group

    def facts_of(self, device: Device) -> tuple[Fact, ...]:
        """Return a fact for each group of which *device*, described without them, is a member.

        Its key names the members, after ``#`` and separated by commas, if only some of the parts are.
        """
        if _is_group(device):
            return ()
        native = self.native_facts(device)
        device = device.model_copy(update={"facts": (*native, *device.facts)}) if native and self._members else device
        sources = ((name, _source(device, query)) for name, query in self._members.items())
        return native + tuple([_fact(name, OWNER, source, self._said_at) for name, source in sources if source])


def _is_group(device: Device) -> bool:
    return any(part.part.is_group for part in device.parts)


def _fact(name: str, convention: str, key: str, said_at: Time) -> Fact:
    """Return a fact that no announcement of the member can state, which would name its gateway."""
    return Fact(name=GROUP, value=name, gateway="", convention=convention, key=key, said_at=said_at)


def _native_group(device: Device, part: DevicePart) -> _NativeGroup:
    gateways = frozenset([route.gateway for route in part.routes])
    return _NativeGroup(device.id, group_name(device, part), gateways, device.first_seen)


def group_name(device: Device, part: DevicePart) -> str:
    """Return the name of a gateway's group, which is a *part* of *device*."""
    return f"{device.name} {part.part.name}".strip()


def _source(device: Device, query: Query) -> str:
    """Return the key of the fact that *device* is a member; empty if neither it nor one of its parts fits *query*."""
    named = [part.id for part in device.parts if is_commanded(part.part) and fits(query, PartFacets(device, part))]
    return _key(_SOURCE, device, named) if named or fits(query, facets_of(device)) else ""


def _key(source: str, device: Device, named: Sequence[str]) -> str:
    """Return the key of the fact that the parts *named* of *device*, or none but itself, are members."""
    count = sum(is_commanded(part.part) for part in device.parts)
    return f"{source}#{','.join(named)}" if 0 < len(named) < count else source


def _members(name: str, queries: Mapping[str, str], *inside: str) -> Query:
    """Return the query for the members of *name*, in which that of another group takes the place of its name."""
    if name in inside:
        raise UsageError(f"the group {name!r} contains itself: {' in '.join((name, *reversed(inside)))}")
    if fold(queries[name]) in map(fold, queries):
        return _group(queries, (*inside, name), fold(queries[name]))
    query = parse_query(queries[name])
    if query == And(()):
        raise UsageError("is empty; write a query such as 'lights in living'")
    if any(isinstance(term, _PASSING) for term in leaves(query)):
        raise UsageError(
            f"{queries[name]!r} depends on what changes from moment to moment; name the members by type, room, name or "
            "tag"
        )
    return _expand(query, partial(_group, queries, (*inside, name)))


def _expand(query: Query, group: Callable[[str], Query]) -> Query:
    match query:
        case And(terms) | Or(terms):
            return type(query)(tuple([_expand(term, group) for term in terms]))
        case Not(term):
            return Not(_expand(term, group))
        case FactIs("group", folded):
            return group(folded)
        case _:
            return query


def _group(queries: Mapping[str, str], inside: tuple[str, ...], folded: str) -> Query:
    known = {fold(query): query for query in queries}
    if folded in known:
        return _members(known[folded], queries, *inside)
    if meant := sorted(name for name in known if is_room_typo(folded, name)):
        raise UsageError(f"there is no group {folded!r}; did you mean {' or '.join(meant)}?")
    return FactIs(GROUP, folded)  # of a gateway
