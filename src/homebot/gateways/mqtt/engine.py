"""Announced MQTT devices: discovery, state and commands.

The receiving task handles all messages in the broker's order. The tasks of :meth:`AnnouncedDevices.serve` do whatever
waits: subscriptions, requests, expiry of values.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator
from functools import partial
from itertools import chain
from typing import TypeVar

import anyio
import anyio.lowlevel

from homebot.clock import TimeSlice
from homebot.conventions.convention import Convention, HintingConvention, ProblemReportingConvention, TextConvention
from homebot.conventions.description import begin_message
from homebot.conventions.payload import MAX_LONG_STATE_BYTES, MAX_STATE_BYTES
from homebot.devices import RawCommand, RawMessage
from homebot.devices.approval_messages import ApprovedCommands
from homebot.devices.health import Count, HealthResponse
from homebot.devices.names import APPROVED_COMMANDS
from homebot.errors import WireError
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader
from homebot.gateways.announced.command_server import CommandServer
from homebot.gateways.announced.engine import GatewayEngine
from homebot.gateways.announced.last_messages import LastMessageCache
from homebot.gateways.announced.registry import Readers, RegistryLimits
from homebot.gateways.announced.work_budget import WorkBudgets
from homebot.gateways.base import Gateway
from homebot.gateways.mqtt.acting_lease import ActingLease
from homebot.gateways.mqtt.command_publisher import CommandPublisher, Responses
from homebot.gateways.mqtt.intake import AnnouncementHandler
from homebot.gateways.mqtt.offers import Offers, publishers_of
from homebot.gateways.mqtt.registry import AnnouncementRegistry, TopicReaders
from homebot.gateways.mqtt.reserved import ReservedTopics
from homebot.gateways.mqtt.settings import MqttGatewaySettings
from homebot.gateways.mqtt.state_topics import StateTopics, prefix_of
from homebot.gateways.mqtt.subscriber import Subscriber
from homebot.graph import qos_profile_latched
from homebot.mqtt.client import MqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES
from homebot.mqtt.topic_census import TopicCensus
from homebot.mqtt.topics import validate_topic
from homebot.support.counters import Severity
from homebot.support.isolation import run_as

T = TypeVar("T")


class AnnouncedDevices:
    """The engine of an MQTT gateway, which makes devices of announcements; also its :class:`RawMessages`.

    Attributes:
        text_filters: The filters of texts that devices publish.
        route: Returns the readers of a topic, or None.
        tick: Reads the clock; called once before each batch of messages.
        census: A count of all topics on the broker.
    """

    def __init__(
        self,
        gateway: Gateway,
        conventions: tuple[Convention, ...],
        connection: MqttConnection,
        lease: ActingLease,
        settings: MqttGatewaySettings,
        make_client: Callable[[MqttOptions], MqttClient],
        responses: Responses | None = None,
    ) -> None:
        self._responses = responses
        self._lease = lease
        self._conventions = conventions
        self._owner = gateway.node.full_name
        self._connection = connection
        self.filters, self.text_filters = (_filters(conventions, of_texts=of_texts) for of_texts in (False, True))
        self._topics = StateTopics(self.filters, self.text_filters)
        publishers = publishers_of(conventions, gateway.node.name, connection)
        own_commands = chain.from_iterable(publisher.filters() for publisher in publishers)
        reserved = ReservedTopics(conventions, own_commands)
        limits = RegistryLimits(memory=settings.max_memory)
        self._registry = AnnouncementRegistry(gateway.node.name, conventions, self._topics, limits, reserved)
        engine: GatewayEngine[MqttMessage] = GatewayEngine(
            gateway,
            self._registry.by_key,
            stale_after=settings.stale_after,
            inboxes=settings.delivery == "inbox",
            budgets=WorkBudgets(prefix_of(self.filters)),
            log_key="topic",
        )
        self.counters, self.quarantine = engine.counters, engine.quarantine
        self.find_part = engine.find_part
        self._listeners, self._reporter, self._states = engine.listeners, engine.reporter, engine.states
        self.tick = self._reporter.refresh_time
        self.route = self._registry.route
        self.read_text = self._states.read_text
        self.census = TopicCensus(make_client, settings.options())
        self._last_messages = LastMessageCache()
        self._taking = asyncio.Lock()  # anyio's costs as much as a tenth of an announcement
        self._subscriber = Subscriber(engine, self._topics, self._registry, conventions)
        self._announcements = AnnouncementHandler(
            gateway.node.graph.clock, engine, self._registry, reserved, self._subscriber
        )
        gateway.node.create_subscription(
            ApprovedCommands,
            APPROVED_COMMANDS,
            lambda approved: self._registry.set_approved(approved.digests),
            qos_profile_latched,
        )
        self.offers = Offers(gateway, publishers, self.quarantine)
        publisher = CommandPublisher(engine, connection, self.census, self._subscriber.question, responses)
        self.texts = CommandServer(
            engine, publisher.perform, self, self._health, keeps_states=False, refresh=publisher.refresh
        )

    async def serve(self) -> None:
        """Subscribe, send requests and expire values until cancelled."""
        async with anyio.create_task_group() as tasks:
            for work in (
                partial(self._subscriber.run, self._connection),
                partial(self.offers.serve, self._connection),
                partial(self.quarantine.serve, self._handle_next),
            ):
                tasks.start_soon(run_as, self._owner, work)

    async def handle_message(self, message: MqttMessage, route: TopicReaders, *, raw: bool = True) -> None:
        """Handle a message on a topic of *route*; a device that it announces also reads it.

        An empty message removes a device that publishes text.

        Args:
            raw: Whether to deliver its bytes to the listeners of the topic itself.
        """
        topic, payload, waits = message.topic, message.payload, message.qos > 0
        if route.texts:
            self._announcements.handle_text(message, route.texts)
            route = self.route(topic) or route
        if route.conventions:
            await self.handle_announcement(message, route)
            if self._registry.is_read(topic):
                route = self.route(topic) or route
        if route.text is not None:
            raw = False
            if payload:
                await self._states.read_text(topic, payload, route.text, retained=message.retain, wait_if_full=waits)
            else:
                self._announcements.remove(route.text.stored.key, "its retained message was deleted")
        if not route.announced_parts and not route.availability_readers:
            return
        if raw:
            self.counters.received += 1
        reporter = self._reporter
        self._last_messages.put(topic, payload, reporter.stamp, reporter.now, retained=message.retain)
        await self._states.read(
            topic,
            payload,
            route.announced_parts,
            route.availability_readers,
            retained=message.retain,
            wait_if_full=waits,
            longest=MAX_LONG_STATE_BYTES if route.conventions else MAX_STATE_BYTES,
        )
        if raw and route.announced_parts:
            await self._deliver_raw(message, route)

    def read_states(self, message: MqttMessage, route: TopicReaders, work: TimeSlice) -> Awaitable[None] | None:
        """Handle a message on a topic that only parts read, mostly without waiting.

        Returns:
            What remains when *work* is over, and the deliveries to listeners; None if there is neither.
        """
        topic, payload, _, retained, _, _ = message
        reporter = self._reporter
        self.counters.received += 1
        self._last_messages.put(topic, payload, reporter.stamp, reporter.now, retained=retained)
        if len(payload) > MAX_STATE_BYTES:
            self.counters.oversize += 1
            return None
        begin_message()
        parts = route.announced_parts
        steps = self._states.read_parts(topic, payload, parts, work if len(parts) > 1 else None, retained=retained)
        for first in steps:
            return self._go_on(chain((first,), steps), message, route, work)
        return self._deliver_raw(message, route) if self._listeners.by_address.get(topic) else None

    async def _go_on(
        self, steps: Iterable[RawMessage | None], message: MqttMessage, route: TopicReaders, work: TimeSlice
    ) -> None:
        for text in steps:
            if text is None:
                await work.pause()
            else:
                await self._listeners.deliver(text, wait_if_full=message.qos > 0)
        await self._deliver_raw(message, route)

    async def _deliver_raw(self, message: MqttMessage, route: TopicReaders) -> None:
        topic = message.topic
        if self._listeners.by_address.get(topic):
            raw_text = self._raw(route.announced_parts[0], topic, message.payload, retained=message.retain)
            await self._listeners.deliver(raw_text, wait_if_full=message.qos > 0)

    async def handle_announcement(self, message: MqttMessage, route: TopicReaders) -> None:
        """Handle a message only as an announcement, unless it is one of homebot's own."""
        if self.offers.publishes and self.offers.is_own_topic(message.topic):
            return
        async with self._taking:  # our own announcement waits for the end of a long one
            if not message.payload:  # a withdrawal never waits
                self.quarantine.waiting.drop(message.topic)
            elif self.quarantine.must_wait(message, message.topic, message.payload):
                return
            missed = await self._announcements.handle(message, route.conventions)
        if missed:
            await self._replay_retained(missed, message.topic)

    def send_raw(self, command: RawCommand) -> Awaitable[object]:
        """Publish *command* when awaited; for a text device, expect the same text as its answer."""
        address, payload = command.address, command.payload.encode()
        codec = self._registry.codecs.get(address)
        if codec is not None:
            codec.expect(payload)
        route = self.route(address)
        if route is not None and route.conventions:
            return self._send_announcement(MqttMessage(address, payload, command.qos, command.retain), route)
        properties = NO_PROPERTIES if self._responses is None else self._responses.named(command.command_id)
        return self._connection.publish(address, payload, qos=command.qos, retain=command.retain, properties=properties)

    def find_source(self, address: str, *, undeclared: bool) -> tuple[str, str]:
        """Return key and name of the device that publishes on the topic *address*, even if it has not done so yet."""
        validate_topic(address)
        if (route := self.route(address)) is not None:
            for announced_part in (route.text, *route.announced_parts):
                if announced_part is not None:
                    return announced_part.stored.key, announced_part.stored.described.name or announced_part.stored.key
            for convention in route.texts:
                device = convention.announced(address) if isinstance(convention, TextConvention) else None
                if device is not None:
                    return device.full_key, device.name
        if not undeclared:
            raise WireError(f"no device publishes on topic {address!r}")
        self._subscriber.wake()
        return self._registry.put_address(address)

    def missed_by(self, address: str, since: float) -> tuple[RawMessage, ...]:
        """Return the kept messages on a topic since *since*, on the monotonic clock, for a new listener."""
        route, word = self._registry.route(address), self._last_messages.get(address)
        if route is not None and route.text is not None:
            return route.text.missed_by(since, self._reporter.now)
        if route is None or not route.announced_parts or word is None or (not word.retained and word.heard_at < since):
            return ()
        message = self._raw(route.announced_parts[0], address, word.payload, retained=word.retained)
        return (message.model_copy(update={"received_at": word.at}),)

    async def _send_announcement(self, message: MqttMessage, route: TopicReaders) -> None:
        """Publish *message* and handle it, as no broker returns our own announcement."""
        await self._connection.publish(message.topic, message.payload, qos=message.qos, retain=message.retain)
        self.tick()
        await self.handle_announcement(message._replace(retain=False), self.route(message.topic) or route)

    async def _handle_next(self, messages: Iterator[MqttMessage]) -> bool:
        """Handle the next deferred message that is due; return whether there was one."""
        async with self._taking:
            message = next(messages, None)
            if message is None:
                return False
            route = self.route(message.topic)
            if route is None or not route.conventions or self.offers.is_own_topic(message.topic):
                return True
            missed = await self._announcements.handle(message, route.conventions)
        await self._replay_retained(missed, message.topic)
        after = self.route(message.topic)
        if after is not None:  # a device that it announced reads it as a retained message
            await self._states.read(
                message.topic,
                message.payload,
                _new(after.announced_parts, route.announced_parts),
                _new(after.availability_readers, route.availability_readers),
                retained=True,
                wait_if_full=False,
                longest=MAX_LONG_STATE_BYTES,
            )
        return True

    async def _replay_retained(self, missed: Readers, taken: str) -> None:
        """Deliver retained messages of topics with a subscription, for which the broker does not send them again.

        Args:
            taken: The topic of the message just handled.
        """
        for topic, reader in missed:
            word = self._last_messages.get(topic)
            if topic == taken or word is None or not self._registry.commands.readable(topic, (reader,)):
                continue
            parts, readers = ((), (reader,)) if isinstance(reader, AvailabilityReader) else ((reader,), ())
            await self._states.read(topic, word.payload, parts, readers, retained=True, wait_if_full=False)

    def _raw(self, announced_part: AnnouncedPart, topic: str, payload: bytes, *, retained: bool) -> RawMessage:
        return RawMessage(
            gateway=announced_part.stored.gateway,
            key=announced_part.stored.key,
            address=topic,
            payload=payload,
            retained=retained,
            received_at=self._reporter.stamp,
        )

    def _used_topics(self) -> Iterator[str]:
        yield from self._topics.users
        for stored in self._registry.by_key.values():
            for part in stored.parts.values():
                yield from (*part.described.part.reads, *part.described.part.writes)

    def _health(self) -> HealthResponse:
        from homebot.gateways.mqtt.unread_topics import unread_notes  # noqa: PLC0415 - few runs are asked

        counts = {
            "announcements_excess_bytes": self._registry.excess,
            "announcements_memory_bytes": self._registry.memory,
        }
        losses = (count for count in Count.of(self._connection.counters) if count.severity is Severity.LOSS)
        responses = () if self._responses is None else Count.of(self._responses.counters)
        troubled = (
            convention for convention in self._conventions if isinstance(convention, ProblemReportingConvention)
        )
        troubles = tuple(trouble for convention in troubled for trouble in convention.problems())
        rivals = (self._lease.trouble,) if self._lease.trouble else ()
        hints = [convention.hint for convention in self._conventions if isinstance(convention, HintingConvention)]
        notes = tuple(unread_notes(self.census.counts, self.route, self._used_topics(), self.filters, hints))
        return HealthResponse(
            counts=(*Count.each(counts), *losses, *responses), troubles=(*rivals, *troubles), notes=notes
        )


def _filters(conventions: Iterable[Convention], *, of_texts: bool) -> tuple[str, ...]:
    filters = (convention.filters() for convention in conventions if isinstance(convention, TextConvention) is of_texts)
    return tuple(dict.fromkeys(chain.from_iterable(filters)))


def _new(after: tuple[T, ...], before: tuple[T, ...]) -> tuple[T, ...]:
    known = {id(item) for item in before}
    return tuple(item for item in after if id(item) not in known)
