"""The postings of the devices, brought up to date before a query is answered. Pure."""

from __future__ import annotations

from typing import final

from homebot.devices.query import Query, facets_of
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.search.postings import Postings

__all__ = ["SearchIndex"]


@final
class SearchIndex:
    """Makes devices that changed findable, in small steps or when somebody asks.

    Args:
        table: The devices.
    """

    __slots__ = ("_table",)

    def __init__(self, table: DeviceTable) -> None:
        self._table = table

    @property
    def postings(self) -> Postings:
        """Postings by which devices are found; up to date after :meth:`sort`."""
        return self._table.postings

    def find(self, query: Query) -> frozenset[str] | set[str]:
        """Return the ids of the devices that fit *query*; not to be changed."""
        self.sort()
        return self._table.postings.find(query)

    def sort(self, at_most: int | None = None) -> bool:
        """Make devices that changed findable, at most so many; return whether some are left."""
        table = self._table
        outdated, topics = table.outdated, table.topics
        done = 0
        while outdated and (at_most is None or done < at_most):
            device_id = next(iter(outdated))
            del outdated[device_id]
            entry = table.entries[device_id]
            device = entry.to_device(topics)
            types = {part.id: part.part.service_type for part in entry.parts(topics).parts}
            values = [(state.part, types[state.part], state.capability, state.value.plain()) for state in device.states]
            table.postings.put(facets_of(device), values)
            done += 1
        return bool(outdated)
