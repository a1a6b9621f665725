"""ROS ``nav_msgs``: maps, paths and places of robots, made of the package's text."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("nav_msgs")
