"""Simulated HomeKit accessories, behind one bridge by HAP-python."""

from homebot.integrations.homekit.simulated.bridge import ServedAccessory, SimulatedHomekitBridge

__all__ = ["ServedAccessory", "SimulatedHomekitBridge"]
