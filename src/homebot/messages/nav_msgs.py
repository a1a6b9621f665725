"""ROS ``nav_msgs``: maps, paths and positions of robots, built from the package's definitions."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("nav_msgs")
