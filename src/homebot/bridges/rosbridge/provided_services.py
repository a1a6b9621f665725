"""The servers of one client on the graph, and the services among them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias, final

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import AdvertiseService, ServiceResponse, UnadvertiseService, frame_text
from homebot.bridges.rosbridge.services import named_values
from homebot.bridges.rosbridge.types import request_from_client, service_type_of
from homebot.errors import PeerError, RefusedError
from homebot.graph import Node
from homebot.messages.json import message_to_text
from homebot.messages.message import Message, ServiceType

if TYPE_CHECKING:
    from homebot.graph import Service
    from homebot.graph.actions import ActionServer

__all__ = ["ProvidedServices", "Provisions"]

_Server: TypeAlias = "Service[Any, Any] | ActionServer[Any, Any, Any]"


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


class ProvidedServices:
    """The services that one connection of a client provides.

    Args:
        limit: Calls that the client may owe an answer to; one more fails at once.
    """

    def __init__(self, node: Node, limit: int, outbox: Outbox, provisions: Provisions) -> None:
        self._node = node
        self._limit = limit
        self._outbox = outbox
        self._provisions = provisions
        self._pending: dict[str, asyncio.Future[ServiceResponse]] = {}
        self._calls = 0

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
        ask = partial(self._ask, op.service, service_type)
        create = partial(self._node.create_service, concurrent=True, cancel_with_caller=True)
        self._provisions.add(name, lambda: create(service_type, name, ask))

    def unadvertise(self, op: UnadvertiseService) -> None:
        """Withdraw a service; calls under way fail.

        Raises:
            PeerError: The client does not provide it.
        """
        if not self._provisions.remove(self._node.resolve_name(op.service, "service name")):
            raise PeerError(f"service {op.service} is not provided by this client")

    def answer(self, op: ServiceResponse) -> None:
        """Take the client's answer to a call.

        Raises:
            PeerError: No call waits for it.
        """
        pending = self._pending.get(str(op.id))
        if pending is None or pending.done():
            raise PeerError(f"no call of {op.service} with the id {op.id!r} is waiting for a response")
        pending.set_result(op)

    async def _ask(self, name: str, service_type: ServiceType[Any, Any], request: Message) -> Message:
        if len(self._pending) >= self._limit:
            raise RefusedError(f"the call of {name}", f"its provider has {self._limit} calls waiting already")
        if not self._outbox.has_room:
            raise RefusedError(f"the call of {name}", "its provider is not reading its messages")
        self._calls += 1
        identifier = f"service_request:{name}:{self._calls}"
        pending = self._pending[identifier] = asyncio.get_running_loop().create_future()
        try:
            args = message_to_text(request)
            self._outbox.answer(frame_text("call_service", identifier, {"service": name}, args=args))
            response = await pending
        finally:
            del self._pending[identifier]
        if not response.result:
            raise RefusedError(f"the call of {name}", str(response.values or "its provider gave no reason")[:500])
        values = named_values(service_type.Response, response.values or {})
        return request_from_client(service_type.Response, values, self._node.graph.clock.now())
