"""What messages that are made of text promise to a type checker; read by mypy, never run."""

from homebot.messages import Time
from homebot.messages.sensor_msgs import BatteryState, Imu
from homebot.messages.std_msgs import Header


def charge(message: BatteryState) -> float:
    return float(message.percentage)


def level(header: Header) -> Imu:
    return Imu(header=header, angular_velocity=Time(sec=0, nanosec=0))
