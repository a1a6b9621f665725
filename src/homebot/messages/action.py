"""The type of an action, and the messages of its endpoints.

Source: ROS 2, rosidl ``rosidl_parser`` (an action has a goal, a result and feedback; the rest is derived).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType, new_class
from typing import Any, Generic, TypeVar

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Int8, Message, ServiceType
from homebot.messages.unique_identifier_msgs import UUID

GoalT = TypeVar("GoalT", bound=Message)
ResultT = TypeVar("ResultT", bound=Message)
FeedbackT = TypeVar("FeedbackT", bound=Message)


@dataclass(frozen=True)
class ActionType(Generic[GoalT, ResultT, FeedbackT]):
    """The goal, result and feedback of an action, like the generated ``Fibonacci.Goal`` etc. of ROS."""

    ros_type: str
    Goal: type[GoalT]
    Result: type[ResultT]
    Feedback: type[FeedbackT]

    # The field types of the derived types depend on the instance, so their classes are typed as messages.
    @cached_property
    def SendGoal(self) -> "SendGoalType":  # noqa: N802 - ROS's name
        """The service that takes a goal: ``goal_id``, ``goal``; ``accepted``, ``stamp``."""
        service = self._service("SendGoal", {"goal_id": UUID, "goal": self.Goal}, {"accepted": bool, "stamp": Time})
        return SendGoalType(service.ros_type, service.Request, service.Response, self)

    @cached_property
    def GetResult(self) -> ServiceType[Any, Any]:  # noqa: N802 - ROS's name
        """The service that answers when a goal has ended: ``goal_id``; ``status``, ``result``."""
        return self._service("GetResult", {"goal_id": UUID}, {"status": Int8, "result": self.Result})

    @cached_property
    def FeedbackMessage(self) -> type[Any]:  # noqa: N802 - ROS's name
        """The message of the topic ``feedback``: ``goal_id``, ``feedback``."""
        return message_class(f"{self.ros_type}_FeedbackMessage", {"goal_id": UUID, "feedback": self.Feedback})

    def _service(self, name: str, request: dict[str, object], response: dict[str, object]) -> ServiceType[Any, Any]:
        ros_type = f"{self.ros_type}_{name}"
        sides = message_class(f"{ros_type}_Request", request), message_class(f"{ros_type}_Response", response)
        return ServiceType(ros_type, *sides)


def message_class(
    ros_type: str, annotations: Mapping[str, object], values: Mapping[str, object] = MappingProxyType({})
) -> type[Message]:
    """Return the class of the message *ros_type* with the fields *annotations* and the default *values*."""
    body = {"__annotations__": annotations, "__module__": __name__, "__doc__": f"``{ros_type}``.", **values}
    return new_class(ros_type.rpartition("/")[2], (Message,), {"ros_type": ros_type}, lambda names: names.update(body))


@dataclass(frozen=True)
class SendGoalType(ServiceType[Any, Any]):
    """The type of the service that takes goals, which refers back to its action."""

    action_type: ActionType[Any, Any, Any]
