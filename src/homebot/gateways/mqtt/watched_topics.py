"""Raw messages of topics that are no device's, such as the map of a robot vacuum, for parts of homebot that ask."""

from __future__ import annotations

from typing import Final

from homebot.devices import GatewayNames, RawMessage
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import HomebotError
from homebot.graph import Node
from homebot.messages import Time
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.topics import validate_topic

__all__ = ["WatchedTopics"]

_MOST: Final = 100


class WatchedTopics:
    """The topics that were asked for; their messages are published on one topic of the graph.

    Args:
        node: The gateway's node.
        names: Its names.
        connection: The link to the broker.
    """

    def __init__(self, node: Node, names: GatewayNames, connection: MqttConnection) -> None:
        self._gateway = node.name
        self._clock = node.graph.clock
        self._connection = connection
        self._publisher = node.create_publisher(RawMessage, names.watched, 100)
        self._topics: set[str] = set()

    def __contains__(self, topic: object) -> bool:
        return topic in self._topics

    async def watch(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        """Answer the service: publish all further messages on a topic, first the one that the broker keeps."""
        try:
            validate_topic(request.topic)
            if request.topic not in self._topics and len(self._topics) >= _MOST:
                return SubscribeToTopicResponse(success=False, message=f"{_MOST} are watched already", data_topic="")
            self._topics.add(request.topic)
            await self._connection.subscribe(MqttSubscription(request.topic, no_local=True), every_link=True)
        except HomebotError as exc:
            self._topics.discard(request.topic)
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        return SubscribeToTopicResponse(success=True, message="", data_topic=self._publisher.topic_name)

    def publish(self, message: MqttMessage) -> None:
        """Publish *message* on the graph."""
        self._publisher.publish(
            RawMessage(
                gateway=self._gateway,
                key=message.topic,
                address=message.topic,
                payload=message.payload,
                retained=message.retain,
                received_at=Time.from_seconds(self._clock.now()),
            )
        )
