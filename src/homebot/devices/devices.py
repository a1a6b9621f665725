"""What an application does with devices: find them, follow them, listen to them, tell them something."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeAlias

from homebot.devices.device import Device, Endpoint
from homebot.devices.follow import Follow
from homebot.devices.names import FIND_DEVICES, GatewayNames
from homebot.devices.raw import RawCommand, RawMessage
from homebot.devices.services import (
    FindDevices,
    FindDevicesRequest,
    SubscribeToTopic,
    SubscribeToTopicRequest,
    SubscribeToTopicResponse,
)
from homebot.errors import RefusedError
from homebot.graph import Client, EntityKind, Node, Publisher, Subscription
from homebot.messages import Time

__all__ = ["Devices", "MessageHandler"]

MessageHandler: TypeAlias = Callable[[RawMessage], Awaitable[None] | None]

_INBOX_DEPTH = 1000
_COMMANDS_DEPTH = 1000


class Devices:
    """The devices of the house, as the node *node* sees them.

    Everything made here belongs to the node and ends with it.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._since = Time.from_seconds(node.graph.clock.now())
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._handlers: dict[tuple[str, str], MessageHandler] = {}
        self._listened: dict[tuple[str, str], Endpoint] = {}
        self._follows_gateways = False
        self._subscriptions: dict[str, Subscription[RawMessage]] = {}
        self._gateways: dict[str, Client[SubscribeToTopicRequest, SubscribeToTopicResponse]] = {}
        self._commands: dict[str, Publisher[RawCommand]] = {}

    async def find(self, service_type: str = "") -> tuple[Device, ...]:
        """Return the devices that offer *service_type* (all when it is empty), sorted by id.

        Raises:
            ServiceError: The directory does not answer.
        """
        return (await self._find.call(FindDevicesRequest(service_type=service_type))).devices

    def follow(self, service_type: str = "") -> Follow:
        """Return a live query: ``async for change in devices.follow("lights")``; see :class:`Follow`."""
        return Follow(self._node, service_type)

    async def listen(self, device: Device, handler: MessageHandler) -> None:
        """Call *handler* with every raw message of *device*, in order, one at a time.

        What the device said since this node came into being is included, as far as its gateway still has it, and so is
        the state that the broker keeps of it. A second call replaces the handler.

        Raises:
            RefusedError: A gateway of the device does not deliver.
            ServiceError: It does not answer.
        """
        for endpoint in device.endpoints:
            request = SubscribeToTopicRequest(topic=endpoint.address, listener=self._node.full_name, since=self._since)
            response = await self._gateway(endpoint.gateway).call(request)
            if not response.success:
                raise RefusedError(f"listening to {device.id}", response.message)
            self._handlers[endpoint.gateway, endpoint.key] = handler
            self._subscribe(response.data_topic, response.missed)

    async def tell(self, device: Device, payload: str) -> None:
        """Send *payload* to *device* through its first endpoint that takes commands.

        It returns when the gateway has the command in its queue; that the device obeyed is not proven by it.

        Raises:
            RefusedError: The device takes no commands.
        """
        for endpoint in device.endpoints:
            if endpoint.command_address:
                out = self._out(endpoint.gateway)
                await out.send(RawCommand(address=endpoint.command_address, payload=payload))
                return
        raise RefusedError(f"a command to {device.id}", "it takes none")

    async def _ask(self, endpoint: Endpoint) -> None:
        request = SubscribeToTopicRequest(topic=endpoint.address, listener=self._node.full_name, since=self._since)
        response = await self._gateway(endpoint.gateway).call(request)
        if not response.success:
            raise RefusedError(f"listening to {endpoint.address}", response.message)
        self._subscribe(response.data_topic, response.missed)

    def _follow_gateways(self) -> None:
        if not self._follows_gateways:
            self._follows_gateways = True
            self._node.create_task(self._ask_again)

    async def _ask_again(self) -> None:
        """A gateway that was restarted has forgotten who listens."""
        with self._node.graph.watch() as changes:
            async for change in changes:
                if change.change == "added" and change.entity.kind is EntityKind.SERVICE:
                    for endpoint in list(self._listened.values()):
                        if GatewayNames(endpoint.gateway).subscribe == change.entity.name:
                            await self._ask(endpoint)

    def _gateway(self, gateway: str) -> Client[SubscribeToTopicRequest, SubscribeToTopicResponse]:
        if gateway not in self._gateways:
            self._gateways[gateway] = self._node.create_client(SubscribeToTopic, GatewayNames(gateway).subscribe)
        return self._gateways[gateway]

    def _out(self, gateway: str) -> Publisher[RawCommand]:
        if gateway not in self._commands:
            self._commands[gateway] = self._node.create_publisher(
                RawCommand, GatewayNames(gateway).out, _COMMANDS_DEPTH
            )
        return self._commands[gateway]

    def _subscribe(self, topic: str, missed: tuple[RawMessage, ...]) -> None:
        """No other task runs between the gateway's answer and this, so nothing is lost and nothing comes twice."""
        if topic not in self._subscriptions:
            self._subscriptions[topic] = self._node.create_subscription(RawMessage, topic, self._dispatch, _INBOX_DEPTH)
        for message in missed:
            self._subscriptions[topic].mailbox.put(message)

    def _dispatch(self, message: RawMessage) -> Awaitable[None] | None:
        handler = self._handlers.get((message.gateway, message.key))
        return handler(message) if handler else None
