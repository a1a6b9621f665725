"""The MQTT gateway: hears devices on a broker, and sends them the commands of the graph.

Messages are handled in the broker's order, in batches. One of QoS 1 or 2 is acknowledged only after every listener has
it in its queue; until then it is the broker's, which sends it again should this process die.
"""

from __future__ import annotations

import platform
import re
from collections.abc import Iterable
from functools import partial
from typing import ClassVar, Literal

import anyio
import anyio.lowlevel
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.conventions.convention import TopicDevice
from homebot.conventions.payload import MAX_LONG_STATE_BYTES
from homebot.devices import RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.text.encode import read_text_address
from homebot.errors import ClosedError, HomebotError, LinkError, RefusedError, WireError
from homebot.gateways.announced.reporter import REFRESH, stamps
from homebot.gateways.base import Gateway
from homebot.gateways.context import GatewayContext, HostService
from homebot.gateways.mqtt.acting_lease import ActingLease
from homebot.gateways.mqtt.channels import Channel, Channels
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.gateways.mqtt.embedded_broker import EMBEDDED_BROKER
from homebot.gateways.mqtt.engine import AnnouncedDevices
from homebot.gateways.mqtt.link_report import LinkReport
from homebot.gateways.mqtt.loaded_conventions import find_conventions
from homebot.gateways.mqtt.registry import TopicReaders
from homebot.gateways.mqtt.settings import EMBEDDED, MqttGatewaySettings
from homebot.gateways.raw_delivery import RawDelivery, begin_of
from homebot.graph import EntityKind, Node
from homebot.isolation import run_as
from homebot.messages import Time
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.hosted_broker import HostedBroker
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.topics import topic_matches, validate_topic

__all__ = ["GatewayCounters", "MqttGateway"]

REJECTED = "gateway.message_rejected"
GHOST = "gateway.retained_only"
OVERSIZE = "gateway.oversize"
COMMAND_REFUSED = "gateway.command_refused"
COMMAND_FAILED = "gateway.command_failed"

_OUT_DEPTH = 1000

_TURN = 200
"""Messages handed over before their readers get a turn: below the 256 that a reader takes in one, so that a burst of
QoS 0 does not overrun an inbox whose reader keeps up."""

_ANNOUNCEMENT = 25
"""Messages that an announcement counts for in that: it is as much work, and those of a whole house come at once, which
the broker must be able to get rid of."""


class MqttGateway(Gateway):
    """Brings the devices on one MQTT broker onto the graph.

    Args:
        node: Its node.
        settings: Its table.
        context: What its host gives it; a :class:`homebot.mqtt.hosted_broker.HostedBroker` in memory makes the client.

    Attributes:
        counters: What it did.
    """

    Settings: ClassVar[type[BaseModel]] = MqttGatewaySettings

    def __init__(
        self,
        node: Node,
        settings: MqttGatewaySettings,
        context: GatewayContext | None = None,
    ) -> None:
        """Make the gateway; nothing is connected before :meth:`serve`.

        Raises:
            UsageError: The settings cannot be used, for example because a password file is missing.
            PluginError: A convention cannot be loaded.
        """
        super().__init__(node, settings, context)
        random, hosted = self.context.random, self.context.service(HostedBroker)
        make_client = (hosted and hosted.make_client) or AiomqttClient
        computer = (hosted and hosted.computer) or platform.node()
        self.acts = bool(settings.act)
        self.counters = GatewayCounters()
        self._settings = settings
        self._clock = node.graph.clock
        understood = find_conventions(settings.conventions, settings.tables, settings.root)
        self._layouts = understood.layouts
        self._filters = self._layout_filters()
        self._channels = Channels(self._layouts)
        self._listeners = RawDelivery(node, self.names, inboxes=settings.delivery == "inbox")
        # A name that lasts, unlike the client id, or each run would leave one more topic at the broker for ever.
        status_topic = f"homebot/{_topic_level(computer)}/{node.name}/status"
        self._connection = MqttConnection(
            settings.options(), make_client, status_topic=status_topic, clock=self._clock, random=random
        )
        self._lease = ActingLease(self, self._connection, settings.root, f"{node.name} on {computer}", random)
        self._described = AnnouncedDevices(
            self,
            understood.conventions,
            understood.layouts,
            self._layout_filters(),
            self._channels,
            self._listeners,
            self._connection,
            self.counters,
            settings.stale_after,
            self._lease,
            settings.max_memory,
        )
        self._plain = self._described.plain
        self._warn = self._described.tribunal.log_limited
        node.create_subscription(RawCommand, self.names.out, self._send, _OUT_DEPTH, concurrent=True)
        node.create_service(SubscribeToTopic, self.names.subscribe, self._subscribe)
        if node.name == "mqtt":
            node.create_service(SubscribeToTopic, "/subscribe_to_mqtt_topic", self._subscribe)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Find the conventions and read the credentials.

        Raises:
            UsageError: A convention cannot be loaded, a file cannot be read, or settings contradict each other.
        """
        if isinstance(settings, MqttGatewaySettings):
            find_conventions(settings.conventions, settings.tables, settings.root)
            settings.check_files()
            if settings.url != EMBEDDED:
                settings.options()

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:
        """Return the embedded broker where no address is given."""
        return (EMBEDDED_BROKER,) if isinstance(settings, MqttGatewaySettings) and settings.url == EMBEDDED else ()

    @classmethod
    def resolve(cls, settings: BaseModel, context: GatewayContext) -> BaseModel:
        """Take the address of the embedded broker, and a client id from the given source of random numbers.

        On the embedded broker only our own devices listen, so acting is the default.
        """
        if not isinstance(settings, MqttGatewaySettings):
            return settings
        if context.random is not None:
            settings = settings.with_client_id(f"homebot-{context.random.getrandbits(32):08x}")
        hosted = context.service(HostedBroker)
        if hosted is None or settings.url != EMBEDDED:
            return settings
        act = True if settings.act is None else settings.act
        return settings.model_copy(update={"url": hosted.url, "act": act})

    @classmethod
    def home(cls, settings: BaseModel) -> str:
        """Return the first level of its topics; empty for every home on the broker."""
        return settings.root if isinstance(settings, MqttGatewaySettings) else ""

    @classmethod
    def network(cls, settings: BaseModel) -> str:
        """Return the broker's host and port, without any credentials; ``embedded`` for homebot's own broker."""
        if not isinstance(settings, MqttGatewaySettings) or settings.url == EMBEDDED:
            return EMBEDDED
        options = MqttOptions.from_url(settings.url)
        return f"{options.host.lower()}:{options.port}"

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the link and handle what comes until cancelled; ready when the first try to connect has ended."""
        layouts, announcements = self._layout_filters(), self._described.filters()
        async with self._connection as connection, anyio.create_task_group() as tasks:
            await connection.subscribe(*(MqttSubscription(one, qos=1, no_local=True) for one in layouts))
            await connection.subscribe(
                *(MqttSubscription(one, no_local=True) for one in announcements), every_link=True
            )
            report = LinkReport(self, connection, self._listening_to(), (*layouts, *announcements))
            receive = partial(self._receive, connection)
            for work in (report.watch, self._described.serve, self._lease.serve, self._watch_nodes, receive):
                tasks.start_soon(run_as, self.node.full_name, work)
            await report.wait_for_first_try()
            task_status.started()

    async def _receive(self, connection: MqttConnection) -> None:
        while True:
            try:
                batch = await connection.receive()
            except ClosedError:
                return
            await self._handle(batch)
            connection.ack(batch)

    def _layout_filters(self) -> tuple[str, ...]:
        return tuple(one for layout in self._layouts for one in layout.filters())

    def _listening_to(self) -> str:
        return f"home {self._settings.root}" if self._settings.root else "every home"

    async def _watch_nodes(self) -> None:
        with self.node.graph.watch() as changes:
            lost = 0
            async for change in changes:
                is_removal = change.change == "removed" and change.entity.kind is EntityKind.NODE
                if is_removal or changes.lost > lost:
                    lost = changes.lost
                    while changes.take() is not None:
                        pass
                    for address in self._listeners.drop_nodes_that_left():
                        if self._channels.get(address) is None:
                            self._listeners.tidy(address)

    async def _handle(self, batch: Iterable[MqttMessage]) -> None:
        stamp, _ = stamps(self._clock.now(), self._settings.stale_after)
        now = self._clock.monotonic()
        self._described.tick()
        work = 0
        for message in batch:
            work += 1
            if work >= _TURN:
                work = 0
                await anyio.lowlevel.checkpoint()
            if self._lease.owns(message.topic):
                self._lease.take(message)
                continue
            if self._described.secrets.is_one(message.topic, message.payload):
                continue  # it has a code, which nobody who listens here is to see
            route, channel = self._described.route(message.topic), self._channels.get(message.topic)
            if len(message.payload) > self._settings.max_payload:
                work += await self._take_long(message, route)
                continue
            if route is not None or channel is None:
                work += 0 if route is None else _ANNOUNCEMENT * len(route.conventions) + len(route.voices)
                channel = await self._hear(message, route, channel)
            if channel is None:
                continue
            if not message.payload:
                self._forget(channel, stamp)
                continue
            self.counters.received += 1
            if now >= channel.refresh_at or (channel.retained_only and not message.retain):
                self._sight(channel, message, stamp)
                channel.refresh_at = now + REFRESH
            if message.payload != channel.last_payload and channel.decoder is not None:
                self._plain.hear(channel, message)
            raw = RawMessage(
                gateway=self.node.name,
                key=channel.device.key,
                address=message.topic,
                payload=message.payload,
                retained=message.retain,
                received_at=stamp,
            )
            channel.keep(raw, now)
            for listener in tuple(channel.listeners):  # one may come or go while another is waited for
                await self._listeners.deliver(listener, raw, wait_if_full=message.qos > 0)

    async def _hear(self, message: MqttMessage, route: TopicReaders | None, channel: Channel | None) -> Channel | None:
        """Let all hear *message* that understand more than topics; return its channel, which may be new."""
        if channel is None and (route is None or route.is_shared):
            if self._described.offers.take(message):
                return None
            channel = self._open(message)
        if route is not None:
            await self._described.hear(message, route, raw=channel is None)
        return channel

    async def _take_long(self, message: MqttMessage, route: TopicReaders | None) -> int:
        """Only what comes where devices are announced may be longer than the rest; return how much work it was."""
        work = 0
        if route is not None and route.conventions:
            work = _ANNOUNCEMENT * len(route.conventions)
            if len(message.payload) <= MAX_LONG_STATE_BYTES:
                await self._described.hear(message, route, raw=False)
                return work + len(route.voices)
            await self._described.take(message, route)
            if not route.voices and not route.witnesses:
                return work
        self.counters.oversize += 1
        self._warn(OVERSIZE, f"{len(message.payload)} bytes on {message.topic}", topic=message.topic)
        return work

    def _open(self, message: MqttMessage) -> Channel | None:
        try:
            device = self._channels.announced(message.topic) if self._is_layouts(message.topic) else None
            if device is None:
                return None
            return self._channels.open(message.topic, device, self._listeners.of(message.topic))
        except WireError as exc:
            self.counters.rejected += 1
            self._warn(REJECTED, f"not a device's message: {exc}", topic=message.topic)
            return None
        except BaseException as exc:  # noqa: BLE001 - told by the tribunal; a plug-in's fault must not be everybody's
            self._described.tribunal.record_plugin_failure(message.topic, "of the topic's layout", exc)
            return None

    def _is_layouts(self, topic: str) -> bool:
        """Return whether it comes by a subscription of a layout: what is there for conventions breaks no layout."""
        return any(topic_matches(one, topic) for one in self._filters)

    def _sight(self, channel: Channel, message: MqttMessage, stamp: Time) -> None:
        is_new = channel.refresh_at == 0.0
        if channel.retained_only and not message.retain:
            channel.last_payload = b""  # the same word is worth more now
        channel.retained_only = message.retain and (is_new or channel.retained_only)
        if is_new and message.retain:
            self._warn(
                GHOST,
                f"{channel.device.key} is known only from a message that the broker kept; it may be gone",
                topic=message.topic,
            )
        self.publish_sighting(
            self._sighting(
                "appeared" if is_new else "updated",
                "the broker keeps a message of it" if message.retain else f"it spoke on {message.topic}",
                channel.device,
                stamp,
                confirmed=not message.retain,
            )
        )

    def _forget(self, channel: Channel, stamp: Time) -> None:
        """An empty message clears what the broker keeps: the device was taken out of the house."""
        self._channels.close(channel.device.address)
        self._listeners.tidy(channel.device.address)
        self._plain.forget(channel)
        self.publish_sighting(self._sighting("removed", "its topic was cleared", channel.device, stamp, confirmed=True))

    def _sighting(
        self,
        kind: Literal["appeared", "updated", "removed"],
        why: str,
        device: TopicDevice,
        stamp: Time,
        *,
        confirmed: bool,
    ) -> Sighting:
        at, until = stamps(stamp.to_seconds(), self._settings.stale_after)
        return Sighting(
            gateway=self.node.name,
            key=device.key,
            kind=kind,
            why=why,
            name=device.name,
            service_type=device.service_type,
            address=device.address,
            command_address=device.command_address,
            metadata=device.metadata,
            parts=() if device.part is None else (device.part,),
            owns=_own_topics(device),
            seen_at=at,
            expires_at=until,
            confirmed=confirmed,
            heard_at=self._clock.monotonic(),
        )

    async def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        try:
            key, name = self._speaker(request.topic)
            is_new = not self._listeners.has(request.topic, request.listener)
            publisher = self._listeners.add(request.topic, key, name, request.listener)
        except HomebotError as exc:
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        channel = self._channels.get(request.topic)
        missed: tuple[RawMessage, ...] = ()
        if is_new:
            since = begin_of(request.since, self._clock)
            missed = channel.missed_by(since) if channel else self._described.missed_by(request.topic, since)
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=missed)

    def _speaker(self, address: str) -> tuple[str, str]:
        """Key and name of the device that speaks on *address*."""
        if (described := self._described.known(address)) is not None:
            return described
        validate_topic(address)
        device = self._channels.announced(address)
        if device is None:
            raise WireError(f"topic {address!r} is none that a device speaks on")
        return device.key, device.name

    async def _send(self, command: RawCommand) -> None:
        try:
            if (part := read_text_address(command.address)) is not None:
                await self._described.commands.tell(*part, command.payload)
            else:
                await self._publish(command)
            self.counters.commands += 1
        except LinkError as exc:
            self.counters.commands_failed += 1
            self._warn(COMMAND_FAILED, f"not sent to {command.address}: {exc}", topic=command.address)
        except HomebotError as exc:
            self.counters.commands_refused += 1
            self._warn(COMMAND_REFUSED, f"not sent to {command.address}: {exc}", topic=command.address)

    async def _publish(self, command: RawCommand) -> None:
        validate_topic(command.address)
        if not self.acts:
            raise RefusedError("the command", self.observes_because)
        payload = command.payload.encode()
        self._plain.told(command.address, command.payload)
        await self._connection.publish(command.address, payload, qos=command.qos, retain=command.retain)
        await self._described.overhear(MqttMessage(command.address, payload, command.qos, retain=False))


def _own_topics(device: TopicDevice) -> tuple[str, ...]:
    """In a layout the topic alone says whose it is, and so are those beside it."""
    place = device.address.rpartition("/")[0]
    if place and device.command_address.rpartition("/")[0] == place:
        return (place,)
    return (device.address, device.command_address) if device.command_address else (device.address,)


def _topic_level(text: str) -> str:
    return re.sub(r"[+#/\0]", "_", text) or "unknown"
