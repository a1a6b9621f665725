"""Simulated HomeKit accessories, behind one bridge by HAP-python."""

from homebot.house.homekit.accessory import ServedAccessory
from homebot.house.homekit.bridge import SimulatedHomekitBridge

__all__ = ["ServedAccessory", "SimulatedHomekitBridge"]
