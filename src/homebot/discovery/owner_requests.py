"""The owner's requests to the directory, published for a recorder."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final, TypeVar, final

from homebot.devices.names import OWNER_REQUESTS
from homebot.devices.places_messages import OwnerRequest
from homebot.graph import Node
from homebot.messages import Time
from homebot.messages.json import message_to_text
from homebot.messages.message import Message, ServiceType

__all__ = ["OwnerRequests"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)

_DEPTH: Final = 1000


@final
class OwnerRequests:
    """Publisher of the requests to the services of the owner, if there is a subscriber."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(OwnerRequest, OWNER_REQUESTS, _DEPTH)

    def serve(
        self,
        service: ServiceType[RequestT, ResponseT],
        name: str,
        handler: Callable[[RequestT], ResponseT | Awaitable[ResponseT]],
    ) -> None:
        """Offer a service, and publish each request before it is carried out."""

        def noted(request: RequestT) -> ResponseT | Awaitable[ResponseT]:
            self.publish(name, request)
            return handler(request)

        self._node.create_service(service, name, noted)

    def publish(self, name: str, request: Message) -> None:
        """Publish a request to the service *name*."""
        if self._publisher.subscription_count:
            at = Time.from_seconds(self._node.graph.clock.now())
            self._publisher.publish(OwnerRequest(at=at, service=name, request=message_to_text(request)))
