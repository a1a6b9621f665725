"""Facts that the owner states about devices: rooms, aliases and tags, which outrank announced ones. Pure.

A statement by a command or an import belongs to the announcements that the device had at the time, so that each keeps
it when devices are merged or split. It is also stored under the device id, for a device with new announcements, and
under the hardware address if a places file gives one. The configuration names devices by id or hardware address; former
ids are remembered, so that a device is still found after a merge.

An approval, in contrast, is bound to one announced part; see :mod:`homebot.discovery.approvals`.

A command outranks an import, an import the configuration, and a later statement an earlier one.
"""

import json
from collections.abc import Collection, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, final, get_args

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from homebot.config import UNNAMED, value_errors
from homebot.devices.part import CommandDescription
from homebot.discovery.approvals import ApprovalRegistry
from homebot.discovery.house_rooms import HouseRooms
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.errors import ConfigError, RefusedError, WireError
from homebot.places import FactName, HouseDoor, HousePlan, HouseRoom, OwnerFact, Places, read_position
from homebot.support.folding import fold

if TYPE_CHECKING:
    from homebot.discovery.groups import HouseGroups

MAX_STATEMENTS = 100_000
"""Most announcements, ids and hardware addresses with statements; further ones are refused."""

_Facts: TypeAlias = tuple[OwnerFact, ...]
_Name: TypeAlias = SourceKey | str
"""The key of an announcement, or the id or a hardware address of a device."""

_NONE: _Facts = ()
_MAX_NAMED = 5


class StatementRecord(BaseModel):
    """Facts, with the announcements and names to which they apply."""

    model_config = ConfigDict(extra="ignore", defer_build=True)

    facts: tuple[OwnerFact, ...]
    announcements: tuple[tuple[str, str], ...] = ()
    names: tuple[str, ...] = ()

    @field_validator("facts")
    @classmethod
    def _with_positions_that_can_be_read(cls, facts: tuple[OwnerFact, ...]) -> tuple[OwnerFact, ...]:
        with value_errors():
            for fact in facts:
                if fact.name.endswith("position"):
                    read_position(fact.value)
        return facts


class PlacesRecord(BaseModel):
    """The statements, imported rooms and approvals in the index file.

    Attributes:
        known_as: Gateway and key of announcements, each with its name in the configuration.
        approvals: Gateway, key, part, description and time of each.
    """

    model_config = ConfigDict(extra="ignore", defer_build=True)

    statements: tuple[StatementRecord, ...] = ()
    rooms: tuple[HouseRoom, ...] = ()
    doors: tuple[HouseDoor, ...] = ()
    known_as: tuple[tuple[str, str, str], ...] = ()
    approvals: tuple[tuple[str, str, str, CommandDescription, float], ...] = ()


def read_places_record(text: str) -> PlacesRecord:
    """Parse a record.

    Raises:
        WireError: It is invalid.
    """
    try:
        return PlacesRecord.model_validate_json(text)
    except ValidationError as exc:
        raise WireError(f"no places: {exc.errors()[0]['msg']}", text[:100].encode(errors="replace")) from exc


@dataclass(slots=True, eq=False)
class _Statement:
    """Facts that commands and imports state about the device with these names."""

    facts: _Facts
    names: dict[_Name, None]

    def announcements(self) -> list[SourceKey]:
        """Return the names that are keys of announcements."""
        return [name for name in self.names if not isinstance(name, str)]


@final
class OwnerFacts:
    """The rooms of the house, and the facts that the owner states about devices.

    Its methods raise RefusedError for too many statements or approvals; those for rooms also raise the errors of
    :class:`HouseRooms`.

    Args:
        places: The table ``[places]`` of the configuration.
        read_at: When that was read, in seconds since the Unix epoch.

    Attributes:
        closed_door: Metres that a closed door adds to a path.
        is_empty: Whether nothing has been stated about any device.
        is_unsaved: Whether some statements are not in the index file.
        groups: The groups of the house; None as long as there are none.
        prefer: The gateways that the configuration prefers for commands, best first.
        read_at: When the configuration was read at the start, in seconds since the Unix epoch.
    """

    def __init__(self, home: str = UNNAMED, places: Places | None = None, read_at: float = 0.0) -> None:
        given = places or Places()
        self.closed_door = given.closed_door
        self.rooms = HouseRooms(home, given.rooms, given.doors)
        self.approvals = ApprovalRegistry()
        self.is_unsaved = False
        self.prefer: tuple[str, ...] = ()
        self.groups: HouseGroups | None = None
        self._configure_groups(given, read_at)
        self.read_at = read_at
        self._configured, self._configured_names = _configured(given, read_at), tuple(given.devices)
        self._by_name: dict[_Name, _Statement] = {}
        self._known_as: dict[SourceKey, str] = {}
        self.is_empty = not self._configured

    @property
    def plan(self) -> HousePlan:
        """All rooms of the house."""
        return self.rooms.plan

    def of(self, device_id: str, sources: Collection[SourceRecord]) -> _Facts:
        """Return the facts of a device, each once: room, aliases in order of display, tags.

        Not to be called while :attr:`is_empty`.
        """
        stated = self.stated(device_id, sources)
        facts = (*stated, *self._configured_of(device_id, sources)) if self._configured else stated
        return _once(facts) if facts else _NONE

    def stated(self, device_id: str, sources: Collection[SourceRecord]) -> _Facts:
        """Return the facts that commands and imports stated about a device: commands first, later ones first."""
        if not self._by_name:
            return _NONE
        return self.stated_of(source.key for source in sources) or self.stated_of(_names(device_id, sources))

    def known_as(self, key: SourceKey) -> str:
        """Return the name under which the configuration states facts about an announcement; empty for none."""
        return self._known_as.get(key, "")

    def put(
        self,
        device_id: str,
        sources: Collection[SourceRecord],
        facts: Iterable[OwnerFact],
        present: Container[SourceKey],
    ) -> None:
        """Replace the statements of commands and imports about a device.

        Args:
            facts: The facts; empty to withdraw all statements.
            present: All current announcements; those of the device that are gone lose their statements too.
        """
        own: dict[_Name, None] = {**dict.fromkeys(source.key for source in sources), device_id: None}
        stated = _Statement(tuple(facts), own)
        if stated.facts:
            self.check_room(sum(name not in self._by_name for name in own))
        for statement in self._statements((*own, *_names(device_id, sources))):
            gone = [key for key in statement.announcements() if key not in present]
            names = (*own, *gone)
            self._leave(statement, names)
            if not statement.announcements():  # or a device that shares a hardware address would get it too
                self._leave(statement, tuple(statement.names))
        if stated.facts:
            self._put(stated)
        self.is_unsaved = True

    def _leave(self, statement: _Statement, names: Iterable[_Name]) -> None:
        for name in names:
            statement.names.pop(name, None)
            if self._by_name.get(name) is statement:
                del self._by_name[name]

    def put_unknown(self, names: Iterable[str], facts: Iterable[OwnerFact], present: Container[SourceKey]) -> None:
        """Replace the statements of commands and imports about a device that does not exist yet.

        Args:
            names: The id, or the hardware addresses, that it will have.
            facts: The facts; empty to withdraw all statements.
        """
        stated = _Statement(tuple(facts), dict.fromkeys(names))
        self.check_room(sum(name not in self._by_name for name in stated.names))
        for before in self._statements(tuple(stated.names)):
            stated.names |= dict.fromkeys(key for key in before.announcements() if key not in present)
            self._leave(before, stated.names)
        if stated.facts:
            self._put(stated)
        self.is_unsaved = True

    def unknown(self, known: Collection[_Name]) -> Iterator[tuple[list[str], _Facts]]:
        """Yield the ids and hardware addresses, and the facts, of each device none of whose names is *known*."""
        seen = set(known)
        for names in (*(statement.names for statement in self._statements(self._by_name)), *self._configured_names):
            own = [name for name in names if isinstance(name, str)]
            if own and seen.isdisjoint(names):
                seen.update(own)
                configured = (fact for name in own for fact in self._configured.get(name, ()))
                yield own, _once((*self.stated_of(own), *configured))

    def stated_of(self, names: Iterable[_Name]) -> _Facts:
        """Return the facts that commands and imports stated about a device under these *names*."""
        return _once(sorted((fact for statement in self._statements(names) for fact in statement.facts), key=_rank))

    def import_rooms(self, rooms: Iterable[HouseRoom], source: str, doors: Iterable[HouseDoor] = ()) -> None:
        """Add *rooms* and *doors* to the plan."""
        self.rooms.add(rooms, source, doors)
        self.is_unsaved = True

    def reconfigure(self, places: Places, rooms: HouseRooms, read_at: float) -> None:
        """Replace the statements of the configuration, with *rooms* to match."""
        self._configure_groups(places, read_at)
        self.closed_door, self.rooms = places.closed_door, rooms
        self._configured, self._configured_names = _configured(places, read_at), tuple(places.devices)
        self.is_empty = self.is_empty and not self._configured

    def _configure_groups(self, places: Places, read_at: float) -> None:
        if places.groups or self.groups is not None:
            self.any_groups().configure(places.groups, read_at)

    def any_groups(self) -> "HouseGroups":
        """Return the groups of the house, which may be none yet."""
        if self.groups is None:
            from homebot.discovery.groups import HouseGroups  # noqa: PLC0415 - many homes have none

            self.groups = HouseGroups()
        return self.groups

    def remove_room(self, name: str) -> None:
        """Remove an imported room and its doors from the plan, unless devices were placed in it."""
        if placed := sorted(
            str(min(statements.names, key=lambda name: not isinstance(name, str))) for statements in self._in(name)
        ):
            named = ", ".join(placed[:_MAX_NAMED]) + (", …" if len(placed) > _MAX_NAMED else "")
            reason = f"devices were placed in it: {named}; place them elsewhere first"
            raise RefusedError(f"removing the room {name!r}", reason)
        self.rooms.remove(name)
        self.is_unsaved = True

    def rename_room(self, name: str, new: str) -> None:
        """Rename a room that was imported, or in which devices were placed."""
        in_it = self._in(name)
        if fold(new) != fold(name) and self._in(new):
            raise RefusedError(f"renaming the room {name!r}", f"there is a room {new!r} already")
        self.rooms.rename(name, new, is_stated=bool(in_it))
        for statements in in_it:
            statements.facts = tuple(
                fact._replace(value=new) if _is_room(fact, name) else fact for fact in statements.facts
            )
        self.is_unsaved = True

    def _statements(self, names: Iterable[_Name]) -> Iterable[_Statement]:
        """Return the statements about devices with these *names*, each once."""
        return dict.fromkeys(self._by_name[name] for name in names if name in self._by_name)

    def _in(self, room: str) -> list[_Statement]:
        """Return the statements about devices placed in *room*."""
        return [
            statement
            for statement in self._statements(self._by_name)
            if any(_is_room(fact, room) for fact in statement.facts)
        ]

    def check_room(self, count: int) -> None:
        """Check that there is room for *count* more statements.

        Raises:
            RefusedError: There is none.
        """
        if count + len(self._by_name) > MAX_STATEMENTS:
            raise RefusedError("a statement", f"there are {MAX_STATEMENTS:,} already; take some back")

    def adopt(self, device_id: str, sources: Collection[SourceRecord]) -> None:
        """Record the id under which a device appears, so that its statements stay with its announcements.

        Statements about the device from which it was split off now apply to each separately.
        """
        keys = [source.key for source in sources]
        for statement in self._statements(keys):
            own: dict[_Name, None] = dict.fromkeys(key for key in keys if key in statement.names)
            if device_id not in statement.names and len(own) < len(statement.announcements()) and self._has_room():
                for key in own:
                    del statement.names[key]
                self._put(_Statement(statement.facts, {**own, device_id: None}))
                self.is_unsaved = True
        for source in sources:
            names = tuple(_names(device_id, (source,)))
            configured = next((name for name in names if name in self._configured), "")
            if configured and self._known_as.get(source.key) != configured and self._has_room():
                self._known_as[source.key] = configured
                self.is_unsaved = True
            for stated in self._statements(names):
                self._add_key(stated, source.key)

    def inherit(self, sibling: SourceKey, key: SourceKey) -> None:
        """Copy the statements about *sibling*, an announcement of the same device, to *key*."""
        if sibling in self._by_name:
            self._add_key(self._by_name[sibling], key)
        if sibling in self._known_as and key not in self._known_as and self._has_room():
            self._known_as[key] = self._known_as[sibling]
            self.is_unsaved = True

    def record(self) -> str:
        """Return everything except the configuration as text, for the index file."""
        record = PlacesRecord.model_construct(
            statements=tuple(
                StatementRecord.model_construct(
                    facts=statement.facts,
                    announcements=tuple(statement.announcements()),
                    names=tuple(name for name in statement.names if isinstance(name, str)),
                )
                for statement in self._statements(self._by_name)
            ),
            rooms=self.rooms.imported,
            doors=self.rooms.imported_doors,
            known_as=tuple((*key, name) for key, name in self._known_as.items()),
            approvals=tuple(self.approvals.records()),
        )
        return json.dumps(record.model_dump())  # unlike pydantic, it accepts lone surrogates

    def restore(self, record: str) -> None:
        """Restore the records that :meth:`record` returned.

        Raises:
            WireError: It is invalid, or some of its rooms contradict the configuration; these stay in the
                record, but are left out of the plan.
        """
        read = read_places_record(record)
        for statement in read.statements:
            if self._has_room():
                self._put(_Statement(statement.facts, dict.fromkeys((*statement.announcements, *statement.names))))
        self._known_as = {(gateway, key): name for gateway, key, name in read.known_as[:MAX_STATEMENTS]}
        self.approvals.restore(read.approvals)
        self.is_empty = self.is_empty and not self.approvals
        try:
            self.rooms.restore(read.rooms, "the index file", read.doors)
        except ConfigError as exc:
            raise WireError(f"rooms that do not fit: {exc}", record[:100].encode(errors="replace")) from exc

    def _configured_of(self, device_id: str, sources: Iterable[SourceRecord]) -> _Facts:
        names = dict.fromkeys(_names(device_id, sources))
        names |= dict.fromkeys(self._known_as[source.key] for source in sources if source.key in self._known_as)
        return tuple(fact for name in names for fact in self._configured.get(name, ()))

    def _put(self, statement: _Statement) -> None:
        self._by_name.update(dict.fromkeys(statement.names, statement))
        self.is_empty = False

    def _add_key(self, statement: _Statement, key: SourceKey) -> None:
        if key not in self._by_name and self._has_room():
            statement.names[key] = None
            self._by_name[key] = statement
            self.is_unsaved = True

    def _has_room(self) -> bool:
        return len(self._by_name) + len(self._known_as) < MAX_STATEMENTS


def _configured(places: Places, read_at: float) -> dict[str, _Facts]:
    """Return the facts in *places*, by id or hardware address."""
    return {
        name: tuple(fact._replace(said_at=read_at) for fact in facts)
        for names, facts in places.devices.items()
        for name in names
    }


def _is_room(fact: OwnerFact, room: str) -> bool:
    return fact.name == "area" and fold(fact.value) == fold(room)


def _names(device_id: str, sources: Iterable[SourceRecord]) -> Iterator[str]:
    yield device_id
    for source in sources:
        yield from source.sighting.identifiers


_ORDER: Sequence[str] = get_args(FactName)
_SINGLE = frozenset({"area", "position", "taught_area", "taught_position"})


def _rank(fact: OwnerFact) -> tuple[bool, float]:
    return fact.source == "import", -fact.said_at


def _once(facts: Iterable[OwnerFact]) -> _Facts:
    """Return the first room, the first position, and each alias and tag once, in this order."""
    owner_facts: dict[tuple[str, str], OwnerFact] = {}
    for fact in facts:
        owner_facts.setdefault((fact.name, "" if fact.name in _SINGLE else fold(fact.value)), fact)
    return tuple(sorted(owner_facts.values(), key=lambda fact: _ORDER.index(fact.name)))
