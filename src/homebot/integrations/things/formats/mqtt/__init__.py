"""Imported W3C Thing Descriptions as a convention."""

from homebot.integrations.things.formats.mqtt.convention import ThingDescriptions, ThingSettings

__all__ = ["ThingDescriptions", "ThingSettings"]
