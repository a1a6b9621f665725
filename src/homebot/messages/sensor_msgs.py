"""ROS ``sensor_msgs``: what a robot's sensors measure, made of the package's text."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("sensor_msgs")
