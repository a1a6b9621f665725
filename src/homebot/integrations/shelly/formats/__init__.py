"""Shelly's own MQTT dialects."""

from homebot.integrations.shelly.formats.convention import Shelly, ShellySettings

__all__ = ["Shelly", "ShellySettings"]
