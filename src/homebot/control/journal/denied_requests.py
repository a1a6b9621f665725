"""Requests of clients that were refused for want of a right: a few of each client are entries, the rest a count."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

import anyio

from homebot.control.journal.command_addresses import CommandAddresses
from homebot.control.journal.journal import CommandJournal
from homebot.devices import FIND_DEVICES, FindDevices
from homebot.devices.access_messages import AccessRefused
from homebot.devices.names import COMMAND_DEVICES, HOLD_PART, PERFORM_COMMAND, gateway_of
from homebot.devices.query import NameIs, Or, query_terms
from homebot.devices.query.terms import FactIs
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.support.folding import fold

__all__ = ["DeniedRequests"]

MOST_ENTRIES: Final = 20
"""Entries of one client in an hour; further requests are counted in one more at the end of it."""

MOST_CLIENTS: Final = 100
"""Clients that are told apart; those beyond are noted as one."""

_HOUR: Final = 3600.0
_NAMED_IN: Final = frozenset({COMMAND_DEVICES, HOLD_PART, PERFORM_COMMAND})


_Request: TypeAlias = tuple[str, str, str, str]


@dataclass(slots=True)
class _DeniedOfClient:
    """The requests of one client that were denied in this hour: those noted, with their devices, and the others."""

    noted: dict[_Request, str] = field(default_factory=dict)
    more: int = 0
    newest: AccessRefused | None = None


@final
class DeniedRequests:
    """Notes in the journal what the door refused.

    The same request of a client is noted once in an hour, and 20 in all; how many more there were is noted at its end,
    or when homebot stops. So a flood of them takes little of the journal's room.

    Args:
        node: The node that asks the directory.
        journal: Takes the entries.
        addresses: The devices that raw commands are for.
    """

    def __init__(self, node: Node, journal: CommandJournal, addresses: CommandAddresses) -> None:
        self._node = node
        self._journal = journal
        self._addresses = addresses
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._clients: dict[str, _DeniedOfClient] = {}
        journal.add_last_note(self._note_counts)

    async def take(self, refused: AccessRefused) -> None:
        """Take in a request that the door refused."""
        if not self._clients:
            self._node.create_task(self._end_hour)
        name = refused.issuer if refused.issuer in self._clients or len(self._clients) < MOST_CLIENTS else ""
        client = self._clients.setdefault(name, _DeniedOfClient())
        request = _request(refused)
        count = 1 + refused.held_back
        if request in client.noted or len(client.noted) >= MOST_ENTRIES:
            client.more, client.newest = client.more + count, refused
            return
        client.noted[request] = ""
        client.noted[request] = device = await self._device_of(refused)
        self._journal.denied(refused, device, count)

    async def _end_hour(self) -> None:
        await anyio.sleep(_HOUR)
        self._note_counts()

    def _note_counts(self) -> None:
        """Note how many more requests there were of each client, and begin to count anew."""
        clients, self._clients = self._clients, {}
        for client in clients.values():
            if client.newest is not None:
                device = client.noted.get(_request(client.newest), "")
                self._journal.denied(client.newest, device, client.more)

    async def _device_of(self, refused: AccessRefused) -> str:
        """Return the id of the device that a command was for; empty where there is none, or several."""
        if not refused.subject:
            return ""
        target = "/" + refused.target.removeprefix("/")
        node, _, last = target.rpartition("/")
        if last == "out" and (gateway := gateway_of(node)):
            return await self._addresses.device_at(gateway, refused.subject)
        return await self._named(refused.subject) if target in _NAMED_IN else ""

    async def _named(self, subject: str) -> str:
        device = subject.partition("#")[0]
        wanted = Or((FactIs("id", device.casefold()), NameIs(fold(subject))))
        try:
            found = (await self._find.call(FindDevicesRequest(query=query_terms(wanted)))).devices
        except ServiceError:
            return ""
        own = [one.id for one in found if one.id == device] or [one.id for one in found]
        return own[0] if len(own) == 1 else ""


def _request(refused: AccessRefused) -> _Request:
    return refused.operation, refused.target, refused.subject, refused.wanted
