"""Export and import of the owner's statements, as the text of a places file. Pure."""

from collections.abc import Generator, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import final

from homebot.discovery.description import position_of
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.house_rooms import HouseRooms
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.places_editor import PlacesEditor
from homebot.discovery.source_record import SourceKey
from homebot.errors import ConfigError
from homebot.places import HousePlan, HouseRoom, OwnerFact, Places, check_name, places_text, read_places
from homebot.places.geojson import geojson_table
from homebot.support.folding import fold
from homebot.support.toml_file import parse_toml

SOURCE = "the places file"


@dataclass(frozen=True, slots=True)
class Imported:
    """The result of an import.

    Attributes:
        added: Rooms and devices with new facts, in words.
        kept: Rooms and positions stated earlier that the file contradicts, in words.
    """

    added: tuple[str, ...]
    kept: tuple[str, ...]


@final
class PlacesExchange:
    """The export and import of places files. Times are in seconds since the Unix epoch."""

    def __init__(self, table: DeviceTable, editor: PlacesEditor) -> None:
        self._table = table
        self._editor = editor

    def export_text(self) -> Generator[None, None, str]:
        """Return all rooms and the owner's statements about devices as the text of a places file.

        It omits approvals, which would approve unseen devices in another house, and rooms learnt from tags.

        Others may have their turn at each step.
        """
        owner = self._table.owner
        devices: list[tuple[str, tuple[OwnerFact, ...], tuple[str, ...]]] = []
        known: set[SourceKey | str] = set()
        for entry in tuple(self._table.entries.values()):
            yield
            sources = entry.sources.values()
            known.update((entry.id, *entry.sources))
            known.update(identifier for source in sources for identifier in source.sighting.identifiers)
            known.update(owner.known_as(key) for key in entry.sources)
            if facts := _export(owner.of(entry.id, sources)):
                devices.append((entry.id, facts, entry.hardware()))
        unknown = ((names, _export(facts)) for names, facts in owner.unknown(known))
        devices += [(names[0], facts, tuple(names[1:])) for names, facts in unknown if facts]
        return places_text(owner.plan, sorted(devices, key=lambda device: device[0]))

    def parse(self, text: str, now: float) -> Places:
        """Return the content of a places file for this house; see :func:`parse_places`."""
        plan = self._table.owner.plan
        return parse_places(text, plan.home, now, plan.rooms)

    def apply(self, places: Places, *, replaces: bool = False) -> Generator[None, None, Imported]:
        """Apply the content of a places file, all or nothing.

        It adds rooms, aliases and tags. A room stated for a device earlier stays. Other tasks may run at each step.

        Raises:
            ConfigError: Its rooms contradict those of the house; the message names key and value.
            RefusedError: There are too many statements.
        """
        owner = self._table.owner
        by_identifier = yield from self._by_identifier(frozenset(name for names in places.devices for name in names))
        owner.check_room(sum(self._count(names, by_identifier) for names in places.devices))
        before = owner.plan
        if places.rooms or places.doors:
            owner.import_rooms(places.rooms, SOURCE, places.doors)
        doors = [f"door {door.name}" for door in places.doors if door not in before.doors]
        added = doors + [
            f"room {room.name}" for room in places.rooms if before.room(room.name) != owner.plan.room(room.name)
        ]
        kept: list[str] = []
        for names, facts in places.devices.items():
            yield
            for entry in self._known_by(names, by_identifier) or (None,):
                if self._apply_device(entry, names, facts, kept, replaces=replaces):
                    added.append(entry.id if entry else f"{names[0]}, which is not there yet")
        if owner.plan.rooms != before.rooms:
            yield from self._restate(before, owner.plan)
        return Imported(tuple(added), tuple(kept))

    def reconfigure(self, places: Places, rooms: HouseRooms, now: float) -> Generator[None, None, None]:
        """Replace the statements of the configuration, and update the devices concerned.

        Others may have their turn at each step.
        """
        owner = self._table.owner
        before = {entry: owner.of(entry.id, entry.sources.values()) for entry in tuple(self._table.entries.values())}
        plan, queries = owner.plan, _queries(owner)
        owner.reconfigure(places, rooms, now)
        is_regrouped = queries != _queries(owner)
        for entry, facts in before.items():
            yield
            if self._table.entries.get(entry.id) is entry:
                owner.adopt(entry.id, entry.sources.values())
                if is_regrouped or _values(facts) != _values(owner.of(entry.id, entry.sources.values())):
                    self._editor.restate((entry,), "the configuration was reloaded")
        yield from self._restate(plan, owner.plan)

    def remove_room(self, name: str) -> Generator[None, None, None]:
        """Remove an imported room from the plan, as :class:`OwnerFacts`; other tasks may run at each step."""
        before = self._table.owner.plan
        self._table.owner.remove_room(name)
        yield from self._restate(before, self._table.owner.plan)

    def rename_room(self, name: str, new: str) -> Generator[None, None, str]:
        """Rename a room that was imported, or in which devices were placed; return its name."""
        owner, checked = self._table.owner, check_name(new)
        owner.rename_room(name, checked)
        for entry in tuple(self._table.entries.values()):
            yield
            if fold(checked) in {fold(fact.value) for fact in self._editor.stated(entry) if fact.name == "area"}:
                self._editor.restate((entry,), f"the room {name} was renamed")
        return checked

    def _count(self, names: tuple[str, ...], by_identifier: Mapping[str, list[SourceKey]]) -> int:
        """Return the most statements that a device of the file may need."""
        return max(len(names), sum(1 + len(entry.sources) for entry in self._known_by(names, by_identifier)))

    def _apply_device(
        self,
        entry: Entry | None,
        names: tuple[str, ...],
        facts: tuple[OwnerFact, ...],
        kept: list[str],
        *,
        replaces: bool,
    ) -> bool:
        """Apply the facts of a device, None if it does not exist yet; return whether any is new."""
        owner = self._table.owner
        stated = owner.stated_of(names) if entry is None else self._editor.stated(entry)
        in_use = stated if entry is None else owner.of(entry.id, entry.sources.values())
        device = names[0] if entry is None else entry.id
        known = {(fact.name, fold(fact.value)) for fact in in_use}
        single = {fact.name: fact.value for fact in reversed(in_use) if fact.name in {"area", "position"}}
        remaining = list(stated)
        for fact in facts:
            if (fact.name, fold(fact.value)) in known:
                continue
            if fact.name in single:
                if not replaces:
                    where = "in" if fact.name == "area" else "at"
                    kept.append(f"{device} stays {where} {single[fact.name]}; the file says {fact.value}")
                    continue
                remaining = [other for other in remaining if other.name != fact.name]
            remaining.append(fact)
        merged = tuple(remaining)
        if merged == stated:
            return False
        if entry is None:
            owner.put_unknown(names, merged, self._table.owners)
        else:
            self._editor.state(entry, merged, "a places file was imported")
        return True

    def _restate(self, before: HousePlan, now: HousePlan) -> Iterator[None]:
        for entry in tuple(self._table.entries.values()):
            yield
            device = entry.to_device(self._table.topics)
            has_moved = bool(device.area) and before.locate(device.area) != now.locate(device.area)
            has_moved = has_moved or position_of(device.facts) is not None
            if has_moved and self._table.entries.get(entry.id) is entry:
                self._editor.restate((entry,), "the rooms of the house changed")

    def _by_identifier(self, wanted: frozenset[str]) -> Generator[None, None, dict[str, list[SourceKey]]]:
        """Return the announcements with the identifiers *wanted*."""
        keys: dict[str, list[SourceKey]] = {}
        for key, source in tuple(self._table.sources.items()):
            yield
            for identifier in wanted.intersection(source.sighting.identifiers):
                keys.setdefault(identifier, []).append(key)
        return keys

    def _known_by(self, names: tuple[str, ...], by_identifier: Mapping[str, list[SourceKey]]) -> tuple[Entry, ...]:
        """Return the device with that id, or the devices with one of these hardware addresses."""
        if names[0] in self._table.entries:
            return (self._table.entries[names[0]],)
        owners = self._table.owners
        keys = (key for name in names for key in by_identifier.get(name, ()) if key in owners)
        return tuple(dict.fromkeys(owners[key] for key in keys))


def parse_places(text: str, home: str, now: float, known: Iterable[HouseRoom] = ()) -> Places:
    """Parse a places file, TOML or GeoJSON, whose doors may lead to *known* rooms.

    Raises:
        ConfigError: Describes the first mistake, with its key and value.
    """
    return read_places(_places_table(text, known), home, SOURCE, "import", now, known)


def _queries(owner: OwnerFacts) -> Mapping[str, str]:
    return {} if owner.groups is None else owner.groups.queries


def _values(facts: Iterable[OwnerFact]) -> list[tuple[str, str]]:
    return [(fact.name, fact.value) for fact in facts]


def _export(facts: tuple[OwnerFact, ...]) -> tuple[OwnerFact, ...]:
    return tuple(fact for fact in facts if fact.name in {"area", "position", "name", "tag"})


def _places_table(text: str, known: Iterable[HouseRoom]) -> Mapping[str, object]:
    if text.lstrip().startswith("{"):
        return geojson_table(text, SOURCE, known)
    try:
        tables = parse_toml(text, SOURCE)
    except ConfigError as exc:
        raise ConfigError(SOURCE, exc.key, f"{exc.reason}; GeoJSON would begin with {{") from exc
    for name in tables:
        if name != "places":
            raise ConfigError(SOURCE, name, "unknown key; known is places")
    places = tables.get("places", {})
    if not isinstance(places, dict):
        raise ConfigError(SOURCE, "places", f"must be a table, got {places!r}")
    return places
