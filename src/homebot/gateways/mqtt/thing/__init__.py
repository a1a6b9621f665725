"""Imported W3C Thing Descriptions as a convention."""

from homebot.gateways.mqtt.thing.convention import ThingDescriptions, ThingSettings

__all__ = ["ThingDescriptions", "ThingSettings"]
