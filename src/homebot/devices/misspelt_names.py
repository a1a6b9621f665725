"""Misspelt names in a configuration: nothing in the house has them."""

from collections.abc import AsyncIterator, Callable, Sequence
from typing import Final, NamedTuple, final

import anyio

from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.device_names import names_of
from homebot.devices.health import HealthRequest, HealthResponse
from homebot.devices.names import GET_PLACES, QUERY_DEVICES
from homebot.devices.places_messages import GetPlaces
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import AreaIs, Query
from homebot.devices.services import QueryDevices
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.support.folding import fold
from homebot.support.names import find_name, no_such

_ANNOUNCED_WITHIN: Final = 300.0
"""Seconds after the start before a name without a device counts as misspelt.

Bridges announce their devices within a minute, and devices that report at intervals do so every few minutes.
"""

_AGAIN: Final = 60.0
_MAX_NAMES: Final = 20
_MAX_COMPARED: Final = 2000

UNKNOWN_NAME: Final = "config.unknown_name"


class StatedNames(NamedTuple):
    """The names in a configuration.

    Attributes:
        rooms: The key and name of each room.
        devices: The key and the id or name of each device.
        queries: The key, the text and the terms of each query that some device must fit.
        patterns: The same for queries that need not fit any device, such as the commands of a policy.
    """

    rooms: Sequence[tuple[str, str]] = ()
    devices: Sequence[tuple[str, str]] = ()
    queries: Sequence[tuple[str, str, Query]] = ()
    patterns: Sequence[tuple[str, str, Query]] = ()


@final
class ConfiguredNames:
    """Looks for the rooms and devices that a configuration names, and logs missing ones once.

    Args:
        read: Returns the currently configured names.
    """

    def __init__(self, node: Node, read: Callable[[], StatedNames]) -> None:
        self._log = node.log
        self._read = read
        self._is_due = False
        self._lookup = DeviceLookup(node)
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        self._places = node.create_client(GetPlaces, GET_PLACES)

    async def run(self) -> None:
        """Wait until devices have been announced, then log the names without a device."""
        await anyio.sleep(_ANNOUNCED_WITHIN)
        while True:
            try:
                problems = [problem async for problem in self._look()]
            except ServiceError:  # the directory is being restarted
                await anyio.sleep(_AGAIN)
                continue
            break
        self._is_due = True
        for problem in problems:
            minutes = _ANNOUNCED_WITHIN / 60
            self._log.warning(UNKNOWN_NAME, message=f"{problem} (looked for {minutes:g} minutes)")

    async def problems(self) -> tuple[str, ...]:
        """Return the names without a device, in words; empty before :meth:`run` has looked, or without an answer."""
        if not self._is_due:
            return ()
        try:
            return tuple([problem async for problem in self._look()])
        except ServiceError:
            return ()

    async def health(self, _: HealthRequest) -> HealthResponse:
        """Return the problems as the health of a node."""
        return HealthResponse(counts=(), troubles=await self.problems())

    async def _look(self) -> AsyncIterator[str]:
        """Yield the first problems; raise `ServiceError` if the directory does not answer."""
        stated = self._read()
        async for problem in self._unknown_rooms(stated.rooms[:_MAX_NAMES]):
            yield problem
        async for problem in self._unknown_devices(stated.devices[:_MAX_NAMES]):
            yield problem
        for key, text, query in stated.queries[:_MAX_NAMES]:
            answer = await self._query.call(QueryDevices.Request(query=query_terms(query), limit=1))
            if not answer.total:
                yield f"{key}: no device fits {text!r}; {answer.message or '`homebot find` shows what does'}"
        for key, text, query in stated.patterns[:_MAX_NAMES]:
            if mistake := await self._mistake(query):
                yield f"{key}: {text!r}: {mistake}"

    async def _unknown_rooms(self, rooms: Sequence[tuple[str, str]]) -> AsyncIterator[str]:
        stated = [room.name for room in (await self._places.call(GetPlaces.Request())).rooms] if rooms else []
        for key, name in rooms:
            if not find_name(name, stated) and not await self._lookup.devices(AreaIs(fold(name))):
                areas = {device.area for device in await self._lookup.devices()} - {""}
                known = [*stated, *areas][:_MAX_COMPARED]
                yield f"{key}: {no_such('room', name, known, 'no device is in it')}"

    async def _unknown_devices(self, devices: Sequence[tuple[str, str]]) -> AsyncIterator[str]:
        for key, name in devices:
            if not await self._lookup.find_called(name):
                known = [text for device in await self._lookup.devices() for text in names_of(device)][:_MAX_COMPARED]
                yield f"{key}: {no_such('device', name, known, '`homebot devices` lists all')}"

    async def _mistake(self, query: Query) -> str:
        answer = await self._query.call(QueryDevices.Request(query=query_terms(query), limit=1))
        return answer.message if answer.is_mistake else ""
