"""The services that a client provides on the graph."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import AdvertiseService, ServiceResponse, UnadvertiseService, service_request
from homebot.bridges.rosbridge.types import message_from_client, service_type_of
from homebot.errors import PeerError, RefusedError
from homebot.graph import Node, Service
from homebot.messages.json import message_to_json
from homebot.messages.message import Message, ServiceType

__all__ = ["ProvidedServices", "Provider"]


class Provider(Protocol):
    """A connection that provides services or actions.

    Attributes:
        client: The name of the client.
    """

    client: str

    def hand_over(self, full_name: str) -> None:
        """Withdraw the service or action of this name, which a newer connection takes over."""
        ...


class ProvidedServices:
    """The services that one connection of a client provides, under the names that the client uses.

    A service that an older connection of the same client provides passes to the newer one: a client that
    reconnects after a network failure offers its services before its old connection is known to be dead.

    Args:
        node: The node that serves in the client's stead.
        client: The name of the client.
        limit: Calls that the client may owe an answer to; one more fails at once.
        outbox: Takes frames to the client.
        providers: The connection that provides each service and action, by its full name.
        on_taken: Called with the name of a service that a newer connection took over.

    Attributes:
        client: The name of the client.
    """

    def __init__(
        self,
        node: Node,
        client: str,
        limit: int,
        outbox: Outbox,
        providers: dict[str, Provider],
        on_taken: Callable[[str], None],
    ) -> None:
        self._node = node
        self.client = client
        self._limit = limit
        self._outbox = outbox
        self._providers = providers
        self._on_taken = on_taken
        self._services: dict[str, Service[Any, Any]] = {}
        self._pending: dict[str, asyncio.Future[ServiceResponse]] = {}
        self._calls = 0

    def __len__(self) -> int:
        return len(self._services)

    def advertise(self, op: AdvertiseService) -> None:
        """Offer a service of the client; the same once more is fine, and one of its older connection is taken over.

        Raises:
            InvalidNameError: The name is illegal.
            DuplicateNameError: Another node serves it.
            TypeMismatchError: It is of another type.
            PeerError: The type is unknown.
        """
        name = self._node.resolve_name(op.service, "service name")
        service_type = service_type_of(self._node.graph, name, op.type)
        if op.service in self._services:
            return
        older = self._providers.get(name)
        if older is not None and older.client == self.client:
            older.hand_over(name)

        async def ask(request: Message) -> Message:
            return await self._ask(op.service, service_type, request)

        self._services[op.service] = self._node.create_service(
            service_type, op.service, ask, concurrent=True, cancel_with_caller=True
        )
        self._providers[name] = self

    def unadvertise(self, op: UnadvertiseService) -> None:
        """Withdraw a service; calls under way fail.

        Raises:
            PeerError: The client does not provide it.
        """
        if op.service not in self._services:
            raise PeerError(f"service {op.service} is not provided by this client")
        self._withdraw(op.service)

    def answer(self, op: ServiceResponse) -> None:
        """Take the client's answer to a call.

        Raises:
            PeerError: No call waits for it.
        """
        pending = self._pending.get(str(op.id))
        if pending is None or pending.done():
            raise PeerError(f"no call of {op.service} with the id {op.id!r} is waiting for a response")
        pending.set_result(op)

    def hand_over(self, full_name: str) -> None:
        """Withdraw the service of this name, which a newer connection takes over; calls under way fail."""
        name = next(name for name, service in self._services.items() if service.service_name == full_name)
        self._withdraw(name)
        self._on_taken(name)

    def close_one(self) -> bool:
        """Withdraw one service and fail its pending calls; return whether there was one."""
        if not self._services:
            return False
        self._withdraw(next(reversed(self._services)))
        return True

    def _withdraw(self, name: str) -> None:
        service = self._services.pop(name)
        del self._providers[service.service_name]
        service.close()

    async def _ask(self, name: str, service_type: ServiceType[Any, Any], request: Message) -> Message:
        if len(self._pending) >= self._limit:
            raise RefusedError(f"the call of {name}", f"its provider has {self._limit} calls waiting already")
        if not self._outbox.has_room:
            raise RefusedError(f"the call of {name}", "its provider is not reading its messages")
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
