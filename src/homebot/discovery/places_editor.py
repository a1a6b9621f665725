"""The editor of the owner's statements about devices at run time: rooms, aliases, tags and approvals. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Final, final

from homebot.devices.query.terms import AreaIs
from homebot.discovery.approvals import approval_digest
from homebot.discovery.description import position_of
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.ids import id_of_name
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.errors import RefusedError, UsageError
from homebot.places import FactName, OwnerFact, check_name, stated_position
from homebot.places.facts import TAG_ERROR
from homebot.support.folding import fold, is_room_typo

_MAX_NAMES = 50
"""Most aliases, and most tags, of a device."""

_WORDS: Mapping[FactName, str] = {
    "area": "room",
    "position": "position",
    "name": "alias",
    "tag": "tag",
    "taught_area": "room",
    "taught_position": "position",
}


_WHERE: Final = ("area", "position")
_TAUGHT: Final = ("taught_area", "taught_position")


@final
class PlacesEditor:
    """Applies the owner's statements to the devices.

    Its methods raise RefusedError for an unknown device or too many statements, and UsageError for a name or position
    that is invalid or probably a typo. Times are in seconds since the Unix epoch.
    """

    def __init__(self, table: DeviceTable) -> None:
        self._table = table

    def has(self, device_id: str) -> bool:
        """Return whether there is a device with that id."""
        return device_id in self._table.entries

    def place(
        self, device: str, room: str, now: float, *, at: str = "", is_new: bool = False, may_be_absent: bool = False
    ) -> str:
        """Set the room or position of a device, or both; return its resulting room.

        Args:
            device: Its id; for a device that does not exist yet, the result of :meth:`future_name`.
            room: The room, or a floor; empty for none.
            at: The position as text; empty for none.
            is_new: Whether the room may be new although its name is one typo away from another.
            may_be_absent: Whether the device need not exist yet.
        """
        entry = self._find(device, may_be_absent=may_be_absent)
        facts = self._where(device, room, at, now, is_new=is_new)
        replaced = {fact.name for fact in facts}
        others = [fact for fact in self._stated(device, entry) if fact.name not in replaced]
        where = " at ".join(fact.value for fact in facts)
        return self._place(device, entry, [*facts, *others], f"the owner placed it {'in' if room else 'at'} {where}")

    def unplace(self, device: str, *, may_be_absent: bool = False) -> str:
        """Withdraw the room and position stated by a command or import or taught by a tag; return the resulting room.

        Raises:
            RefusedError: There is no such device, or no room was stated or taught.
        """
        entry = self._find(device, may_be_absent=may_be_absent)
        stated = self._stated(device, entry)
        for names in (_WHERE, _TAUGHT):
            facts = [fact for fact in stated if fact.name not in names]
            if len(facts) < len(stated):
                return self._place(device, entry, facts, "the owner took back its room")
        reason = f"there is no device {device}, and no command stated its room"
        if entry is not None:
            reason = self._where_configured("area", entry) or f"no command stated the room of {device}"
        raise RefusedError("taking back the room", reason)

    def future_name(self, device: str) -> str:
        """Return the id that *device* has or will have by its name; a hardware address is returned unchanged."""
        name = device if self.has(device) else check_name(device)
        return name if self.has(name) or ":" in name or "/" in name else id_of_name(name)

    def absent(self) -> Iterator[tuple[str, str]]:
        """Yield the id or hardware address, and the stated room, of each device that does not exist."""
        known: set[SourceKey | str] = {*self._table.entries, *self._table.sources}
        known.update(
            identifier for source in self._table.sources.values() for identifier in source.sighting.identifiers
        )
        known.update(self._table.owner.known_as(key) for key in self._table.sources)
        for names, facts in self._table.owner.unknown(known):
            yield from ((names[0], fact.value) for fact in facts if fact.name == "area")

    def teach(self, device_id: str, gateway: str, tag: str, room: str, now: float, *, at: str = "") -> tuple[str, bool]:
        """Learn the place of a device from a tag attached to it; it counts if neither owner nor device state one.

        It is the place of the tag, as far as known.

        Args:
            room: The room written on the tag; the known room of the tag outranks it.
            at: The position at which a robot saw the device, instead of a tag; empty for none.

        Returns:
            The resulting room of the device, and whether the place learnt from the tag is new.
        """
        entry, stated = self._entry(device_id), self.stated(self._entry(device_id))
        if at:
            facts = [OwnerFact("taught_position", stated_position(at, self._table.owner.plan), gateway, now)]
        else:
            facts = self._taught(entry, gateway, tag, room, now)
        before = {(fact.name, fact.value) for fact in stated if fact.name in _TAUGHT}
        is_new = before != {(fact.name, fact.value) for fact in facts}
        if is_new:
            others = [fact for fact in stated if fact.name not in _TAUGHT]
            where = " at ".join(fact.value for fact in reversed(facts))
            why = f"a robot saw it at {where}" if at else f"a tag says that it is in {where}"
            self.state(entry, [*others, *facts], why)
        return entry.to_device(self._table.topics).area, is_new

    def _taught(self, entry: Entry, gateway: str, tag: str, room: str, now: float) -> list[OwnerFact]:
        """Return the position and the room according to a tag at a device; at least one of them."""
        source = f"{gateway}/{tag or 'code'}"
        facts: list[OwnerFact] = []
        area = ""
        at = self._table.owners.get((gateway, tag))
        if at is not None and at is not entry:
            place = at.to_device(self._table.topics)
            area, position = place.area, position_of(place.facts)
            if position is not None:
                position = position._replace(error=max(position.error, TAG_ERROR))
                facts.append(OwnerFact("taught_position", position.text, source, now))
        if not facts or room or area:
            name = self._spell(check_name(area or room), entry.id)
            self._check_typo(name)
            facts.append(OwnerFact("taught_area", name, source, now))
        return facts

    def add(self, device_id: str, name: FactName, value: str, now: float) -> tuple[str, ...]:
        """Add an alias or a tag to a device; return all that it has."""
        entry = self._entry(device_id)
        added = check_name(value)
        others = [fact for fact in self.stated(entry) if (fact.name, fold(fact.value)) != (name, fold(added))]
        if sum(fact.name == name for fact in others) >= _MAX_NAMES:
            raise RefusedError(f"the {_WORDS[name]} {added!r}", f"{device_id} has {_MAX_NAMES} already")
        fact = OwnerFact(name, added, "command", now)
        self.state(entry, [fact, *others], f"the owner gave it the {_WORDS[name]} {added}")
        return self._values(entry, name)

    def withdraw(self, device_id: str, name: FactName, value: str) -> tuple[str, ...]:
        """Withdraw an alias or a tag stated by a command or import; return those that remain.

        Raises:
            RefusedError: There is no such device, or neither a command nor an import stated it.
        """
        entry = self._entry(device_id)
        stated = self.stated(entry)
        facts = [fact for fact in stated if (fact.name, fold(fact.value)) != (name, fold(value))]
        if len(facts) == len(stated):
            where = self._where_configured(name, entry, value)
            has = ", ".join(self._values(entry, name)) or "none"
            why = where or f"no command gave it to {device_id}, which has {has}"
            raise RefusedError(f"taking back the {_WORDS[name]} {value!r}", why)
        self.state(entry, facts, f"the owner took back its {_WORDS[name]} {value}")
        return self._values(entry, name)

    def approval_digest(self, device_id: str) -> str:
        """Return the digest to which an approval of a device would be bound now."""
        return approval_digest(self._entry(device_id).sources.values())

    def check_shown(self, device_id: str, digest: str) -> None:
        """Check that *digest* is still the :meth:`approval_digest` of a device.

        Raises:
            RefusedError: It is not, or there is no such device.
        """
        if digest != self.approval_digest(device_id):
            raise RefusedError(f"the approval of {device_id}", "it changed since it was shown; look at it again")

    def approve(self, device_id: str, now: float, digest: str = "") -> tuple[str, ...]:
        """Approve the announcements of a device as they are, so that it may be commanded. Idempotent.

        Args:
            digest: The :meth:`approval_digest` shown to the owner; empty for any.

        Returns:
            Differences from earlier approvals, one line for each part of an announcement.

        Raises:
            RefusedError: There is no such device, it has changed since it was shown, or there are too many approvals.
        """
        entry = self._entry(device_id)
        if digest:
            self.check_shown(device_id, digest)
        owner = self._table.owner
        changes = owner.approvals.put(entry.sources.values(), now, self._table.sources)
        owner.is_unsaved, owner.is_empty = True, False
        self.restate((entry,), "the owner approved it")
        return changes

    def disapprove(self, device_id: str) -> None:
        """Withdraw the approval of a device, if it has one."""
        entry = self._entry(device_id)
        if self._table.owner.approvals.discard(entry.sources.values(), self._table.sources):
            self._table.owner.is_unsaved = True
            self.restate((entry,), "the owner took back the approval")

    def commands(self, device_id: str) -> dict[SourceKey, tuple[str, ...]]:
        """Return a line for each part of a device that takes commands, by announcement: the commands and addresses."""
        return {key: _announced_commands(source) for key, source in self._entry(device_id).sources.items()}

    def stated(self, entry: Entry) -> tuple[OwnerFact, ...]:
        """Return the facts that commands and imports state about a device."""
        return self._table.owner.stated(entry.id, entry.sources.values())

    def state(self, entry: Entry, facts: Iterable[OwnerFact], why: str) -> None:
        """Store *facts* as the statements of commands and imports about a device, for the reason *why*."""
        self._table.owner.put(entry.id, entry.sources.values(), facts, self._table.owners)
        self.restate((entry,), why)

    def restate(self, entries: Iterable[Entry], why: str) -> None:
        """Update the descriptions of *entries* after statements of the owner, for the reason *why*."""
        for entry in entries:
            entry.invalidate_description()
            self._table.record_change("changed", entry, why)

    def _find(self, device: str, *, may_be_absent: bool) -> Entry | None:
        return None if may_be_absent and not self.has(device) else self._entry(device)

    def _stated(self, device: str, entry: Entry | None) -> tuple[OwnerFact, ...]:
        return self._table.owner.stated_of((device,)) if entry is None else self.stated(entry)

    def _place(self, device: str, entry: Entry | None, facts: list[OwnerFact], why: str) -> str:
        """State *facts* about a device; return its room."""
        if entry is None:
            self._table.owner.put_unknown((device,), facts, self._table.owners)
            return next((fact.value for fact in facts if fact.name == "area"), "")
        self.state(entry, facts, why)
        return entry.to_device(self._table.topics).area

    def _where(self, device: str, room: str, at: str, now: float, *, is_new: bool) -> list[OwnerFact]:
        facts = []
        if room or not at:
            name = self._spell(check_name(room), device)
            if not is_new:
                self._check_typo(name)
            facts.append(OwnerFact("area", name, "command", now))
        if at:
            facts.append(OwnerFact("position", stated_position(at, self._table.owner.plan), "command", now))
        return facts

    def _values(self, entry: Entry, name: FactName) -> tuple[str, ...]:
        facts = self._table.owner.of(entry.id, entry.sources.values())
        return tuple(fact.value for fact in facts if fact.name == name)

    def _where_configured(self, name: FactName, entry: Entry, value: str = "") -> str:
        """Return a hint that the configuration states such a fact; empty if it does not."""
        for fact in self._table.owner.of(entry.id, entry.sources.values()):
            if fact.name == name and fact.source == "configuration" and fold(value) in {"", fold(fact.value)}:
                return f"{fact.value!r} is stated in the configuration; change [places] there"
        return ""

    def _spell(self, room: str, device_id: str) -> str:
        """Return *room* as the plan or the other devices in it spell it."""
        name, _ = self._table.owner.plan.locate(room)
        others = sorted(self._table.postings.find(AreaIs(fold(name))) - {device_id})
        areas = (self._table.entries[other].to_device(self._table.topics).area for other in others)
        return next((area for area in areas if fold(area) == fold(name)), name)

    def _check_typo(self, room: str) -> None:
        plan = self._table.owner.plan
        known = {
            *map(fold, (*(plan_room.name for plan_room in plan.rooms), *plan.floors)),
            *self._table.postings.values_of("area"),
        }
        spelled = fold(room)
        meant = sorted(self._spell(name, "") for name in known if is_room_typo(spelled, name))
        if meant and spelled not in known:
            raise UsageError(f"there is no room {room!r}; did you mean {' or '.join(meant)}?")

    def _entry(self, device_id: str) -> Entry:
        entry = self._table.entries.get(device_id)
        if entry is None:
            raise RefusedError(f"a statement on {device_id!r}", "there is no device of that id")
        return entry


def _announced_commands(source: SourceRecord) -> tuple[str, ...]:
    lines = []
    for part in source.sighting.parts:
        if settings := [capability.name for capability in part.capabilities if capability.settable]:
            where = f" to {', '.join(part.writes)}" if part.writes else ""
            lines.append(f"{part.name or part.id or source.sighting.name}: {', '.join(settings)}{where}")
    return tuple(lines)
