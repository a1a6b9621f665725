"""The services that a client provides on the graph."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import AdvertiseService, ServiceResponse, UnadvertiseService, frame_text
from homebot.bridges.rosbridge.provisions import Provisions
from homebot.bridges.rosbridge.types import message_from_client, service_type_of
from homebot.errors import PeerError, RefusedError
from homebot.graph import Node
from homebot.messages.json import message_to_text
from homebot.messages.message import Message, ServiceType

__all__ = ["ProvidedServices"]


class ProvidedServices:
    """The services that one connection of a client provides.

    Args:
        node: The node that serves in the client's stead.
        limit: Calls that the client may owe an answer to; one more fails at once.
        outbox: Takes frames to the client.
        provisions: The servers of the client.
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
        values = response.values if isinstance(response.values, dict) else {}
        return message_from_client(service_type.Response, values)
