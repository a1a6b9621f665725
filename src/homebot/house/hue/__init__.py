"""A simulated Philips Hue bridge and the devices behind it."""

from homebot.house.hue.bridge import SimulatedHueBridge, make_certificate, paired_bridge
from homebot.house.hue.device import HueHouseDevice

__all__ = ["HueHouseDevice", "SimulatedHueBridge", "make_certificate", "paired_bridge"]
