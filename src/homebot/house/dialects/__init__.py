"""The families of devices that there are in houses, as they speak over MQTT. Pure."""

from homebot.house.dialects.known import DIALECTS

__all__ = ["DIALECTS"]
