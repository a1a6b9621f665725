"""Subscriptions to the topics of described devices, and requests for their state, both at a limited rate."""

from collections.abc import Hashable
from functools import partial
from itertools import islice
from typing import TypeAlias

import anyio

from homebot.conventions.convention import Convention
from homebot.conventions.description import DeviceRequest, Publication
from homebot.errors import HomebotError, LinkError, RefusedError
from homebot.gateways.announced.announcement import StoredAnnouncement
from homebot.gateways.announced.engine import GatewayEngine
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.state_topics import StateTopics, pop_filters
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.support.isolation import isolated, run_as

NOT_HEARD = "gateway.state_not_heard"
NOT_ASKED = "gateway.not_asked"

BATCH = 100
"""Filters per request, so that their retained messages stay far below a broker's queue limit."""

ASK_EVERY = 0.02
"""Seconds between requests, so that a thousand devices do not answer at once."""

MAX_ASKS = 50_000
MAX_ASKS_EACH = 20


class Subscriber:
    """Keeps the subscriptions in line with the descriptions, all at QoS 0."""

    def __init__(
        self,
        engine: GatewayEngine[MqttMessage],
        topics: StateTopics,
        registry: AnnouncementRegistry,
        conventions: tuple[Convention, ...],
    ) -> None:
        self._topics = topics
        self._registry = registry
        self._conventions = conventions
        self._quarantine, self._counters = engine.quarantine, engine.counters
        self._needed = anyio.Event()
        self._asked = anyio.Event()
        self._asks_later: dict[Hashable, _Asks] = {}
        self._asks: dict[Hashable, _Asks] = {}
        self._linked = anyio.Event()

    def wake(self) -> None:
        """Check the topics in use again."""
        self._needed.set()

    def ask(self, stored: StoredAnnouncement) -> None:
        """Request the state of a device once its topics are subscribed to; includes :meth:`wake`."""
        self._needed.set()
        asks: dict[Publication, None] = {}
        for part in stored.parts.values():
            asks.update(dict.fromkeys(part.described.state_requests))
        for ask in islice(asks, MAX_ASKS_EACH):
            if len(self._asks_later) + len(self._asks) >= MAX_ASKS:
                self._counters.asks_dropped += 1
                return
            self._asks_later[ask] = (ask,)

    def question(self, question: DeviceRequest) -> None:
        """Ask a device to identify itself; a question replaces an earlier one with the same key."""
        if question.key not in self._asks and len(self._asks) >= MAX_ASKS:
            self._counters.asks_dropped += 1
            return
        self._asks[question.key] = question.publications[:MAX_ASKS_EACH]
        self._asked.set()

    async def run(self, connection: MqttConnection) -> None:
        """Subscribe, unsubscribe and send requests until cancelled."""
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._subscribe, connection)
            for work in (self._send_state_requests, self._on_connected):
                tasks.start_soon(run_as, "the gateway", partial(work, connection))

    async def _subscribe(self, connection: MqttConnection) -> None:
        with isolated("the gateway"):
            while True:
                await self._needed.wait()
                self._needed = anyio.Event()
                while self._topics.wanted:
                    await self._subscribe_to(connection, pop_filters(self._topics.wanted, BATCH))
                while self._topics.unwanted:
                    await connection.unsubscribe(*pop_filters(self._topics.unwanted, BATCH))
                self._asks.update(self._asks_later)
                self._asks_later.clear()
                if self._asks:
                    self._asked.set()

    async def _subscribe_to(self, connection: MqttConnection, filters: tuple[str, ...]) -> None:
        try:
            await connection.subscribe(*map(partial(MqttSubscription, no_local=True), filters), every_link=True)
        except RefusedError as exc:
            self._counters.topics_refused += sum(topic_filter in connection.refused for topic_filter in filters)
            self._quarantine.log_limited(NOT_HEARD, f"some devices are not received: {exc}", source=filters[0])
        if covered := tuple(filter(self._topics.is_covered, filters)):
            await connection.unsubscribe(*covered)

    async def _send_state_requests(self, connection: MqttConnection) -> None:
        while True:
            await self._linked.wait()
            if not self._asks:
                self._asked = anyio.Event()
                await self._asked.wait()
                continue
            for ask in self._asks.pop(next(iter(self._asks))):
                if not await self._publish(connection, ask):
                    self._asks.clear()  # the next link asks all again
                    break
                await anyio.sleep(ASK_EVERY)

    async def _on_connected(self, connection: MqttConnection) -> None:
        """Ask devices to announce themselves on each link, and on each but the first for their state."""
        is_first = True
        async for state in connection.states():
            if state.phase is not LinkPhase.CONNECTED:
                self._linked = anyio.Event() if self._linked.is_set() else self._linked
                continue
            self._linked.set()
            for convention in self._conventions:
                for birth in convention.birth_messages():
                    await self._publish(connection, birth)
            if not is_first:
                for stored in self._registry.by_key.values():
                    self.ask(stored)
            is_first = False

    async def _publish(self, connection: MqttConnection, message: Publication) -> bool:
        """Return whether there was a link."""
        try:
            await connection.publish(message.topic, message.payload, qos=message.qos, retain=message.retain)
            self._counters.asks += 1
        except LinkError:
            return False
        except HomebotError as exc:
            self._quarantine.log_limited(
                NOT_ASKED, f"state not requested on {message.topic}: {exc}", source=message.topic
            )
        return True


_Asks: TypeAlias = tuple[Publication, ...]
