"""Entries for requests of clients that lack a right: a few for each client, and a count of the rest."""

from typing import Final, TypeAlias, final

import anyio

from homebot.control.journal.journal import CommandJournal
from homebot.devices.access_messages import AccessRefused
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import COMMAND_DEVICES, HOLD_PART, PERFORM_COMMAND, gateway_of
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.support.limits import Limiter, LimitInterval

MAX_ENTRIES: Final = 20
"""Entries for one client in an hour; one more entry counts further requests."""

MAX_CLIENTS: Final = 100
"""Clients with a count of their own; the others share one."""

_HOUR: Final = 3600.0
_WITH_DEVICE: Final = frozenset({COMMAND_DEVICES, HOLD_PART, PERFORM_COMMAND})

_Request: TypeAlias = tuple[str, str, str, str, str]
"""The name of the client's count, and the parts of its request."""


@final
class DeniedRequests:
    """Records requests that the door refused.

    A flood takes little room: each distinct request of a client is one entry an hour, at most 20 in all. One entry at
    the end of the hour, or when homebot stops, counts the others.
    """

    def __init__(self, node: Node, lookup: DeviceLookup, journal: CommandJournal) -> None:
        self._node = node
        self._lookup = lookup
        self._journal = journal
        self._clients = Limiter[str, tuple[_Request, AccessRefused]](_HOUR, MAX_CLIENTS + 1, self._record_count)
        self._devices: dict[_Request, str] = {}  # of the requests with an entry

    async def record(self, refused: AccessRefused) -> None:
        """Record a refused request."""
        if not self._clients:
            self._node.create_task(self._end_hour)
        name = refused.issuer if refused.issuer in self._clients or len(self._clients) < MAX_CLIENTS else ""
        client = self._clients.of(name, self._node.graph.clock.monotonic())
        request = name, refused.operation, refused.target, refused.subject, refused.wanted
        count = 1 + refused.held_back
        if not client.admit(0 if request in self._devices else MAX_ENTRIES, (request, refused), count):
            return
        self._devices[request] = ""
        self._devices[request] = device = await self._device_of(refused)
        self._journal.record_denial(refused, device, count)

    async def _end_hour(self) -> None:
        await anyio.sleep(_HOUR)
        self.record_counts()

    def record_counts(self) -> None:
        """Record the counts of all clients, and reset them."""
        self._clients.drop()
        self._devices.clear()

    def _record_count(self, _name: str, client: LimitInterval[tuple[_Request, AccessRefused]]) -> None:
        newest, count = client.release()
        if newest is not None:
            self._journal.record_denial(newest[1], self._devices.get(newest[0], ""), count)

    async def _device_of(self, refused: AccessRefused) -> str:
        """Return the id of the device that a command is for; empty if there is none, or several."""
        if not refused.subject:
            return ""
        target = "/" + refused.target.removeprefix("/")
        node, _, last = target.rpartition("/")
        if last == "out" and (gateway := gateway_of(node)):
            return await self._lookup.device_at(gateway, refused.subject)
        return await self._named(refused.subject) if target in _WITH_DEVICE else ""

    async def _named(self, subject: str) -> str:
        try:
            devices = await self._lookup.find_called(subject, subject.partition("#")[0])
        except ServiceError:
            return ""
        return devices[0].id if len(devices) == 1 else ""
