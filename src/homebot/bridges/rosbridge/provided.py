"""The services that one client provides to everybody on the graph."""

from __future__ import annotations

import asyncio
from typing import Any

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    AdvertiseService,
    ServiceResponse,
    UnadvertiseService,
    service_request,
)
from homebot.bridges.rosbridge.types import service_type_of
from homebot.bridges.rosbridge.values import message_from_client
from homebot.errors import PeerError, RefusedError
from homebot.graph import Node, Service
from homebot.messages.json import message_to_json
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = ["ProvidedServices"]


class ProvidedServices:
    """The services that one client provides, under the names that the client uses.

    Args:
        node: The node that serves in the client's stead.
        limit: Calls that the client may owe an answer to; one more fails at once.
        outbox: Takes frames to the client.
    """

    def __init__(self, node: Node, limit: int, outbox: Outbox) -> None:
        self._node = node
        self._limit = limit
        self._outbox = outbox
        self._services: dict[str, Service[Any, Any]] = {}
        self._pending: dict[str, asyncio.Future[ServiceResponse]] = {}
        self._calls = 0

    def __len__(self) -> int:
        return len(self._services)

    def advertise(self, op: AdvertiseService) -> None:
        """Offer a service of the client; the same once more is fine.

        Raises:
            InvalidNameError: The name is illegal.
            DuplicateNameError: Somebody else serves it.
            TypeMismatchError: It is of another type.
            PeerError: The type is unknown.
        """
        service_type = service_type_of(self._node.graph, self._node.resolve_name(op.service, "service name"), op.type)
        if op.service in self._services:
            return

        async def ask(request: Message) -> Message:
            return await self._ask(op.service, service_type, request)

        self._services[op.service] = self._node.create_service(service_type, op.service, ask, concurrent=True)

    def unadvertise(self, op: UnadvertiseService) -> None:
        """Withdraw a service; calls under way fail.

        Raises:
            PeerError: The client does not provide it.
        """
        service = self._services.pop(op.service, None)
        if service is None:
            raise PeerError(f"service {op.service} is not provided by this client")
        service.close()

    def answer(self, op: ServiceResponse) -> None:
        """Take the client's answer to a call.

        Raises:
            PeerError: No call waits for it.
        """
        pending = self._pending.get(str(op.id))
        if pending is None or pending.done():
            raise PeerError(f"no call of {op.service} with the id {op.id!r} waits for a response (any more)")
        pending.set_result(op)

    def close_one(self) -> bool:
        """Withdraw one service, whose calls under way fail; return whether there was one."""
        if not self._services:
            return False
        self._services.popitem()[1].close()
        return True

    async def _ask(self, name: str, service_type: ServiceType[Any, Any], request: Message) -> Message:
        if len(self._pending) >= self._limit:
            raise RefusedError(f"the call of {name}", f"its provider has {self._limit} calls waiting already")
        if not self._outbox.has_room:
            raise RefusedError(f"the call of {name}", "its provider does not read its messages")
        self._calls += 1
        identifier = f"service_request:{name}:{self._calls}"
        pending = self._pending[identifier] = asyncio.get_running_loop().create_future()
        try:
            self._outbox.answer(service_request(name, identifier, message_to_json(request)))
            response = await pending
        finally:
            del self._pending[identifier]
        if not response.result:
            raise RefusedError(f"the call of {name}", str(response.values or "its provider gave no reason")[:500])
        values = response.values if isinstance(response.values, dict) else {}
        return message_from_client(service_type.Response, values)
