"""Services of ``/rosapi`` about topics and message types, and their messages, field for field as in ``rosapi_msgs``.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from homebot.bridges.rosapi.typedefs import TypeDef, absolute, typedefs_of, unique
from homebot.bridges.rosbridge.types import find_message_type, same_type
from homebot.graph import EntityKind, Graph
from homebot.messages.definition import definition_text
from homebot.messages.message import Message
from homebot.names import is_hidden

__all__ = ["SERVICES"]


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


def list_topics(graph: Graph, _request: TopicsRequest) -> TopicsResponse:
    """Return every visible topic."""
    topics = _visible(graph)
    return TopicsResponse(topics=tuple(topics), types=tuple(topics.values()))


def topics_for_type(graph: Graph, request: TopicsForTypeRequest) -> TopicsForTypeResponse:
    """Return the visible topics of a type."""
    found = (
        name
        for known in graph.get_message_types()
        if same_type(known.ros_type, request.type)
        for name in graph.get_topics_of_type(known.ros_type)
        if not is_hidden(name)
    )
    return TopicsForTypeResponse(topics=unique(found))


def type_of_topic(graph: Graph, request: TopicTypeRequest) -> TopicTypeResponse:
    """Return the type of a topic."""
    found = graph.get_message_type(absolute(request.topic))
    return TopicTypeResponse(type=found.ros_type if found else "")


def topics_with_text(graph: Graph, _request: TopicsAndRawTypesRequest) -> TopicsAndRawTypesResponse:
    """Return every visible topic with the text of its type."""
    topics = _visible(graph)
    texts = [definition_text(found) for name in topics if (found := graph.get_message_type(name))]
    return TopicsAndRawTypesResponse(
        topics=tuple(topics), types=tuple(topics.values()), typedefs_full_text=tuple(texts)
    )


def message_details(graph: Graph, request: MessageDetailsRequest) -> MessageDetailsResponse:
    """Return the fields of a message type; an unknown one is a PeerError."""
    return MessageDetailsResponse(typedefs=typedefs_of(find_message_type(graph, request.type)))


def publishers_of(graph: Graph, request: PublishersRequest) -> PublishersResponse:
    """Return the nodes that publish on a topic."""
    return PublishersResponse(publishers=_users(graph, EntityKind.PUBLISHER, request.topic))


def subscribers_of(graph: Graph, request: SubscribersRequest) -> SubscribersResponse:
    """Return the nodes that subscribe to a topic."""
    return SubscribersResponse(subscribers=_users(graph, EntityKind.SUBSCRIPTION, request.topic))


def _users(graph: Graph, kind: EntityKind, topic: str) -> tuple[str, ...]:
    return unique(info.node for info in graph.get_endpoints(kind=kind, name=absolute(topic)))


def _visible(graph: Graph) -> dict[str, str]:
    topics = graph.get_topic_names_and_types().items()
    return {name: ros_type for name, ros_type in topics if not is_hidden(name)}


SERVICES: Mapping[str, tuple[type[Message], type[Message], Callable[[Graph, Any], Message]]] = {
    "topics": (TopicsRequest, TopicsResponse, list_topics),
    "topics_for_type": (TopicsForTypeRequest, TopicsForTypeResponse, topics_for_type),
    "topic_type": (TopicTypeRequest, TopicTypeResponse, type_of_topic),
    "topics_and_raw_types": (TopicsAndRawTypesRequest, TopicsAndRawTypesResponse, topics_with_text),
    "message_details": (MessageDetailsRequest, MessageDetailsResponse, message_details),
    "publishers": (PublishersRequest, PublishersResponse, publishers_of),
    "subscribers": (SubscribersRequest, SubscribersResponse, subscribers_of),
}
"""Request, response and function of each service, by its name below ``/rosapi``."""
