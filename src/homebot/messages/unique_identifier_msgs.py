"""ROS ``unique_identifier_msgs``: identifiers."""

from typing import Annotated

from pydantic import Field

from homebot.messages.message import Message


class UUID(Message, ros_type="unique_identifier_msgs/msg/UUID"):
    """A universally unique identifier (RFC 4122): 16 bytes in network order."""

    uuid: Annotated[bytes, Field(min_length=16, max_length=16)]
