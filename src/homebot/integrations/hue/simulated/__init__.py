"""A simulated Philips Hue bridge and the devices behind it."""

from homebot.integrations.hue.simulated.bridge import (
    HueHouseDevice,
    SimulatedHueBridge,
    make_certificate,
    paired_bridge,
)

__all__ = ["HueHouseDevice", "SimulatedHueBridge", "make_certificate", "paired_bridge"]
