"""Messages of ``rosapi_msgs`` about topics and message types, field for field.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.fields import Int32
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = [
    "MessageDetails",
    "MessageDetailsRequest",
    "MessageDetailsResponse",
    "Publishers",
    "PublishersRequest",
    "PublishersResponse",
    "Subscribers",
    "SubscribersRequest",
    "SubscribersResponse",
    "TopicType",
    "TopicTypeRequest",
    "TopicTypeResponse",
    "Topics",
    "TopicsAndRawTypes",
    "TopicsAndRawTypesRequest",
    "TopicsAndRawTypesResponse",
    "TopicsForType",
    "TopicsForTypeRequest",
    "TopicsForTypeResponse",
    "TopicsRequest",
    "TopicsResponse",
    "TypeDef",
]


class TypeDef(Message):
    """The fields of a message type.

    Attributes:
        type: Its name, as ``package/Name``.
        fieldnames: Its fields.
        fieldtypes: The fields' types; of one element where the field is an array.
        fieldarraylen: -1 for one value, 0 for any number of values, else exactly that many.
        examples: A value of each field, as text.
        constnames: Its constants.
        constvalues: Their values, as text.
    """

    ros_type: ClassVar[str] = "rosapi_msgs/msg/TypeDef"

    type: str
    fieldnames: tuple[str, ...]
    fieldtypes: tuple[str, ...]
    fieldarraylen: tuple[Int32, ...]
    examples: tuple[str, ...]
    constnames: tuple[str, ...] = ()
    constvalues: tuple[str, ...] = ()


class TopicsRequest(Message):
    """A question for the names of all topics."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Topics_Request"


class TopicsResponse(Message):
    """The topics and their types, in the same order."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Topics_Response"

    topics: tuple[str, ...]
    types: tuple[str, ...]


class TopicsForTypeRequest(Message):
    """A question for the topics that carry a type."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsForType_Request"

    type: str


class TopicsForTypeResponse(Message):
    """The topics."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsForType_Response"

    topics: tuple[str, ...]


class TopicTypeRequest(Message):
    """A question for the type that a topic carries."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicType_Request"

    topic: str


class TopicTypeResponse(Message):
    """Its type, empty where there is no such topic."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicType_Response"

    type: str


class TopicsAndRawTypesRequest(Message):
    """A question for all topics, with the definitions of their types."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsAndRawTypes_Request"


class TopicsAndRawTypesResponse(Message):
    """The topics, their types and the full texts of those, in the same order."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsAndRawTypes_Response"

    topics: tuple[str, ...]
    types: tuple[str, ...]
    typedefs_full_text: tuple[str, ...]


class MessageDetailsRequest(Message):
    """A question for the fields of a message type."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/MessageDetails_Request"

    type: str


class MessageDetailsResponse(Message):
    """The type and every type in it."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/MessageDetails_Response"

    typedefs: tuple[TypeDef, ...]


class PublishersRequest(Message):
    """A question for the nodes that publish on a topic."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Publishers_Request"

    topic: str


class PublishersResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Publishers_Response"

    publishers: tuple[str, ...]


class SubscribersRequest(Message):
    """A question for the nodes that subscribe to a topic."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Subscribers_Request"

    topic: str


class SubscribersResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Subscribers_Response"

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
