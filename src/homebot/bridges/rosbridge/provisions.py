"""The servers of one client on the graph: those of its services and of its actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, final

__all__ = ["Provisions"]


class _Server(Protocol):
    def close(self) -> None:
        """Leave the graph."""
        ...


@final
class Provisions:
    """The servers of one connection of a client, by the full names of what they serve.

    One of an older connection of the same client passes to the newer one: a client that reconnects after a network
    failure offers its services before its old connection is known to be dead.

    Attributes:
        on_taken: Called with a name that a newer connection took over.
    """

    def __init__(self, client: str, providers: dict[str, Provisions], on_taken: Callable[[str], None]) -> None:
        self.client = client
        self._providers = providers
        self.on_taken = on_taken
        self._servers: dict[str, _Server] = {}

    def __len__(self) -> int:
        return len(self._servers)

    def add(self, name: str, create: Callable[[], _Server]) -> None:
        """Serve *name*; the same once more is fine."""
        if name in self._servers:
            return
        older = self._providers.get(name)
        if older is not None and older.client == self.client:
            older.remove(name)
            older.on_taken(name)
        self._servers[name] = create()
        self._providers[name] = self

    def remove(self, name: str) -> bool:
        """Withdraw the server of *name*; return whether there was one."""
        server = self._servers.pop(name, None)
        if server is None:
            return False
        del self._providers[name]
        server.close()
        return True

    def close_one(self) -> bool:
        """Withdraw one server; return whether there was one."""
        return bool(self._servers) and self.remove(next(reversed(self._servers)))
