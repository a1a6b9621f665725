"""ROS ``diagnostic_msgs``: reports on the health of parts, made of the package's text."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("diagnostic_msgs")
