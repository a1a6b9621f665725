"""Automations of Home Assistant as routines."""

from homebot.integrations.homeassistant.automations.reader import HomeAssistantAutomations

__all__ = ["HomeAssistantAutomations"]
