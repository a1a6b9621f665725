"""Messages of topics behind gateways, such as those of MQTT, however often a gateway restarts."""

from __future__ import annotations

from collections.abc import Callable

from homebot.devices.gateway_messages import RawMessage
from homebot.devices.names import GatewayNames
from homebot.devices.services import SubscribeToTopic, SubscribeToTopicRequest
from homebot.errors import ServiceError, WireError
from homebot.graph import Node
from homebot.log import LogLimit

__all__ = ["GatewayTopics"]

UNREADABLE = "robots.message_unreadable"
NOT_WATCHED = "robots.topic_not_watched"


class GatewayTopics:
    """The topics behind gateways that are read.

    Args:
        node: The node that reads.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._handlers: dict[tuple[str, str], Callable[[RawMessage], None]] = {}
        self._gateways: dict[str, None] = {}
        self._log = LogLimit(node.graph.clock)

    def __bool__(self) -> bool:
        return bool(self._handlers)

    def read(self, gateway: str, topic: str, handle: Callable[[RawMessage], None]) -> None:
        """Call *handle* with each message on *topic* of *gateway*, while :meth:`run` runs."""
        self._handlers[gateway, topic] = handle
        if gateway not in self._gateways:
            self._gateways[gateway] = None
            self._node.create_subscription(RawMessage, GatewayNames(gateway).watched, self._on_message, 100)

    async def run(self) -> None:
        """Ask each gateway for its topics, and anew when it restarts, until cancelled."""
        async for service in self._node.graph.watch_services():
            for gateway in self._gateways:
                name = GatewayNames(gateway).watch
                if service in {None, name} and name in self._node.graph.get_service_names_and_types():
                    await self._ask(gateway, name)

    async def _ask(self, gateway: str, service: str) -> None:
        client = self._node.create_client(SubscribeToTopic, service)
        try:
            for one, topic in self._handlers:
                if one == gateway:
                    answer = await client.call(SubscribeToTopicRequest(topic=topic))
                    if not answer.success:
                        self._warn(NOT_WATCHED, topic, answer.message)
        except ServiceError as exc:
            self._warn(NOT_WATCHED, gateway, str(exc))
        finally:
            client.close()

    def _on_message(self, message: RawMessage) -> None:
        handle = self._handlers.get((message.gateway, message.address))
        if handle is not None and message.payload:
            try:
                handle(message)
            except WireError as exc:
                self._warn(UNREADABLE, message.address, str(exc))

    def _warn(self, event: str, topic: str, problem: str) -> None:
        if self._log.allows(topic) is not None:
            self._node.log.warning(event, message=f"{topic} is not read: {problem}", topic=topic)
