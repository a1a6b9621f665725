"""The imports of Jazzy's nav2_simple_commander, and a message of each."""

import rclpy
from geographic_msgs.msg import GeoPose
from nav2_msgs.action import (
    AssistedTeleop,
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
    DockRobot,
    DriveOnHeading,
    FollowGPSWaypoints,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    SmoothPath,
    Spin,
    UndockRobot,
)
from nav2_msgs.msg import MissedWaypoint
from nav2_msgs.srv import (
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCostmap,
    LoadMap,
    ManageLifecycleNodes,
)

ACTIONS = (
    *(AssistedTeleop, BackUp, ComputePathThroughPoses, ComputePathToPose, DockRobot, DriveOnHeading),
    *(FollowGPSWaypoints, FollowPath, FollowWaypoints, NavigateThroughPoses, NavigateToPose, SmoothPath, Spin),
    UndockRobot,
)
SERVICES = (
    *(ClearCostmapAroundRobot, ClearCostmapExceptRegion, ClearEntireCostmap),
    *(GetCostmap, LoadMap, ManageLifecycleNodes),
)

rclpy.init()
made = [part() for one in ACTIONS for part in (one.Goal, one.Result, one.Feedback)]
made += [part() for one in SERVICES for part in (one.Request, one.Response)]
print(len(made), "messages")
goal = FollowGPSWaypoints.Goal()
goal.gps_poses = [GeoPose()]
print(goal.gps_poses[0].position.latitude, FollowGPSWaypoints.Result().error_code)
missed = MissedWaypoint()
missed.error_code = FollowWaypoints.Result.TASK_EXECUTOR_FAILED
print(missed.error_code, ManageLifecycleNodes.Request.SHUTDOWN, ComputePathToPose.Result.NO_VALID_PATH)
