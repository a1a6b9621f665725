"""WLED: the lights of a controller, their reports and commands. Pure."""

from homebot.conventions.wled.strip import MASTER, Fields, WledStrip, effect_names, preset_names

__all__ = ["MASTER", "Fields", "WledStrip", "effect_names", "preset_names"]
