"""ROS ``action_msgs``: the goals of actions."""

from typing import ClassVar

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Int8, Message, ServiceType
from homebot.messages.unique_identifier_msgs import UUID


class GoalInfo(Message, ros_type="action_msgs/msg/GoalInfo"):
    """A goal, and the time of its acceptance."""

    goal_id: UUID
    stamp: Time


class GoalStatus(Message, ros_type="action_msgs/msg/GoalStatus"):
    """The state of a goal.

    Attributes:
        status: 0 unknown, 1 accepted, 2 executing, 3 canceling, 4 succeeded, 5 canceled, 6 aborted.
    """

    STATUS_UNKNOWN: ClassVar = 0
    STATUS_ACCEPTED: ClassVar = 1
    STATUS_EXECUTING: ClassVar = 2
    STATUS_CANCELING: ClassVar = 3
    STATUS_SUCCEEDED: ClassVar = 4
    STATUS_CANCELED: ClassVar = 5
    STATUS_ABORTED: ClassVar = 6

    goal_info: GoalInfo
    status: Int8


class GoalStatusArray(Message, ros_type="action_msgs/msg/GoalStatusArray"):
    """The states of all goals of an action, on its topic ``status``."""

    status_list: tuple[GoalStatus, ...]


class CancelGoalRequest(Message, ros_type="action_msgs/srv/CancelGoal_Request"):
    """Cancel goals: the one with the id, and with a stamp all that were accepted by then; with neither, all goals."""

    goal_info: GoalInfo


class CancelGoalResponse(Message, ros_type="action_msgs/srv/CancelGoal_Response"):
    """The result of a cancel request.

    Attributes:
        return_code: 0 none, 1 rejected, 2 unknown goal, 3 goal terminated.
    """

    ERROR_NONE: ClassVar = 0
    ERROR_REJECTED: ClassVar = 1
    ERROR_UNKNOWN_GOAL_ID: ClassVar = 2
    ERROR_GOAL_TERMINATED: ClassVar = 3

    return_code: Int8
    goals_canceling: tuple[GoalInfo, ...]


CancelGoal = ServiceType("action_msgs/srv/CancelGoal", CancelGoalRequest, CancelGoalResponse)
