"""A query in words for a house whose devices come and go. Pure."""

from collections.abc import Iterable
from typing import final

from homebot.devices.device import Device
from homebot.devices.device_names import names_of
from homebot.devices.query.facets import shared_facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import AreaIs, InArea, NameIs, PartIs, Query, TypeIs, leaves
from homebot.support.folding import fold
from homebot.words.queries import names_in, parse_query


@final
class WordsQuery:
    """The query *text*, in which words that are exactly the name of a known device, part or room mean it.

    Attributes:
        query: What it means by now.

    Raises:
        UsageError: It is not a query.
    """

    def __init__(self, text: str, devices: Iterable[Device] = ()) -> None:
        self.text = text
        self._names = names_in(text)
        self._named: dict[str, Device] = {}
        self._areas: dict[str, tuple[str, ...]] = {}  # those that the text names, by device
        self.query: Query = parse_query(text)
        self._types = [term for term in leaves(self.query) if isinstance(term, TypeIs)]
        self._others: dict[str, Device] = {}  # all that may be of the types
        self._with_parts: set[str] = set()  # those of the named whose parts may be meant
        self._asked_areas = frozenset([term.text for term in leaves(self.query) if isinstance(term, InArea)])
        for device in devices:
            self.record(device)

    def record(self, device: Device, *, is_gone: bool = False) -> bool:
        """Record a new, changed or removed device; return whether the query means something else now."""
        was_named, before = self._named.pop(device.id, None) is not None, self._others.pop(device.id, None)
        self._with_parts.discard(device.id)
        has_part = not is_gone and not self._names.isdisjoint(shared_facets_of(device).named_parts)
        is_named = has_part or (not is_gone and not self._names.isdisjoint(map(fold, names_of(device))))
        if is_named:
            self._named[device.id] = device
        if has_part:
            self._with_parts.add(device.id)
        if self._types and not is_gone:
            self._others[device.id] = device
        is_change = self._record_areas(device, is_gone=is_gone) or was_named or is_named
        if not is_change and not (self._with_parts and self._turns_types(before, None if is_gone else device)):
            return False
        known, self.query = self.query, parse_query(self.text, self._exists)
        return self.query != known

    def _record_areas(self, device: Device, *, is_gone: bool) -> bool:
        """Record the areas of a device; return whether one that the text names is new, or has no device now."""
        areas = (device.area, *device.outer_areas) if self._asked_areas and device.area and not is_gone else ()
        named = tuple([area for area in map(fold, areas) if area in self._asked_areas])
        before = self._areas.pop(device.id, ())
        is_change = any(not self._exists(AreaIs(area)) for area in {*named} ^ {*before})
        if named:
            self._areas[device.id] = named
        return is_change

    def _exists(self, query: Query) -> bool:
        if isinstance(query, AreaIs):
            return any(query.text in areas for areas in self._areas.values())
        if any(fits(query, shared_facets_of(device)) for device in self._named.values()):
            return True
        if not self._with_parts or any(isinstance(term, NameIs | PartIs) for term in leaves(query)):
            return False
        return any(fits(query, shared_facets_of(device)) for device in self._others.values())

    def _turns_types(self, before: Device | None, after: Device | None) -> bool:
        """Return whether a change may decide between a part and the devices of the type that it is called like."""
        was, is_now = [
            device is not None and any(fits(term, shared_facets_of(device)) for term in self._types)
            for device in (before, after)
        ]
        return was != is_now and (was or any(isinstance(term, PartIs) for term in leaves(self.query)))
