"""The end of goals and leases of vanished clients: pings while there are any, and the owners of leases."""

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, NamedTuple, final

import anyio
import anyio.lowlevel

from homebot.devices.lease_messages import HolderRequest, HoldRequest, ReleaseLease
from homebot.devices.names import RELEASE_LEASE, RENEW_LEASE
from homebot.graph import Client, Node
from homebot.messages.message import Message


@final
class Heartbeat:
    """Pings to a client that owns goals or leases, as a lost radio link, unlike a closed socket, is not noticed.

    Args:
        ping: Returns when the client has answered.
        interval: Seconds between pings.
        timeout: Seconds within which the client must answer.
        is_excused: Returns whether the client has been heard since the last call, or is not being read from.
    """

    def __init__(
        self,
        ping: Callable[[], Awaitable[None]],
        interval: float,
        timeout: float,
        is_excused: Callable[[], bool],
    ) -> None:
        self._ping = ping
        self._interval = interval
        self._timeout = timeout
        self._is_excused = is_excused
        self._is_due = anyio.Event()

    def start(self) -> None:
        """Start pinging: the client owns something."""
        self._is_due.set()

    async def run(self, is_needed: Callable[[], bool]) -> None:
        """Return once the client has vanished while *is_needed* says that it owns something."""
        while True:
            while not is_needed():
                self._is_due = anyio.Event()
                await self._is_due.wait()
            self._is_excused()
            with anyio.move_on_after(self._timeout) as limit:
                await self._ping()
            if limit.cancelled_caught and is_needed():
                await anyio.lowlevel.checkpoint()  # the answer may have arrived while the process was busy
                if not self._is_excused():
                    return
            await anyio.sleep(self._interval)


class _Owned(NamedTuple):
    owner: object
    ttl: float
    until: float
    holding: Client[Any, Any]


@final
class OwnedLeases:
    """The leases of all connections, while they may last."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._now = node.graph.clock.monotonic
        self._leases: dict[tuple[str, str, str], _Owned] = {}

    def record(self, owner: object, client: Client[Any, Any], request: Message) -> None:
        """Record a *request* of *owner* through *client* to hold, renew or release; others are ignored."""
        if not isinstance(request, HoldRequest | HolderRequest):
            return
        key = (request.issuer, request.by, request.lease)
        known = self._leases.pop(key, None)
        if isinstance(request, HoldRequest):
            self._leases[key] = _Owned(owner, request.ttl, self._now() + request.ttl, client)
        elif known is not None and client.service_name == RENEW_LEASE:
            self._leases[key] = known._replace(owner=owner, until=self._now() + known.ttl)

    def has(self, owner: object) -> bool:
        """Return whether *owner* may have a lease."""
        now = self._now()
        self._leases = {key: held for key, held in self._leases.items() if held.until > now}
        return any(lease.owner is owner for lease in self._leases.values())

    def release(self, owner: object) -> None:
        """Release the leases of *owner*, which has left."""
        for (issuer, by, lease), held in list(self._leases.items()):
            if held.owner is owner:
                del self._leases[issuer, by, lease]
                request = HolderRequest(lease=lease, by=by, issuer=issuer)
                self._node.create_task(partial(self._release, request, held.holding))

    async def _release(self, request: HolderRequest, holding: Client[Any, Any]) -> None:
        """Release a lease now, and again once it begins, as its client may leave before that."""
        releasing = self._node.create_client(ReleaseLease, RELEASE_LEASE)
        releasing.send(request)
        await holding.wait_for_handlers()
        releasing.send(request)
        releasing.close()
