"""WLED: what the lights of a controller are, what they report, and how they are commanded. Pure."""

from homebot.conventions.wled.strip import MASTER, Fields, WledStrip, effect_names

__all__ = ["MASTER", "Fields", "WledStrip", "effect_names"]
