"""ROS ``sensor_msgs``: sensor data of robots, built from the package's definitions."""

from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("sensor_msgs")
