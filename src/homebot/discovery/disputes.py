"""Who sends commands where: a topic that belongs to one device is not another one's to use. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import TypeAlias, final

__all__ = ["MAX_CONCERNED", "MAX_TOPICS", "Address", "Disputes"]

Address: TypeAlias = tuple[str, str]
"""Gateway and topic."""

MAX_TOPICS = 256
"""Command topics of one device that are watched; further ones are free for all."""

MAX_CONCERNED = 64
"""Devices that are looked at anew when a topic passes to another one, the oldest first.

Of further ones the words may name the one that had it before; none of them may use it, before or after.
"""


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
        return (concerned | self._enter(device, wanted, bridge)) - {device}

    def add(self, device: str, addresses: Iterable[Address], bridge: str) -> frozenset[str]:
        """As :meth:`put`, for further addresses."""
        known = self._addresses.get(device, ())
        new = tuple(one for one in dict.fromkeys(addresses) if one not in known)[: max(0, MAX_TOPICS - len(known))]
        if not new:
            return frozenset()
        self._addresses[device] = known + new
        return self._enter(device, new, bridge) - {device}

    def discard(self, device: str) -> frozenset[str]:
        """Forget *device*; return whom that concerns."""
        concerned = self._leave(device, keep=frozenset())
        self._idle.discard(device)
        return concerned - {device}

    def set_idle(self, device: str, *, idle: bool) -> frozenset[str]:
        """Note whether *device* fell silent; return whom that concerns."""
        if idle == (device in self._idle) or device not in self._addresses:
            return frozenset()
        shared = [users for one in self._addresses[device] if len(users := self._users[one]) > 1]
        before = [self._first(users) for users in shared]
        if idle:
            self._idle.add(device)
        else:
            self._idle.discard(device)
        concerned: set[str] = set()
        for users, first in zip(shared, before, strict=True):
            concerned |= self._heirs(users, first)
        return frozenset(concerned - {device})

    def owner(self, address: Address, device: str) -> str:
        """Return the device that has *address*, where that is not *device* and keeps it from it; else empty."""
        users = self._users.get(address)
        if users is None or len(users) == 1 or device not in users:
            return ""
        first = self._first(users) or device
        bridge = users[device]
        return "" if first == device or (bridge and users[first] == bridge) else first

    def _enter(self, device: str, addresses: Iterable[Address], bridge: str) -> frozenset[str]:
        concerned: set[str] = set()
        for address in addresses:
            users = self._users.setdefault(address, {})
            before = self._first(users)
            is_other = users.get(device, bridge) != bridge
            users[device] = bridge
            if len(users) > 1:
                concerned |= self._heirs(users, "" if is_other else before)
        return frozenset(concerned)

    def _leave(self, device: str, keep: frozenset[Address]) -> frozenset[str]:
        concerned: set[str] = set()
        for address in self._addresses.pop(device, ()):
            if address in keep:
                continue
            users = self._users[address]
            before = self._first(users)
            del users[device]
            concerned |= self._heirs(users, before)
            if not users:
                del self._users[address]
        return frozenset(concerned)

    def _first(self, users: dict[str, str]) -> str:
        """Who keeps the topic from the others; empty where all of them are silent."""
        return next((one for one in users if one not in self._idle), "")

    def _heirs(self, users: dict[str, str], before: str) -> set[str]:
        """Whom it concerns that somebody came or went: nobody, where the one who was *before* the first still is."""
        first = self._first(users)
        if first == before:
            return set()
        return {*islice(users, MAX_CONCERNED), *((first,) if first else ())}
