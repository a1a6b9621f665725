"""Publishes what homebot offers to other systems, and brings their commands onto the graph.

While the link is down nothing is lost: what is offered and said is kept, bounded, and published anew on every link.
"""

from __future__ import annotations

from collections.abc import Iterable

import anyio

from homebot.devices.command import Command
from homebot.devices.offer import Offer, OfferReport
from homebot.devices.report import Reading
from homebot.errors import HomebotError, LinkError
from homebot.gateways.base import Gateway
from homebot.gateways.mqtt.convention import Publisher
from homebot.gateways.mqtt.description import Publication
from homebot.gateways.mqtt.tribunal import Tribunal
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.mqtt.client import Subscription
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage

__all__ = ["Offers"]

NOT_PUBLISHED = "gateway.not_published"
NOT_TAKEN = "gateway.offer_not_taken"

MAX_OFFERS = 1000

_QOS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Offers:
    """What one gateway publishes of homebot's own.

    A gateway that only observes publishes nothing.

    Args:
        gateway: The gateway.
        publishers: How it is published.
        tribunal: Tells what went wrong.
    """

    def __init__(self, gateway: Gateway, publishers: tuple[Publisher, ...], tribunal: Tribunal) -> None:
        self._node = gateway.node
        self._names = gateway.names
        self._publishers = publishers if gateway.acts else ()
        self._tribunal = tribunal
        self._offers: dict[str, Offer] = {}
        self._readings: dict[str, dict[tuple[str, str], Reading]] = {}
        self._waiting: dict[str, Publication] = {}
        self._news = anyio.Event()
        if self._publishers:
            self._commands = gateway.node.create_publisher(Command, gateway.names.offer_commands, 100)

    def filters(self) -> tuple[str, ...]:
        """Return where commands come."""
        return tuple(one for publisher in self._publishers for one in publisher.filters())

    def owns(self, topic: str) -> bool:
        """Whether what comes on *topic* is our own, and no device."""
        return any(publisher.owns(topic) for publisher in self._publishers)

    def take(self, message: MqttMessage) -> bool:
        """Take *message* if it is a command to something offered; one that the broker had kept is none."""
        for publisher in self._publishers:
            command = publisher.take(message.topic, message.payload)
            if command is not None and not message.retain:
                self._commands.publish(command)
                return True
        return False

    async def serve(self, connection: MqttConnection) -> None:
        """Publish until cancelled."""
        if not self._publishers:
            return
        await connection.subscribe(*(Subscription(one, qos=1, no_local=True) for one in self.filters()))
        self._node.create_subscription(Offer, self._names.offers, self._offer, _QOS)
        self._node.create_subscription(OfferReport, self._names.offer_reports, self._report, _QOS)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._publish, connection)
            tasks.start_soon(self._publish_anew, connection)

    def _offer(self, offer: Offer) -> None:
        if offer.id not in self._offers and len(self._offers) >= MAX_OFFERS:
            self._tribunal.warn(NOT_TAKEN, f"{offer.id} is one offer too many", topic=offer.id)
            return
        before = self._offers.get(offer.id)
        if before is not None and before.parts != offer.parts:
            self._say(before.model_copy(update={"is_withdrawn": True}))
        self._offers[offer.id] = offer
        self._say(offer)
        if offer.is_withdrawn:
            del self._offers[offer.id]
            self._readings.pop(offer.id, None)

    def _report(self, report: OfferReport) -> None:
        offer = self._offers.get(report.id)
        if offer is None:
            self._tribunal.warn(NOT_TAKEN, f"{report.id} says something and is not offered", topic=report.id)
            return
        known = {(part.id, one.name) for part in offer.parts for one in part.capabilities}
        readings = tuple(one for one in report.readings if (one.part, one.capability) in known)
        kept = self._readings.setdefault(offer.id, {})
        kept.update({(one.part, one.capability): one for one in readings})
        self._wait(one for publisher in self._publishers for one in publisher.states(offer, readings))

    def _say(self, offer: Offer) -> None:
        self._wait(one for publisher in self._publishers for one in publisher.publications(offer))

    def _wait(self, publications: Iterable[Publication]) -> None:
        """The newest of each topic waits, so that a slow link costs no memory."""
        for publication in publications:
            self._waiting.pop(publication.topic, None)
            self._waiting[publication.topic] = publication
        self._news.set()

    async def _publish(self, connection: MqttConnection) -> None:
        while True:
            await self._news.wait()
            self._news = anyio.Event()
            while self._waiting:
                topic, publication = next(iter(self._waiting.items()))
                del self._waiting[topic]
                try:
                    await connection.publish(topic, publication.payload, qos=publication.qos, retain=publication.retain)
                except LinkError:
                    if publication.payload:
                        continue  # on the next link everything is published anew
                    self._waiting.setdefault(topic, publication)
                    break
                except HomebotError as exc:
                    self._tribunal.warn(NOT_PUBLISHED, f"not published on {topic}: {exc}", topic=topic)

    async def _publish_anew(self, connection: MqttConnection) -> None:
        async for state in connection.states():
            if state.phase is LinkPhase.CONNECTED:
                for offer in self._offers.values():
                    self._say(offer)
                    readings = tuple(self._readings.get(offer.id, {}).values())
                    self._wait(one for publisher in self._publishers for one in publisher.states(offer, readings))
                self._news.set()
