"""A query in words for a house whose devices come and go. Pure."""

from collections.abc import Iterable
from typing import final

from homebot.devices.device import Device
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.parse import names_in, parse_query
from homebot.devices.query.terms import Query
from homebot.support.folding import fold


@final
class WordsQuery:
    """The query *text*, in which words that are exactly the name of a known device mean that device.

    Attributes:
        query: What it means by now.

    Raises:
        UsageError: It is not a query.
    """

    def __init__(self, text: str, devices: Iterable[Device] = ()) -> None:
        self._text = text
        self._names = names_in(text)
        self._named: dict[str, Device] = {}
        self.query: Query = parse_query(text)
        for device in devices:
            self.record(device)

    def record(self, device: Device, *, is_gone: bool = False) -> bool:
        """Record a new, changed or removed device; return whether the query means something else now."""
        was_named = self._named.pop(device.id, None) is not None
        if not is_gone and not self._names.isdisjoint(map(fold, (device.id, device.name, *device.names))):
            self._named[device.id] = device
        elif not was_named:
            return False
        before, self.query = self.query, parse_query(self._text, self._exists)
        return self.query != before

    def _exists(self, query: Query) -> bool:
        return any(fits(query, facets_of(device)) for device in self._named.values())
