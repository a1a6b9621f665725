"""ROS ``diagnostic_msgs``: reports on the health of components, built from the package's definitions."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("diagnostic_msgs")
