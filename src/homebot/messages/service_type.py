"""The type of a service: a request and a response."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from homebot.messages.message import Message

__all__ = ["ServiceType"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)


@dataclass(frozen=True)
class ServiceType(Generic[RequestT, ResponseT]):
    """The request and response messages of a service, as ROS's generated ``Trigger.Request`` and ``Trigger.Response``.

    Attributes:
        ros_type: The full ROS name, ``package/srv/Name``.
        Request: The type of a request.
        Response: The type of a response.
    """

    ros_type: str
    Request: type[RequestT]
    Response: type[ResponseT]
