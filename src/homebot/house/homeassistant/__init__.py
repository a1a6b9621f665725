"""A simulated Home Assistant, and the devices of the house in it."""

from homebot.house.homeassistant.entity import ServedEntity, ServedEntityKind
from homebot.house.homeassistant.server import SimulatedHomeAssistant

__all__ = ["ServedEntity", "ServedEntityKind", "SimulatedHomeAssistant"]
