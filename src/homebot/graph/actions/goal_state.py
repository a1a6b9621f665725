"""The states of a goal, and the names of an action's endpoints. Pure.

Source: ROS 2, rcl_action ``goal_state_machine.c`` and ``names.c``, action_msgs/GoalStatus.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

__all__ = ["GoalState", "endpoint_name"]


class GoalState(IntEnum):
    """The state of a goal, by the numbers of ``action_msgs/msg/GoalStatus``."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def is_terminal(self) -> bool:
        """True if the goal has ended."""
        return self >= GoalState.SUCCEEDED

    def can_become(self, state: GoalState) -> bool:
        """Return whether *state* may follow."""
        return state in _NEXT.get(self, ())


_NEXT: Final = {
    GoalState.ACCEPTED: (GoalState.EXECUTING, GoalState.CANCELING),
    GoalState.EXECUTING: (GoalState.CANCELING, GoalState.SUCCEEDED, GoalState.ABORTED),
    GoalState.CANCELING: (GoalState.SUCCEEDED, GoalState.CANCELED, GoalState.ABORTED),
}


def endpoint_name(action: str, endpoint: str) -> str:
    """Return the full name of one of the five endpoints of *action*."""
    return f"{action}/_action/{endpoint}"
