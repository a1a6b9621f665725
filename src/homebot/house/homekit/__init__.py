"""Simulated HomeKit accessories, behind one bridge by HAP-python."""

from homebot.house.homekit.bridge import ServedAccessory, SimulatedHomekitBridge

__all__ = ["ServedAccessory", "SimulatedHomekitBridge"]
