"""Services of ``/rosapi`` about topics and message types."""

from __future__ import annotations

from homebot.bridges.rosapi import topic_messages as m
from homebot.bridges.rosapi.names import absolute, unique
from homebot.bridges.rosapi.typedefs import typedefs_of
from homebot.bridges.rosbridge.types import find_message_type, same_type
from homebot.graph import EntityKind, Graph
from homebot.messages.definition import definition_text
from homebot.names import is_hidden

__all__ = ["TopicDirectory"]


class TopicDirectory:
    """Answers questions about topics and message types.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: m.TopicsRequest) -> m.TopicsResponse:
        """Return every visible topic."""
        topics = self._visible()
        return m.TopicsResponse(topics=tuple(topics), types=tuple(topics.values()))

    def for_type(self, request: m.TopicsForTypeRequest) -> m.TopicsForTypeResponse:
        """Return the visible topics of a type."""
        found = (
            name
            for known in self._graph.get_message_types()
            if same_type(known.ros_type, request.type)
            for name in self._graph.get_topics_of_type(known.ros_type)
            if not is_hidden(name)
        )
        return m.TopicsForTypeResponse(topics=unique(found))

    def type_of(self, request: m.TopicTypeRequest) -> m.TopicTypeResponse:
        """Return what a topic carries."""
        found = self._graph.get_message_type(absolute(request.topic))
        return m.TopicTypeResponse(type=found.ros_type if found else "")

    def all_with_text(self, _request: m.TopicsAndRawTypesRequest) -> m.TopicsAndRawTypesResponse:
        """Return every visible topic with the text of its type."""
        topics = self._visible()
        texts = [definition_text(found) for name in topics if (found := self._graph.get_message_type(name))]
        return m.TopicsAndRawTypesResponse(
            topics=tuple(topics), types=tuple(topics.values()), typedefs_full_text=tuple(texts)
        )

    def details(self, request: m.MessageDetailsRequest) -> m.MessageDetailsResponse:
        """Return what a message type looks like; an unknown one is a PeerError."""
        return m.MessageDetailsResponse(typedefs=typedefs_of(find_message_type(self._graph, request.type)))

    def publishers(self, request: m.PublishersRequest) -> m.PublishersResponse:
        """Return who publishes on a topic."""
        return m.PublishersResponse(publishers=self._users(EntityKind.PUBLISHER, request.topic))

    def subscribers(self, request: m.SubscribersRequest) -> m.SubscribersResponse:
        """Return who reads a topic."""
        return m.SubscribersResponse(subscribers=self._users(EntityKind.SUBSCRIPTION, request.topic))

    def _users(self, kind: EntityKind, topic: str) -> tuple[str, ...]:
        return unique(info.node for info in self._graph.get_endpoints(kind=kind, name=absolute(topic)))

    def _visible(self) -> dict[str, str]:
        topics = self._graph.get_topic_names_and_types().items()
        return {name: ros_type for name, ros_type in topics if not is_hidden(name)}
