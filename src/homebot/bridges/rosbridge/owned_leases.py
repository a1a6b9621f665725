"""The leases that clients of the door have asked for, each of the connection that last did."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple, final

from homebot.devices.lease_messages import HolderRequest, HoldRequest, ReleaseLease
from homebot.devices.names import RELEASE_LEASE, RENEW_LEASE
from homebot.graph import Client, Node
from homebot.messages.message import Message

__all__ = ["OwnedLeases"]


class _Owned(NamedTuple):
    owner: object
    ttl: float
    until: float
    holding: Client[Any, Any]


@final
class OwnedLeases:
    """The leases of all connections, for as long as they may last."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._now = node.graph.clock.monotonic
        self._leases: dict[tuple[str, str, str], _Owned] = {}

    def record(self, owner: object, client: Client[Any, Any], request: Message) -> None:
        """Record a *request* of *owner* by *client* to hold, to renew or to release; others are ignored."""
        if not isinstance(request, HoldRequest | HolderRequest):
            return
        key = (request.issuer, request.by, request.lease)
        known = self._leases.pop(key, None)
        if isinstance(request, HoldRequest):
            self._leases[key] = _Owned(owner, request.ttl, self._now() + request.ttl, client)
        elif known is not None and client.service_name == RENEW_LEASE:
            self._leases[key] = known._replace(owner=owner, until=self._now() + known.ttl)

    def has(self, owner: object) -> bool:
        """Return whether a lease of *owner* may last."""
        now = self._now()
        self._leases = {key: one for key, one in self._leases.items() if one.until > now}
        return any(one.owner is owner for one in self._leases.values())

    def release(self, owner: object) -> None:
        """Release the leases of *owner*, which is gone."""
        for (issuer, by, lease), one in list(self._leases.items()):
            if one.owner is owner:
                del self._leases[issuer, by, lease]
                request = HolderRequest(lease=lease, by=by, issuer=issuer)
                self._node.create_task(partial(self._release, request, one.holding))

    async def _release(self, request: HolderRequest, holding: Client[Any, Any]) -> None:
        """Release a lease, at once and again where it begins later: its client may have left at once."""
        releasing = self._node.create_client(ReleaseLease, RELEASE_LEASE)
        releasing.send(request)
        await holding.wait_for_handlers()
        releasing.send(request)
        releasing.close()
