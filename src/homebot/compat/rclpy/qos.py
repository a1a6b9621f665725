"""Quality of service, with rclpy's names."""

from homebot.graph.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_default,
    qos_profile_sensor_data,
    qos_profile_services_default,
)

__all__ = [
    "DurabilityPolicy",
    "HistoryPolicy",
    "LivelinessPolicy",
    "QoSProfile",
    "ReliabilityPolicy",
    "qos_profile_default",
    "qos_profile_sensor_data",
    "qos_profile_services_default",
]
