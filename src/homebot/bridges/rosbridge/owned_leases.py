"""The leases that clients of the door have asked for, each of the connection that last did."""

from __future__ import annotations

from functools import partial
from typing import Final, NamedTuple, TypeAlias, final

import anyio

from homebot.devices.lease_messages import HolderRequest, HoldRequest, ReleaseLease
from homebot.devices.names import RELEASE_LEASE, RENEW_LEASE
from homebot.graph import Node
from homebot.messages.message import Message

__all__ = ["OwnedLeases"]

_AFTER_LEAVING: Final = 10.0
"""Seconds for which a lease lasts after its connection ended: a robot in a doorway may reconnect and renew it."""

_Key: TypeAlias = tuple[str, str, str]


class _Owned(NamedTuple):
    owner: object
    ttl: float
    until: float


@final
class OwnedLeases:
    """The leases of all connections, for as long as they may last.

    Args:
        node: The node that releases them in the clients' stead.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._now = node.graph.clock.monotonic
        self._leases: dict[_Key, _Owned] = {}

    def record(self, owner: object, service: str, request: Message) -> None:
        """Record a *request* of *owner* to hold, to renew or to release; others are ignored."""
        if not isinstance(request, HoldRequest | HolderRequest):
            return
        key = (request.issuer, request.by, request.lease)
        known = self._leases.pop(key, None)
        if isinstance(request, HoldRequest):
            self._leases[key] = _Owned(owner, request.ttl, self._now() + request.ttl)
        elif known is not None and service == RENEW_LEASE:
            self._leases[key] = _Owned(owner, known.ttl, self._now() + known.ttl)

    def has(self, owner: object) -> bool:
        """Return whether a lease of *owner* may last."""
        now = self._now()
        self._leases = {key: one for key, one in self._leases.items() if one.until > now}
        return any(one.owner is owner for one in self._leases.values())

    def release(self, owner: object) -> None:
        """Release the leases of *owner*, which is gone, soon and unless another connection renews them."""
        for key, one in self._leases.items():
            if one.owner is owner:
                self._leases[key] = one._replace(owner=None)
                self._node.create_task(partial(self._release, key, self._leases[key]))

    async def _release(self, key: _Key, left: _Owned) -> None:
        await anyio.sleep(_AFTER_LEAVING)
        if self._leases.get(key) is left:
            issuer, by, lease = key
            del self._leases[key]
            releasing = self._node.create_client(ReleaseLease, RELEASE_LEASE)
            releasing.send(HolderRequest(lease=lease, by=by, issuer=issuer))
            releasing.close()
