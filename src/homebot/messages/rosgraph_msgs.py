"""ROS ``rosgraph_msgs``: the clock of a simulation, built from the package's definitions."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("rosgraph_msgs")
