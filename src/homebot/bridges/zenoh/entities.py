"""The entities of homebot on the wire, and their messages."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

from homebot.bridges.zenoh.attachment import Attachment
from homebot.bridges.zenoh.tokens import EntityToken
from homebot.graph import Node
from homebot.graph.endpoint import EndpointInfo, EntityKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from homebot.bridges.zenoh.session import ZenohSession


class WireEntity:
    """One entity that the others see from :meth:`announce` until it is closed.

    Attributes:
        token: Its token.
    """

    def __init__(self, token: EntityToken, node: Node, session: ZenohSession) -> None:
        """Use :meth:`OwnEntities.declare` instead."""
        self.token = token
        self._now = node.graph.clock.now
        self._gid = token.gid
        self._numbers = count(1)
        self._session = session
        self._closing: list[Callable[[], object]] = []

    def keep(self, close: Callable[[], object]) -> None:
        """Call *close* when this closes, before what was kept earlier."""
        self._closing.append(close)

    def announce(self) -> None:
        """Tell the others, so that they may use it at once."""
        self.keep(self._session.declare_token(self.token.text).undeclare)

    def attachment(self) -> bytes:
        """Return the attachment of the next message."""
        return Attachment(next(self._numbers), int(self._now() * 1e9), self._gid).to_bytes()

    def close(self) -> None:
        """Leave. Idempotent."""
        while self._closing:
            self._closing.pop()()


class OwnEntities:
    """Makes the entities of one node."""

    def __init__(self, node: Node, session: ZenohSession, domain: int) -> None:
        self.session = session
        self._node, self._domain, self._ids = node, domain, count()
        self._node_id = next(session.nodes)
        self._kept = self.declare(EndpointInfo(EntityKind.NODE, node.full_name, node.full_name), "")
        self._kept.announce()

    def declare(self, info: EndpointInfo, type_hash: str) -> WireEntity:
        """Return *info* as an entity of the node, of which the others do not know yet."""
        node_id = self._node_id if info.node == self._node.full_name else next(self.session.nodes)
        token = EntityToken(self._domain, self.session.id, (node_id, next(self._ids)), info, type_hash)
        return WireEntity(token, self._node, self.session)
