"""Actions: goals that take time, report feedback and can be cancelled, as in ROS 2.

An action NAME is five hidden endpoints below ``NAME/_action``: the services ``send_goal``, ``cancel_goal`` and
``get_result``, and the topics ``feedback`` and ``status``. Loaded when used.
"""

from homebot.graph.actions.action_client import ActionClient as ActionClient
from homebot.graph.actions.action_client import ClientGoal as ClientGoal
from homebot.graph.actions.action_server import ActionServer as ActionServer
from homebot.graph.actions.action_server import Preemption as Preemption
from homebot.graph.actions.goals import GoalState as GoalState
from homebot.graph.actions.goals import ServerGoal as ServerGoal
