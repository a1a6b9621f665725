"""A query in words for a house whose devices come and go. Pure."""

from collections.abc import Iterable
from itertools import chain
from typing import final

from homebot.devices.device import Device
from homebot.devices.query.facets import facets_of, parts_named_like_types, shared_facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.parse import names_in, parse_query
from homebot.devices.query.terms import AreaIs, InArea, Query, TypeIs, leaves
from homebot.support.folding import fold


@final
class WordsQuery:
    """The query *text*, in which words that are exactly the name of a known device, part or room mean it.

    Attributes:
        query: What it means by now.

    Raises:
        UsageError: It is not a query.
    """

    def __init__(self, text: str, devices: Iterable[Device] = ()) -> None:
        self._text = text
        self._names = names_in(text)
        self._named: dict[str, Device] = {}
        self._areas: dict[str, tuple[str, ...]] = {}  # those that the text names, by device
        self.query: Query = parse_query(text)
        self._types = [term for term in leaves(self.query) if isinstance(term, TypeIs)]
        self._typed: dict[str, Device] = {}  # of those types, which parts that are called so are not
        self._asked_areas = frozenset([term.text for term in leaves(self.query) if isinstance(term, InArea)])
        for device in devices:
            self.record(device)

    def record(self, device: Device, *, is_gone: bool = False) -> bool:
        """Record a new, changed or removed device; return whether the query means something else now."""
        was_named = self._named.pop(device.id, None) is not None
        names = (*map(fold, (device.id, device.name, *device.names)), *parts_named_like_types(device))
        is_named = not is_gone and not self._names.isdisjoint(names)
        if is_named:
            self._named[device.id] = device
        was_typed = self._typed.pop(device.id, None) is not None
        if self._types and not is_gone:
            facets = shared_facets_of(device)
            if any(fits(term, facets) for term in self._types):
                self._typed[device.id] = device
        is_change = self._record_areas(device, is_gone=is_gone) or was_named or is_named
        if not is_change and (not self._named or was_typed == (device.id in self._typed)):
            return False
        before, self.query = self.query, parse_query(self._text, self._exists)
        return self.query != before

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
        devices = chain(self._named.values(), self._typed.values())
        return any(fits(query, facets_of(device)) for device in devices)
