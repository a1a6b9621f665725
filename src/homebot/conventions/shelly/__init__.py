"""Shelly's own MQTT dialects."""

from homebot.conventions.shelly.convention import Shelly, ShellySettings

__all__ = ["Shelly", "ShellySettings"]
