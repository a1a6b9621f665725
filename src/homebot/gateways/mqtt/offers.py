"""The publisher of homebot's devices to other systems, whose commands it brings onto the graph.

Offers and states are kept, within bounds, while the link is down, and published again on every link.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable
from functools import partial
from typing import TYPE_CHECKING

import anyio

from homebot.conventions.convention import Convention, OfferPublisher, PublishingConvention
from homebot.conventions.description import Publication
from homebot.devices.exposure import ExposedDevice
from homebot.errors import HomebotError, LinkError
from homebot.gateways.announced.quarantine import PeerQuarantine
from homebot.gateways.base import Gateway
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from homebot.gateways.announced.exposed_devices import ExposedDevices, KnownStates

NOT_PUBLISHED = "gateway.not_published"

MAX_EVENTS = 1000
"""Most events that wait for the link; the oldest are dropped first."""


class Offers:
    """The publications of the devices that homebot exposes through one gateway.

    A gateway that only observes publishes nothing.
    """

    def __init__(
        self, gateway: Gateway, publishers: tuple[OfferPublisher, ...], quarantine: PeerQuarantine[MqttMessage]
    ) -> None:
        self._node = gateway.node
        self._publishers = publishers if gateway.acts else ()
        self.publishes = bool(self._publishers)
        self._quarantine = quarantine
        self._waiting: dict[str, Publication] = {}
        self._events: deque[Publication] = deque(maxlen=MAX_EVENTS)
        self._news = anyio.Event()
        self._exposed: ExposedDevices | None = None
        if self._publishers:
            from homebot.gateways.announced.exposed_devices import ExposedDevices  # noqa: PLC0415 - few houses expose any

            self._exposed = ExposedDevices(gateway, self._show, self._publish_states, quarantine.log_limited)

    def is_own_topic(self, topic: str) -> bool:
        """Return whether *topic* belongs to homebot's own devices."""
        return any(publisher.is_own_topic(topic) for publisher in self._publishers)

    def handle_command(self, message: MqttMessage) -> None:
        """Forward *message* if it is a command to an exposed device, and not retained."""
        for publisher in self._publishers if not message.retain else ():
            try:
                commands = publisher.read_command(message.topic, message.payload)
            except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
                self._quarantine.record_plugin_failure(message.topic, type(publisher).__name__, exc)
                continue
            if commands and self._exposed is not None:
                for command in commands:
                    self._exposed.command(command)
                return

    async def serve(self, connection: MqttConnection) -> None:
        """Publish until cancelled."""
        if self._exposed is None:
            return
        filters = (topic_filter for publisher in self._publishers for topic_filter in publisher.filters())
        await connection.subscribe(*(MqttSubscription(topic_filter, qos=1, no_local=True) for topic_filter in filters))
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(run_as, self._node.full_name, partial(self._publish, connection))
            tasks.start_soon(run_as, self._node.full_name, partial(self._publish_anew, connection, self._exposed))

    def _show(self, offer: ExposedDevice) -> None:
        self._wait(publication for publisher in self._publishers for publication in publisher.publications(offer))

    def _publish_states(self, offer: ExposedDevice, known: KnownStates, changed: Collection[tuple[str, str]]) -> None:
        self._wait(state for publisher in self._publishers for state in publisher.states(offer, known, changed))

    def _wait(self, publications: Iterable[Publication]) -> None:
        """Queue each event, and the newest state of each topic, so that a slow link needs no more memory."""
        for publication in publications:
            if not publication.retain:
                if len(self._events) == MAX_EVENTS:
                    self._quarantine.log_limited(
                        NOT_PUBLISHED, "an event was dropped: too many are waiting", source=publication.topic
                    )
                self._events.append(publication)
                continue
            self._waiting.pop(publication.topic, None)
            self._waiting[publication.topic] = publication
        self._news.set()

    async def _publish(self, connection: MqttConnection) -> None:
        while True:
            await self._news.wait()
            self._news = anyio.Event()
            if connection.state.phase is not LinkPhase.CONNECTED:  # commands may follow at once: it listens first
                self._events.clear()  # each will be over
                continue
            while self._waiting or self._events:
                is_state = bool(self._waiting)  # descriptions come before events
                publication = self._waiting.pop(next(iter(self._waiting))) if is_state else self._events.popleft()
                topic = publication.topic
                try:
                    await connection.publish(topic, publication.payload, qos=publication.qos, retain=publication.retain)
                except LinkError:
                    if publication.payload or not publication.retain:
                        continue  # the next link publishes every state again; by then an event is over
                    self._waiting.setdefault(topic, publication)
                    break
                except HomebotError as exc:
                    self._quarantine.log_limited(NOT_PUBLISHED, f"not published on {topic}: {exc}", source=topic)

    async def _publish_anew(self, connection: MqttConnection, exposed: ExposedDevices) -> None:
        async for state in connection.states():
            if state.phase is LinkPhase.CONNECTED:
                exposed.show_all()
                self._news.set()


def publishers_of(
    conventions: tuple[Convention, ...], gateway: str, connection: MqttConnection
) -> tuple[OfferPublisher, ...]:
    """Return the announcers of homebot's own devices, in each convention that can."""
    status_topic = connection.status_topic or ""
    owner = status_topic.removeprefix("homebot/").removesuffix("/status") or gateway
    made = (
        convention.publisher(owner, status_topic)
        for convention in conventions
        if isinstance(convention, PublishingConvention)
    )
    return tuple(publisher for publisher in made if publisher is not None)
