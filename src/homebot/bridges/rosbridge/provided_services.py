"""The services that a client provides."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import AdvertiseService, ServiceOperation, ServiceResponse, frame_text
from homebot.bridges.rosbridge.services import named_values
from homebot.bridges.rosbridge.shared_state import Provisions, SharedState
from homebot.bridges.rosbridge.types import request_from_client, service_type_of
from homebot.errors import PeerError, RefusedError
from homebot.messages.json import message_to_text
from homebot.messages.message import Message, ServiceType

__all__ = ["ProvidedServices"]


class ProvidedServices:
    """The services that one connection of a client provides; it may owe an answer to so many calls, and no more."""

    def __init__(self, shared: SharedState, outbox: Outbox, provisions: Provisions) -> None:
        self._node, self._limit = shared.node, shared.settings.max_calls
        self._outbox, self._provisions = outbox, provisions
        self._pending: dict[str, asyncio.Future[ServiceResponse]] = {}
        self._calls = 0

    def advertise(self, op: AdvertiseService) -> None:
        """Offer a service of the client; the same once more is fine, and one of its older connection is taken over."""
        name = self._node.resolve_name(op.service, "service name")
        service_type = service_type_of(self._node.graph, name, op.type)
        ask = partial(self._ask, op.service, service_type)
        create = partial(self._node.create_service, concurrent=True, cancel_with_caller=True)
        self._provisions.add(name, lambda: create(service_type, name, ask))

    def unadvertise(self, op: ServiceOperation) -> None:
        """Withdraw a service; calls under way fail."""
        if not self._provisions.remove(self._node.resolve_name(op.service, "service name")):
            raise PeerError(f"service {op.service} is not provided by this client")

    def answer(self, op: ServiceResponse) -> None:
        """Take the client's answer to a call."""
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
