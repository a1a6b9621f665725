"""ROS ``rosgraph_msgs``: the clock of a simulation, made of the package's text."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("rosgraph_msgs")
