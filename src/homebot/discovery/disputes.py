"""Who sends commands where: a topic that belongs to one device is not another one's to use. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias, final

__all__ = ["MAX_TOPICS", "Address", "Disputes"]

Address: TypeAlias = tuple[str, str]
"""Gateway and topic."""

MAX_TOPICS = 256
"""Command topics of one device that are watched; further ones are free for all."""


@final
class Disputes:
    """Keeps which device was the first to be told something on a topic.

    Devices behind one bridge may share the bridge's topic; a device that fell silent keeps nothing from others.
    """

    def __init__(self) -> None:
        self._users: dict[Address, dict[str, str]] = {}
        self._addresses: dict[str, tuple[Address, ...]] = {}
        self._idle: set[str] = set()

    def put(self, device: str, addresses: Iterable[Address], bridge: str) -> frozenset[str]:
        """Note the *addresses* that *device* is told something on, and its *bridge*; return whom that concerns."""
        wanted = tuple(dict.fromkeys(addresses))[:MAX_TOPICS]
        if self._addresses.get(device, ()) == wanted:
            return frozenset()
        concerned = self._leave(device, keep=frozenset(wanted))
        if wanted:
            self._addresses[device] = wanted
        for address in wanted:
            users = self._users.setdefault(address, {})
            users[device] = bridge
            if len(users) > 1:
                concerned |= users.keys()
        return concerned - {device}

    def add(self, device: str, addresses: Iterable[Address], bridge: str) -> frozenset[str]:
        """As :meth:`put`, for further addresses."""
        known = self._addresses.get(device, ())
        new = tuple(one for one in dict.fromkeys(addresses) if one not in known)[: max(0, MAX_TOPICS - len(known))]
        if not new:
            return frozenset()
        self._addresses[device] = known + new
        concerned: set[str] = set()
        for address in new:
            users = self._users.setdefault(address, {})
            users[device] = bridge
            if len(users) > 1:
                concerned |= users.keys()
        return frozenset(concerned - {device})

    def discard(self, device: str) -> frozenset[str]:
        """Forget *device*; return whom that concerns."""
        self._idle.discard(device)
        return self._leave(device, keep=frozenset()) - {device}

    def set_idle(self, device: str, *, idle: bool) -> frozenset[str]:
        """Note whether *device* fell silent; return whom that concerns."""
        if idle == (device in self._idle) or device not in self._addresses:
            return frozenset()
        if idle:
            self._idle.add(device)
        else:
            self._idle.discard(device)
        users = (self._users[address] for address in self._addresses[device])
        return frozenset(one for found in users if len(found) > 1 for one in found) - {device}

    def owner(self, address: Address, device: str) -> str:
        """Return the device that has *address*, where that is not *device* and keeps it from it; else empty."""
        users = self._users.get(address)
        if users is None or len(users) == 1 or device not in users:
            return ""
        first = next((one for one in users if one not in self._idle), device)
        bridge = users[device]
        return "" if first == device or (bridge and users[first] == bridge) else first

    def _leave(self, device: str, keep: frozenset[Address]) -> frozenset[str]:
        concerned: set[str] = set()
        for address in self._addresses.pop(device, ()):
            if address in keep:
                continue
            users = self._users[address]
            del users[device]
            concerned |= users.keys()
            if not users:
                del self._users[address]
        return frozenset(concerned)
