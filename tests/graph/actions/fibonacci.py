"""ROS's usual example of an action."""

from homebot.graph.actions import ActionClient, ServerGoal
from homebot.messages import Message
from homebot.messages.action import ActionType
from homebot.messages.message import Int32


class Goal(Message, ros_type="example_interfaces/action/Fibonacci_Goal"):
    """How many numbers to compute."""

    order: Int32


class Result(Message, ros_type="example_interfaces/action/Fibonacci_Result"):
    """All numbers."""

    sequence: tuple[Int32, ...]


class Feedback(Message, ros_type="example_interfaces/action/Fibonacci_Feedback"):
    """The numbers so far."""

    sequence: tuple[Int32, ...]


Fibonacci = ActionType("example_interfaces/action/Fibonacci", Goal, Result, Feedback)
Client = ActionClient[Goal, Result, Feedback]
Served = ServerGoal[Goal, Result, Feedback]
