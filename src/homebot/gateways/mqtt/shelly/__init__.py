"""Shelly's own MQTT dialects."""

from homebot.gateways.mqtt.shelly.convention import Shelly, ShellySettings

__all__ = ["Shelly", "ShellySettings"]
