"""``nav2_msgs/action/NavigateToPose`` of ROS 2 Jazzy as pyzeros takes types; ros2_pyterfaces computes the hashes."""

from dataclasses import dataclass, field
from typing import Any

from ros2_pyterfaces.cyclone.builtin_interfaces.msg import Duration, Time
from ros2_pyterfaces.cyclone.geometry_msgs.msg import PoseStamped
from ros2_pyterfaces.cyclone.idl import IdlStruct, make_idl_service, types
from ros2_pyterfaces.cyclone.unique_identifier_msgs.msg import UUID

NAME = "nav2_msgs/action/NavigateToPose"


@dataclass
class Goal(IdlStruct, typename=f"{NAME}_Goal"):
    pose: PoseStamped = field(default_factory=PoseStamped)
    behavior_tree: str = ""


@dataclass
class Result(IdlStruct, typename=f"{NAME}_Result"):
    error_code: types.uint16 = 0
    error_msg: str = ""


@dataclass
class Feedback(IdlStruct, typename=f"{NAME}_Feedback"):
    current_pose: PoseStamped = field(default_factory=PoseStamped)
    navigation_time: Duration = field(default_factory=Duration)
    estimated_time_remaining: Duration = field(default_factory=Duration)
    number_of_recoveries: types.int16 = 0
    distance_remaining: types.float32 = 0


@dataclass
class SendGoalRequest(IdlStruct, typename=f"{NAME}_SendGoal_Request"):
    goal_id: UUID = field(default_factory=UUID)
    goal: Goal = field(default_factory=Goal)


@dataclass
class SendGoalResponse(IdlStruct, typename=f"{NAME}_SendGoal_Response"):
    accepted: bool = False
    stamp: Time = field(default_factory=Time)


@dataclass
class GetResultRequest(IdlStruct, typename=f"{NAME}_GetResult_Request"):
    goal_id: UUID = field(default_factory=UUID)


@dataclass
class GetResultResponse(IdlStruct, typename=f"{NAME}_GetResult_Response"):
    status: types.int8 = 0
    result: Result = field(default_factory=Result)


@dataclass
class FeedbackMessage(IdlStruct, typename=f"{NAME}_FeedbackMessage"):
    goal_id: UUID = field(default_factory=UUID)
    feedback: Feedback = field(default_factory=Feedback)


@dataclass
class GoalInfo(IdlStruct, typename="action_msgs/msg/GoalInfo"):
    goal_id: UUID = field(default_factory=UUID)
    stamp: Time = field(default_factory=Time)


@dataclass
class CancelGoalRequest(IdlStruct, typename="action_msgs/srv/CancelGoal_Request"):
    goal_info: GoalInfo = field(default_factory=GoalInfo)


@dataclass
class CancelGoalResponse(IdlStruct, typename="action_msgs/srv/CancelGoal_Response"):
    return_code: types.int8 = 0
    goals_canceling: types.sequence[GoalInfo] = field(default_factory=list)


SendGoal: Any = make_idl_service(SendGoalRequest, SendGoalResponse)
GetResult: Any = make_idl_service(GetResultRequest, GetResultResponse)
CancelGoal: Any = make_idl_service(CancelGoalRequest, CancelGoalResponse)
