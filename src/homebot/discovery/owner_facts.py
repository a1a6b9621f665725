"""Facts that the owner states of devices: rooms, aliases and tags, which outrank what devices announce. Pure.

A statement by a command or an import belongs to the announcements that the device had at the time, so that each keeps
it when devices are merged and split. It is also kept by device id, for a device whose announcements are new, and by
hardware address where a places file gives one. The configuration names devices by id or hardware address; which id the
device of an announcement had is remembered, so that it is found after a merge.

Of two statements on one fact a command outranks an import, an import the configuration, and a later one an earlier one.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TypeAlias, final

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.config import UNNAMED
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.errors import ConfigError, RefusedError, WireError
from homebot.folding import fold
from homebot.places import HousePlan, HouseRoom, OwnerFact, Places

__all__ = ["MAX_STATEMENTS", "OwnerFacts"]

MAX_STATEMENTS = 100_000
"""Announcements, ids and hardware addresses of which something is stated; further ones are refused."""

_Facts: TypeAlias = tuple[OwnerFact, ...]
_NONE: _Facts = ()


class _StatementRecord(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    facts: tuple[OwnerFact, ...]
    announcements: tuple[tuple[str, str], ...] = ()
    names: tuple[str, ...] = ()


class _PlacesRecord(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    statements: tuple[_StatementRecord, ...] = ()
    rooms: tuple[HouseRoom, ...] = ()
    known_as: tuple[tuple[str, str, str], ...] = ()


@final
class OwnerFacts:
    """The rooms of the house, and the facts that the owner states of devices.

    Args:
        home: The name of the home.
        places: The table ``[places]`` of the configuration.
        read_at: When that was read, in seconds since the Unix epoch.

    Attributes:
        plan: The rooms of the configuration and those that were imported.
        is_unsaved: Whether something was stated that is not in the index file.
    """

    __slots__ = ("_by_key", "_by_name", "_configured", "_imported", "_known_as", "is_unsaved", "plan")

    def __init__(self, home: str = UNNAMED, places: Places | None = None, read_at: float = 0.0) -> None:
        given = places or Places()
        self.plan = HousePlan(home, given.rooms)
        self.is_unsaved = False
        self._configured = {
            name: tuple(replace(fact, said_at=read_at) for fact in facts)
            for names, facts in given.devices.items()
            for name in names
        }
        self._imported: tuple[HouseRoom, ...] = ()
        self._by_key: dict[SourceKey, _Facts] = {}
        self._by_name: dict[str, _Facts] = {}
        self._known_as: dict[SourceKey, str] = {}

    def of(self, device_id: str, sources: Collection[SourceRecord]) -> _Facts:
        """Return the facts of a device, each once: its room, its aliases, those that are shown first first, its tags.

        Args:
            device_id: Its id.
            sources: Its announcements.
        """
        if not (self._configured or self._by_key or self._by_name):
            return _NONE
        stated = self.stated(device_id, sources)
        found = (*stated, *self._configured_of(device_id, sources)) if self._configured else stated
        return _once(found) if found else _NONE

    def stated(self, device_id: str, sources: Collection[SourceRecord]) -> _Facts:
        """Return the facts that commands and imports stated of a device: those of commands first, later ones first."""
        by_key = self._by_key
        found = list(dict.fromkeys(by_key[source.key] for source in sources if source.key in by_key))
        if not found:
            found = [self._by_name[name] for name in _names(device_id, sources) if name in self._by_name]
        if not found:
            return _NONE
        return _once(sorted((fact for facts in found for fact in facts), key=_rank))

    def known_as(self, key: SourceKey) -> str:
        """Return the name by which the configuration states something of an announcement; empty for none."""
        return self._known_as.get(key, "")

    def put(self, device_id: str, sources: Collection[SourceRecord], facts: Iterable[OwnerFact]) -> None:
        """Replace what commands and imports stated of a device.

        Args:
            device_id: Its id.
            sources: Its announcements.
            facts: The facts; none to take all back.

        Raises:
            RefusedError: There are too many statements.
        """
        stated = tuple(facts)
        keys = [source.key for source in sources]
        new = sum(key not in self._by_key for key in keys) + (device_id not in self._by_name)
        if stated:
            self.check_room(new)
        replaced = {id(self._by_key[key]) for key in keys if key in self._by_key}
        replaced |= {id(self._by_name[name]) for name in _names(device_id, sources) if name in self._by_name}
        for key in keys:
            self._by_key.pop(key, None)
        replaced -= {id(one) for one in self._by_key.values()}  # what others were split off with stays theirs
        self._by_name = {name: one for name, one in self._by_name.items() if id(one) not in replaced}
        self._by_name.pop(device_id, None)
        if stated:
            self._by_name[device_id] = stated
            self._by_key.update(dict.fromkeys(keys, stated))
        self.is_unsaved = True

    def put_unknown(self, names: Iterable[str], facts: Iterable[OwnerFact]) -> None:
        """Keep *facts* of a device that is not there yet.

        Args:
            names: The id, or the hardware addresses, that it will have.
            facts: The facts.

        Raises:
            RefusedError: There are too many statements.
        """
        stated, known_by = tuple(facts), tuple(names)
        self.check_room(sum(name not in self._by_name for name in known_by))
        self._by_name.update(dict.fromkeys(known_by, stated))
        self.is_unsaved = True

    def unknown(self, known: Collection[str]) -> Iterator[tuple[str, _Facts]]:
        """Yield each name of which something is stated that is not among the *known* ids and hardware addresses."""
        for name in dict.fromkeys((*self._by_name, *self._configured)):
            if name not in known:
                yield name, _once((*self._by_name.get(name, ()), *self._configured.get(name, ())))

    def stated_of(self, name: str) -> _Facts:
        """Return the facts that an import stated of a device that is not there yet."""
        return self._by_name.get(name, _NONE)

    def import_rooms(self, rooms: Iterable[HouseRoom], source: str) -> None:
        """Add *rooms* to the plan.

        Raises:
            ConfigError: They do not fit the plan; nothing was added.
        """
        added = tuple(rooms)
        self.plan = self.plan.with_rooms(added, source)
        self._imported = HousePlan(self.plan.home, (*self._imported, *added), source).rooms
        self.is_unsaved = True

    def check_room(self, count: int) -> None:
        """Check that there is room for *count* more statements.

        Raises:
            RefusedError: There is not.
        """
        if count + len(self._by_key) + len(self._by_name) > MAX_STATEMENTS:
            raise RefusedError("a statement", f"there are {MAX_STATEMENTS:,} already; take some back")

    def adopt(self, device_id: str, sources: Iterable[SourceRecord]) -> None:
        """Note under which id a device appears, so that what is stated of it stays with its announcements."""
        if not (self._configured or self._by_name):
            return
        for source in sources:
            names = _names(device_id, (source,))
            configured = next((name for name in names if name in self._configured), "")
            if configured and self._known_as.get(source.key) != configured and self._has_room():
                self._known_as[source.key] = configured
                self.is_unsaved = True
            if source.key not in self._by_key and self._has_room():
                stated = next((self._by_name[name] for name in names if name in self._by_name), _NONE)
                if stated:
                    self._by_key[source.key] = stated
                    self.is_unsaved = True

    def inherit(self, sibling: SourceKey, key: SourceKey) -> None:
        """Give the announcement *key* what is stated of *sibling*, which is of the same device."""
        if sibling in self._by_key and key not in self._by_key and self._has_room():
            self._by_key[key] = self._by_key[sibling]
            self.is_unsaved = True
        if sibling in self._known_as and key not in self._known_as and self._has_room():
            self._known_as[key] = self._known_as[sibling]
            self.is_unsaved = True

    def record(self) -> str:
        """Return all but the configuration as text, for the index file."""
        keys: dict[int, list[SourceKey]] = {}
        names: dict[int, list[str]] = {}
        statements: dict[int, _Facts] = {}
        for key, facts in self._by_key.items():
            keys.setdefault(id(facts), []).append(key)
            statements[id(facts)] = facts
        for name, facts in self._by_name.items():
            names.setdefault(id(facts), []).append(name)
            statements[id(facts)] = facts
        record = {
            "statements": [
                {
                    "facts": [
                        {"name": one.name, "value": one.value, "source": one.source, "said_at": one.said_at}
                        for one in facts
                    ],
                    "announcements": keys.get(number, []),
                    "names": names.get(number, []),
                }
                for number, facts in statements.items()
            ],
            "rooms": [{"name": one.name, "floor": one.floor, "doors": one.doors} for one in self._imported],
            "known_as": [[*key, name] for key, name in self._known_as.items()],
        }
        return json.dumps(record)

    def restore(self, record: str) -> None:
        """Take over what :meth:`record` returned.

        Raises:
            WireError: It is no such text, or some of its rooms do not fit the configuration any more; these stay in the
                record and out of the plan.
        """
        try:
            read = _PlacesRecord.model_validate_json(record)
        except ValidationError as exc:
            raise WireError(f"no places: {exc.errors()[0]['msg']}", record[:100].encode(errors="replace")) from exc
        for statement in read.statements:
            if len(self._by_key) + len(self._by_name) < MAX_STATEMENTS:
                self._by_key.update(dict.fromkeys(statement.announcements, statement.facts))
                self._by_name.update(dict.fromkeys(statement.names, statement.facts))
        self._known_as = {(gateway, key): name for gateway, key, name in read.known_as[:MAX_STATEMENTS]}
        self._imported = read.rooms
        problem: ConfigError | None = None
        try:
            self.plan = self.plan.with_rooms(read.rooms, "the index file")
        except ConfigError:
            for room in read.rooms:
                try:
                    self.plan = self.plan.with_rooms((room,), "the index file")
                except ConfigError as exc:
                    problem = exc
        if problem is not None:
            raise WireError(f"rooms that do not fit: {problem}", record[:100].encode(errors="replace")) from problem

    def _configured_of(self, device_id: str, sources: Iterable[SourceRecord]) -> _Facts:
        names = dict.fromkeys(_names(device_id, sources))
        names |= dict.fromkeys(self._known_as[source.key] for source in sources if source.key in self._known_as)
        return tuple(fact for name in names for fact in self._configured.get(name, ()))

    def _has_room(self) -> bool:
        return len(self._by_key) + len(self._by_name) + len(self._known_as) < MAX_STATEMENTS


def _names(device_id: str, sources: Iterable[SourceRecord]) -> Iterator[str]:
    yield device_id
    for source in sources:
        yield from source.sighting.identifiers


_ORDER: Mapping[str, int] = {"area": 0, "name": 1, "tag": 2}


def _rank(fact: OwnerFact) -> tuple[bool, float]:
    return fact.source == "import", -fact.said_at


def _once(facts: Iterable[OwnerFact]) -> _Facts:
    """Return the first room, and each alias and tag once, in this order of kinds."""
    found: dict[tuple[str, str], OwnerFact] = {}
    for fact in facts:
        found.setdefault((fact.name, "" if fact.name == "area" else fold(fact.value)), fact)
    return tuple(sorted(found.values(), key=lambda fact: _ORDER[fact.name]))
