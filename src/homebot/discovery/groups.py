"""The owner's groups: names for the devices that fit a query, as facts of these. Pure."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Final

from pydantic import BaseModel, ConfigDict

from homebot.config import parse_settings
from homebot.devices import Device, Fact
from homebot.devices.device import is_commanded
from homebot.devices.names import GROUP, OWNER
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.parse import parse_query
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
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["GroupSettings", "HouseGroups", "read_groups"]

_PASSING: Final = (StateIs, FreshnessIs, ReachableIs, IsNear, IsDisputed, IsUnapproved)
"""Terms whose matches change from moment to moment."""

_SOURCE: Final = "configuration"
_MOST: Final = 100
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
    if len(tables) > _MOST:
        raise ConfigError(source, "groups", f"there are {len(tables)} groups; {_MOST} is the limit")
    found: dict[str, str] = {}
    numbers: dict[str, int] = {}
    for number, table in enumerate(tables):
        if table is None:
            continue
        one = parse_settings(GroupSettings, table, source, f"groups.{number}")
        try:
            name = check_name(one.name)
        except UsageError as exc:
            raise ConfigError(source, f"groups.{number}.name", str(exc)) from exc
        if fold(name) in map(fold, found):
            raise ConfigError(source, f"groups.{number}.name", f"there is a group {name!r} already")
        found[name], numbers[name] = one.members, number
    for name, number in numbers.items():
        try:
            _members(name, found)
        except UsageError as exc:
            raise ConfigError(source, f"groups.{number}.members", str(exc)) from exc
    return found


class HouseGroups:
    """The groups of a house.

    Args:
        queries: The queries for the members, by the name of the group, as :func:`read_groups` returns them.
        read_at: When they were read, in seconds since the Unix epoch.
    """

    def __init__(self, queries: Mapping[str, str], read_at: float) -> None:
        self.queries = queries
        self._members = {name: _members(name, queries) for name in queries}
        self._said_at = Time.from_seconds(read_at)

    def facts_of(self, device: Device) -> tuple[Fact, ...]:
        """Return a fact for each group of which *device*, described without them, is a member.

        Its key names the members, after ``#`` and separated by commas, if only some of the parts are.
        """
        if not self._members or any(one.part.is_group for one in device.parts):
            return ()
        found = ((name, _source(device, query)) for name, query in self._members.items())
        return tuple(
            [
                Fact(name=GROUP, value=name, gateway="", convention=OWNER, key=source, said_at=self._said_at)
                for name, source in found
                if source
            ]
        )


def _source(device: Device, query: Query) -> str:
    """Return the key of the fact that *device* is a member; empty if neither it nor one of its parts fits *query*."""
    parts = [one for one in device.parts if is_commanded(one.part)]
    named = [one.id for one in parts if fits(query, PartFacets(device, one))]
    if 0 < len(named) < len(parts):
        return f"{_SOURCE}#{','.join(named)}"
    return _SOURCE if named or fits(query, facets_of(device)) else ""


def _members(name: str, queries: Mapping[str, str], *inside: str) -> Query:
    """Return the query for the members of *name*, in which that of another group takes the place of its name."""
    if name in inside:
        raise UsageError(f"the group {name!r} contains itself: {' in '.join((name, *reversed(inside)))}")
    if fold(queries[name]) in map(fold, queries):
        return _group(queries, (*inside, name), fold(queries[name]))
    query = parse_query(queries[name])
    if query == And(()):
        raise UsageError("is empty; write a query such as 'lights in living'")
    if any(isinstance(one, _PASSING) for one in leaves(query)):
        raise UsageError(
            f"{queries[name]!r} depends on what changes from moment to moment; name the members by type, room, name or "
            "tag"
        )
    return _expanded(query, partial(_group, queries, (*inside, name)))


def _expanded(query: Query, group: Callable[[str], Query]) -> Query:
    match query:
        case And(terms) | Or(terms):
            return type(query)(tuple([_expanded(one, group) for one in terms]))
        case Not(term):
            return Not(_expanded(term, group))
        case FactIs("group", folded):
            return group(folded)
        case _:
            return query


def _group(queries: Mapping[str, str], inside: tuple[str, ...], folded: str) -> Query:
    known = {fold(one): one for one in queries}
    if folded not in known:
        raise UsageError(f"there is no group {folded!r}; {did_you_mean(folded, known, 'give it a table [[groups]]')}")
    return _members(known[folded], queries, *inside)
