"""A simulated Philips Hue bridge and the devices behind it."""

from homebot.integrations.hue.simulated.bridge import SimulatedHueBridge, make_certificate, paired_bridge
from homebot.integrations.hue.simulated.device import HueHouseDevice

__all__ = ["HueHouseDevice", "SimulatedHueBridge", "make_certificate", "paired_bridge"]
