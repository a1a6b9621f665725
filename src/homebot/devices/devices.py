"""An application's access to devices: find, follow, listen and command."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from functools import cached_property, partial
from typing import ParamSpec, TypeAlias, TypeVar, overload

import anyio.lowlevel

from homebot.devices.device import Device, check_gateway
from homebot.devices.device_types import wanted_types
from homebot.devices.exposure import ExposedDevice, Exposure
from homebot.devices.follow import Follow
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.handles.follow import FollowHandles
from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import HandleQuery, HandleType
from homebot.devices.handles.messages import HandleMessages
from homebot.devices.house_view import HouseView
from homebot.devices.names import FIND_DEVICES, GatewayNames
from homebot.devices.query.terms import And, type_is
from homebot.devices.services import (
    FindDevices,
    FindDevicesRequest,
    SubscribeToTopic,
    SubscribeToTopicRequest,
    SubscribeToTopicResponse,
)
from homebot.errors import ClosedError, RefusedError, ServiceError, ServiceUnavailableError, UsageError
from homebot.graph import Client, Node, Subscription
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.log import LogLimit
from homebot.messages import Time

P = ParamSpec("P")
HandleT = TypeVar("HandleT", bound=Handle)

MessageHandler: TypeAlias = Callable[[RawMessage], Awaitable[None] | None]

NOT_HEARD = "devices.not_heard"

_INBOX_DEPTH = 10_000
_QUERY_WORDS = frozenset({"and", "in", "not", "or", "with", "without"})


class Devices:
    """One node's access to the devices of the house; an app has it as ``self.devices``.

    Queries and subscriptions made here belong to the node and end with it.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._since = self._clock.monotonic()
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._handlers: dict[tuple[str, str], tuple[str, MessageHandler]] = {}  # with the id of the device
        self._listened: dict[str, set[str]] = {}
        self._subscriptions: dict[str, Subscription[RawMessage]] = {}
        self._gateways: dict[str, Client[SubscribeToTopicRequest, SubscribeToTopicResponse]] = {}
        self._limit = LogLimit(node.graph.clock)

    @overload
    async def find(self, service_type: str = "") -> tuple[Device, ...]: ...

    @overload
    async def find(
        self, service_type: HandleType[P, HandleT], *none: P.args, **query: P.kwargs
    ) -> tuple[HandleT, ...]: ...

    async def find(
        self, service_type: str | HandleType[P, HandleT] = "", *none: P.args, **query: P.kwargs
    ) -> tuple[Device, ...] | tuple[HandleT, ...]:
        """Return the handles of a kind that match now, or the devices that offer a service type, sorted by id.

        An app starts before its devices are known; :meth:`follow` yields both present and future ones. With
        ``near="robot"``, those nearest to the robot come first. If nothing in the house has the type, area, tag, name
        or robot, none is found; 10 seconds later the log and ``homebot doctor`` say so, with the one that was probably
        meant, and a test with the fixture ``house`` or ``homebot`` fails; not if the house may lack them:
        ``optional=True``.

        Args:
            service_type: A kind of handle, for example :class:`Light`; or a service type, for example ``"lights"``,
                empty for all devices.
            none: Not used: conditions are given by name.
            query: The conditions, all of which must hold, for example ``area="kitchen", on=True``; each kind documents
                its own.

        Raises:
            TypeError: The kind has no such condition; the message suggests the nearest one.
            ValueError: A condition does not accept the value, or the service type is a sentence.
            RefusedError: The position of the robot is unknown now; the message says how old its last pose is.
            ServiceError: The directory did not answer.
        """
        if isinstance(service_type, str):
            _check_plain(service_type, none, query)
            devices = (await self._find.call(FindDevicesRequest(service_type=service_type))).devices
            if service_type and not devices:
                self._view.names.add(type_is(service_type), f"find({service_type!r})")
            return devices
        wanted = _check_kind(service_type).where(*none, **query)
        find = self._view.find if wanted.near is None else self._view.find_near
        answer = await find(wanted.search)
        handles: list[HandleT] = []
        for device in answer.devices:
            if parts := wanted.parts(device):
                handles += self._handles_of(device, answer.sequence, wanted.kind, parts)
        names = wanted.names if wanted.near is None else (*wanted.names, wanted.near)
        if names and not handles:
            self._view.names.add(And(names), _call_text("find", wanted, query))
        return tuple(handles)

    @overload
    def follow(self, service_type: str = "") -> Follow: ...

    @overload
    def follow(
        self, service_type: HandleType[P, HandleT], *none: P.args, **query: P.kwargs
    ) -> FollowHandles[HandleT, P]: ...

    def follow(
        self, service_type: str | HandleType[P, HandleT] = "", *none: P.args, **query: P.kwargs
    ) -> Follow | FollowHandles[HandleT, P]:
        """Return a live query: ``async for change in devices.follow("lights")``, or ``devices.follow(Light, on=True)``.

        Arguments, errors and reports of misspelt names are those of :meth:`find`; the query waits for a device that
        has the name. With ``near="robot"`` the query is repeated when the robot has moved 0.1 m, at most twice a
        second, and at once when a door changes. The first form yields :class:`DeviceChange` (see :class:`Follow`), the
        second :class:`HandleChange` (see :class:`FollowHandles`).
        """
        if isinstance(service_type, str):
            _check_plain(service_type, none, query)
            return Follow(self._node, service_type)
        wanted = _check_kind(service_type).where(*none, **query)
        return FollowHandles(self._node, wanted, _call_text("follow", wanted, query))

    def messages(self, kind: HandleType[P, HandleT], *none: P.args, **query: P.kwargs) -> HandleMessages[HandleT]:
        """Return a live query for the raw messages of the devices with such a handle, as ``message`` changes.

        A message whose values are already known is left out, so that with :meth:`follow` each report comes once. Use
        :meth:`listen` for every message.
        """
        return HandleMessages(self._node, self.follow(kind, *none, **query), self.listen)

    def offer(self, offer: ExposedDevice, gateway: str = "mqtt") -> Exposure:
        """Expose something to the other systems of the house: ``with devices.offer(robot) as offering``.

        Args:
            gateway: The gateway that publishes it. The MQTT gateway needs ``publish = true`` in
                ``[gateways.mqtt.homeassistant]``.

        Returns:
            An object that reports its state and yields commands of other systems; leaving the block withdraws it.
        """
        return Exposure(self._node, offer, gateway)

    async def listen(self, device: Device, handler: MessageHandler) -> None:
        """Call *handler* with every raw message of *device*, in order, one at a time.

        Messages since this node was created are delivered first, if the gateway still has them, and so is a retained
        state. A second call replaces the handler; no message is delivered twice. A gateway that is not running is asked
        when it starts, and again after each restart.

        Args:
            handler: A function or coroutine function of one :class:`RawMessage`.

        Raises:
            RefusedError: A gateway of the device does not deliver raw messages; the other ones are still listened to.
            ServiceError: A gateway of the device did not answer; the other ones are still listened to.
        """
        problem: RefusedError | ServiceError | None = None
        for endpoint in device.endpoints:
            try:
                check_gateway(endpoint)
                if endpoint.address not in self._listened.get(endpoint.gateway, ()):
                    await self._listen_to(endpoint.gateway, endpoint.address)
                self._handlers[endpoint.gateway, endpoint.key] = device.id, handler
            except (RefusedError, ServiceError) as exc:
                problem = problem or exc
        if problem is not None:
            raise problem

    async def listen_to(self, address: str, handler: MessageHandler, gateway: str = "mqtt") -> None:
        """Call *handler* with every raw message on an *address*, such as any MQTT topic; see :meth:`listen`.

        Raises:
            RefusedError: The gateway does not deliver raw messages.
            ServiceError: The gateway did not answer.
        """
        self._handlers[gateway, address] = address, handler
        await self._listen_to(gateway, address)

    async def tell(self, device: Device, payload: str) -> tuple[str, ...]:
        """Send the text *payload*, for example ``on``, through the first endpoint that accepts commands.

        Policies check it as the command that it stands for. A text that cannot be decoded is checked as ``use`` of the
        device, and refused for a device that always asks.

        It returns once the gateway has queued the command. The device's next report shows whether it obeyed. A text
        reaches one part of a device; to reach others, use their handles (:meth:`handles`).

        Returns:
            The names of other parts that would have accepted the text but did not get it, such as the other gangs of a
            wall switch.

        Raises:
            RefusedError: The device accepts no commands, its gateway only observes, or a policy or lease refuses it.
            LinkError: No gateway of the device is running and connected, or the control layer is away; nothing was
                sent.
        """
        return await self._view.commander.send_text(device, payload)

    def handles(self, device: Device, kind: HandleType[..., HandleT], sequence: int = 0) -> tuple[HandleT, ...]:
        """Return the handles of *kind* that *device* has, without asking the directory.

        Args:
            sequence: The ``sequence`` of the :class:`DeviceChange` that contained *device*; 0 if there was none.
        """
        query = kind.where()
        return tuple(self._handles_of(device, sequence, query.kind, query.parts(device)))

    def _handles_of(self, device: Device, sequence: int, kind: type[HandleT], parts: list[str]) -> list[HandleT]:
        view = self._view.store(device, sequence)
        return [kind(view, part, self._view) for part in parts]

    @cached_property
    def _view(self) -> HouseView:
        return HouseView.of(self._node)

    async def _listen_to(self, gateway: str, address: str) -> None:
        if gateway not in self._listened:
            self._listened[gateway] = set()
            self._node.create_task(partial(self._renew_requests, gateway))
        self._listened[gateway].add(address)
        try:
            await self._request_messages(gateway, address)
        except ServiceUnavailableError:
            return  # it is asked when it starts
        except BaseException:
            self._listened[gateway].discard(address)
            raise

    async def _request_messages(self, gateway: str, address: str) -> None:
        since = Time.from_seconds(
            self._clock.now() - (self._clock.monotonic() - self._since)
        )  # by the present setting of the clock
        request = SubscribeToTopicRequest(
            topic=address,
            listener=self._node.full_name,
            since=since,
            undeclared=(gateway, address) in self._handlers,
        )
        if gateway not in self._gateways:
            self._gateways[gateway] = self._node.create_client(SubscribeToTopic, GatewayNames(gateway).subscribe)
        response = await self._gateways[gateway].call(request)
        if not response.success:
            raise RefusedError(f"listening to {address}", response.message)
        # no other task has run since the gateway's answer, so nothing is lost or duplicated
        if response.data_topic not in self._subscriptions:
            self._subscriptions[response.data_topic] = self._node.create_subscription(
                RawMessage, response.data_topic, self._dispatch, _INBOX_DEPTH
            )
        for message in response.missed:
            self._subscriptions[response.data_topic].mailbox.put(message)

    async def _renew_requests(self, gateway: str) -> None:
        """Ask again, because a restarted gateway has forgotten its subscribers; asking twice is harmless."""
        async for _ in self._node.graph.watch_services(GatewayNames(gateway).subscribe):
            for address in sorted(self._listened[gateway]):
                await self._try_to_request(gateway, address)
                await anyio.lowlevel.checkpoint()

    async def _try_to_request(self, gateway: str, address: str) -> None:
        try:
            await self._request_messages(gateway, address)
        except (ServiceUnavailableError, ClosedError):
            return  # the gateway is gone again, and is asked when it starts; or this node is closed
        except (RefusedError, ServiceError) as exc:
            if self._limit.allows(NOT_HEARD) is not None:
                self._node.log.warning(NOT_HEARD, message=f"{address} is no longer received: {exc}", address=address)

    def _dispatch(self, message: RawMessage) -> Awaitable[None] | None:
        handlers = self._handlers
        registered = handlers.get((message.gateway, message.key)) or handlers.get((message.gateway, message.address))
        if registered is None:
            return None
        device_id, handler = registered
        CURRENT_CAUSE.set((device_id, message))
        return handler(message)


def _call_text(name: str, query: HandleQuery[HandleT], conditions: Mapping[str, object]) -> str:
    """Return a call as the app wrote it."""
    given = (f"{key}={value!r}" for key, value in conditions.items())
    return f"{name}({', '.join((query.kind.__name__, *given))})"


def _check_kind(kind: HandleType[P, HandleT]) -> HandleType[P, HandleT]:
    if not hasattr(kind, "where"):
        raise UsageError(f"{kind!r:.60} is neither a kind of handle, such as Light, nor a type of device as text")
    return kind


def _check_plain(service_type: str, extra: tuple[object, ...], conditions: Mapping[str, object]) -> None:
    if extra or conditions:
        given = ", ".join([*(repr(term) for term in extra), *conditions])
        raise TypeError(
            f"{service_type!r} is a type name, which takes no filters ({given}); ask for a kind of handle, "
            f"for example find(Light, area='kitchen')"
        )
    if not _QUERY_WORDS.isdisjoint(service_type.casefold().split()) and not wanted_types(service_type):
        raise ValueError(
            f"{service_type!r} is a sentence, not a type of device; ask for a kind of handle with conditions, for "
            f"example find(Light, area='kitchen')"
        )
