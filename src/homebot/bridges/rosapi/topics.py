"""Services of ``/rosapi`` about topics and message types, and their messages, field for field as in ``rosapi_msgs``.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from homebot.bridges.rosapi.typedefs import TypeDef, absolute, typedefs_of, unique
from homebot.bridges.rosbridge.types import find_message_type, same_type
from homebot.graph import EntityKind, Graph
from homebot.messages.definition import definition_text
from homebot.messages.message import Message, ServiceType
from homebot.names import is_hidden

__all__ = [
    "MessageDetails",
    "Publishers",
    "Subscribers",
    "TopicDirectory",
    "TopicType",
    "Topics",
    "TopicsAndRawTypes",
    "TopicsForType",
]


class TopicsRequest(Message, ros_type="rosapi_msgs/srv/Topics_Request"):
    """A question for the names of all topics."""


class TopicsResponse(Message, ros_type="rosapi_msgs/srv/Topics_Response"):
    """The topics and their types, in the same order."""

    topics: tuple[str, ...]
    types: tuple[str, ...]


class TopicsForTypeRequest(Message, ros_type="rosapi_msgs/srv/TopicsForType_Request"):
    """A question for the topics that carry a type."""

    type: str


class TopicsForTypeResponse(Message, ros_type="rosapi_msgs/srv/TopicsForType_Response"):
    """The topics."""

    topics: tuple[str, ...]


class TopicTypeRequest(Message, ros_type="rosapi_msgs/srv/TopicType_Request"):
    """A question for the type that a topic carries."""

    topic: str


class TopicTypeResponse(Message, ros_type="rosapi_msgs/srv/TopicType_Response"):
    """Its type, empty where there is no such topic."""

    type: str


class TopicsAndRawTypesRequest(Message, ros_type="rosapi_msgs/srv/TopicsAndRawTypes_Request"):
    """A question for all topics, with the definitions of their types."""


class TopicsAndRawTypesResponse(Message, ros_type="rosapi_msgs/srv/TopicsAndRawTypes_Response"):
    """The topics, their types and the full texts of those, in the same order."""

    topics: tuple[str, ...]
    types: tuple[str, ...]
    typedefs_full_text: tuple[str, ...]


class MessageDetailsRequest(Message, ros_type="rosapi_msgs/srv/MessageDetails_Request"):
    """A question for the fields of a message type."""

    type: str


class MessageDetailsResponse(Message, ros_type="rosapi_msgs/srv/MessageDetails_Response"):
    """The type and every type in it."""

    typedefs: tuple[TypeDef, ...]


class PublishersRequest(Message, ros_type="rosapi_msgs/srv/Publishers_Request"):
    """A question for the nodes that publish on a topic."""

    topic: str


class PublishersResponse(Message, ros_type="rosapi_msgs/srv/Publishers_Response"):
    """The nodes."""

    publishers: tuple[str, ...]


class SubscribersRequest(Message, ros_type="rosapi_msgs/srv/Subscribers_Request"):
    """A question for the nodes that subscribe to a topic."""

    topic: str


class SubscribersResponse(Message, ros_type="rosapi_msgs/srv/Subscribers_Response"):
    """The nodes."""

    subscribers: tuple[str, ...]


Topics = ServiceType("rosapi_msgs/srv/Topics", TopicsRequest, TopicsResponse)
TopicsForType = ServiceType("rosapi_msgs/srv/TopicsForType", TopicsForTypeRequest, TopicsForTypeResponse)
TopicType = ServiceType("rosapi_msgs/srv/TopicType", TopicTypeRequest, TopicTypeResponse)
TopicsAndRawTypes = ServiceType(
    "rosapi_msgs/srv/TopicsAndRawTypes", TopicsAndRawTypesRequest, TopicsAndRawTypesResponse
)
MessageDetails = ServiceType("rosapi_msgs/srv/MessageDetails", MessageDetailsRequest, MessageDetailsResponse)
Publishers = ServiceType("rosapi_msgs/srv/Publishers", PublishersRequest, PublishersResponse)
Subscribers = ServiceType("rosapi_msgs/srv/Subscribers", SubscribersRequest, SubscribersResponse)


class TopicDirectory:
    """Answers questions about topics and message types.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: TopicsRequest) -> TopicsResponse:
        """Return every visible topic."""
        topics = self._visible()
        return TopicsResponse(topics=tuple(topics), types=tuple(topics.values()))

    def for_type(self, request: TopicsForTypeRequest) -> TopicsForTypeResponse:
        """Return the visible topics of a type."""
        found = (
            name
            for known in self._graph.get_message_types()
            if same_type(known.ros_type, request.type)
            for name in self._graph.get_topics_of_type(known.ros_type)
            if not is_hidden(name)
        )
        return TopicsForTypeResponse(topics=unique(found))

    def type_of(self, request: TopicTypeRequest) -> TopicTypeResponse:
        """Return what a topic carries."""
        found = self._graph.get_message_type(absolute(request.topic))
        return TopicTypeResponse(type=found.ros_type if found else "")

    def all_with_text(self, _request: TopicsAndRawTypesRequest) -> TopicsAndRawTypesResponse:
        """Return every visible topic with the text of its type."""
        topics = self._visible()
        texts = [definition_text(found) for name in topics if (found := self._graph.get_message_type(name))]
        return TopicsAndRawTypesResponse(
            topics=tuple(topics), types=tuple(topics.values()), typedefs_full_text=tuple(texts)
        )

    def details(self, request: MessageDetailsRequest) -> MessageDetailsResponse:
        """Return what a message type looks like; an unknown one is a PeerError."""
        return MessageDetailsResponse(typedefs=typedefs_of(find_message_type(self._graph, request.type)))

    def publishers(self, request: PublishersRequest) -> PublishersResponse:
        """Return the nodes that publish on a topic."""
        return PublishersResponse(publishers=self._users(EntityKind.PUBLISHER, request.topic))

    def subscribers(self, request: SubscribersRequest) -> SubscribersResponse:
        """Return the nodes that subscribe to a topic."""
        return SubscribersResponse(subscribers=self._users(EntityKind.SUBSCRIPTION, request.topic))

    def _users(self, kind: EntityKind, topic: str) -> tuple[str, ...]:
        return unique(info.node for info in self._graph.get_endpoints(kind=kind, name=absolute(topic)))

    def _visible(self) -> dict[str, str]:
        topics = self._graph.get_topic_names_and_types().items()
        return {name: ros_type for name, ros_type in topics if not is_hidden(name)}
