"""Imported W3C Thing Descriptions as a convention."""

from homebot.wot.mqtt.convention import ThingDescriptions, ThingSettings

__all__ = ["ThingDescriptions", "ThingSettings"]
