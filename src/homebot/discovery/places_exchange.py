"""Export and import of what the owner states, as the text of a places file. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import final

from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.places_editor import PlacesEditor
from homebot.errors import ConfigError
from homebot.folding import fold
from homebot.places import OwnerFact, Places, places_text, read_places
from homebot.toml_file import parse_toml

__all__ = ["Imported", "PlacesExchange"]

_SOURCE = "the places file"


@dataclass(frozen=True, slots=True)
class Imported:
    """The result of an import.

    Attributes:
        added: Rooms, and devices of which something is new, as text.
        kept: Rooms of devices that were stated before and are others in the file, as text.
    """

    added: tuple[str, ...]
    kept: tuple[str, ...]


@final
class PlacesExchange:
    """Writes and reads places files.

    Args:
        table: The devices.
        editor: States what a file states.
    """

    __slots__ = ("_editor", "_table")

    def __init__(self, table: DeviceTable, editor: PlacesEditor) -> None:
        self._table = table
        self._editor = editor

    def export_text(self) -> str:
        """Return all rooms, and all that the owner states of devices, as the text of a places file."""
        owner = self._table.owner
        devices: list[tuple[str, tuple[OwnerFact, ...], tuple[str, ...]]] = []
        known: set[str] = set()
        for entry in self._table.entries.values():
            sources = entry.sources.values()
            known.add(entry.id)
            known.update(one for source in sources for one in source.sighting.identifiers)
            known.update(owner.known_as(key) for key in entry.sources)
            if facts := owner.of(entry.id, sources):
                devices.append((entry.id, facts, entry.hardware()))
        devices += [(name, facts, ()) for name, facts in owner.unknown(known)]
        return places_text(owner.plan.home, owner.plan.rooms, sorted(devices, key=lambda one: one[0]))

    def import_text(self, text: str, now: float, *, replaces: bool = False) -> Imported:
        """Take over the text of a places file: all of it or, with a mistake in it, nothing.

        It adds rooms, aliases and tags. The room of a device that was stated here before stays.

        Args:
            text: The text.
            now: Seconds since the Unix epoch.
            replaces: Whether the file's room of a device wins over one that was stated here before.

        Raises:
            ConfigError: The first mistake; names the key and the value.
            RefusedError: There are too many statements; nothing was taken over.
        """
        owner = self._table.owner
        read = read_places(_places_table(text), owner.plan.home, _SOURCE, "import", now)
        by_identifier = self._by_identifier()
        entries = {names: self._known_by(names, by_identifier) for names in read.devices}
        owner.check_room(_count(read, entries))
        added = [f"room {room.name}" for room in read.rooms if owner.plan.room(room.name) is None]
        before = owner.plan.rooms
        if read.rooms:
            owner.import_rooms(read.rooms, _SOURCE)
        kept: list[str] = []
        for names, facts in read.devices.items():
            for entry in entries[names]:
                stated = self._editor.stated(entry)
                in_use = owner.of(entry.id, entry.sources.values())
                merged = _merge(entry.id, stated, facts, in_use, kept, replaces=replaces)
                if merged != stated:
                    self._editor.state(entry, merged, "a places file was imported")
                    added.append(entry.id)
            if not entries[names]:
                stated = owner.stated_of(names[0])
                merged = _merge(names[0], stated, facts, stated, kept, replaces=replaces)
                if merged != stated:
                    owner.put_unknown(names, merged)
                    added.append(f"{names[0]}, which is not there yet")
        if owner.plan.rooms != before:
            self._editor.restate(tuple(self._table.entries.values()), "the rooms of the house changed")
        return Imported(tuple(added), tuple(kept))

    def _by_identifier(self) -> dict[str, list[Entry]]:
        found: dict[str, list[Entry]] = {}
        for key, source in self._table.sources.items():
            for identifier in source.sighting.identifiers:
                found.setdefault(identifier, []).append(self._table.owners[key])
        return found

    def _known_by(self, names: tuple[str, ...], by_identifier: Mapping[str, list[Entry]]) -> tuple[Entry, ...]:
        """Return the device of that id, or those with one of these hardware addresses."""
        entries = self._table.entries
        if names[0] in entries:
            return (entries[names[0]],)
        return tuple(dict.fromkeys(entry for name in names for entry in by_identifier.get(name, ())))


def _places_table(text: str) -> Mapping[str, object]:
    tables = parse_toml(text, _SOURCE)
    for name in tables:
        if name != "places":
            raise ConfigError(_SOURCE, name, "unknown key; known is places")
    places = tables.get("places", {})
    if not isinstance(places, dict):
        raise ConfigError(_SOURCE, "places", f"must be a table, got {places!r}")
    return places


def _count(read: Places, entries: Mapping[tuple[str, ...], tuple[Entry, ...]]) -> int:
    return sum(max(len(names), 1 + sum(len(one.sources) for one in entries[names])) for names in read.devices)


def _merge(
    device: str,
    stated: tuple[OwnerFact, ...],
    new: Iterable[OwnerFact],
    in_use: tuple[OwnerFact, ...],
    kept: list[str],
    *,
    replaces: bool,
) -> tuple[OwnerFact, ...]:
    """Return what commands and imports state of a device after an import.

    Args:
        device: The device, for messages.
        stated: What they stated before.
        new: The facts of the file.
        in_use: All that is stated of it, in the configuration too.
        kept: Is given the room that was kept, as text.
        replaces: Whether the room of the file wins.
    """
    known = {(fact.name, fold(fact.value)) for fact in in_use}
    room = next((fact.value for fact in in_use if fact.name == "area"), "")
    found = list(stated)
    for fact in new:
        if (fact.name, fold(fact.value)) in known:
            continue
        if fact.name == "area" and room:
            if not replaces:
                kept.append(f"{device} stays in {room}; the file says {fact.value}")
                continue
            found = [one for one in found if one.name != "area"]
        found.append(fact)
    return tuple(found)
