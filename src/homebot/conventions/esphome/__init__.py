"""ESPHome's native API: what the entities of a device are, what they report, and how they are commanded. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``.
"""

from homebot.conventions.esphome.device import EsphomeDevice, ListedEntity
from homebot.conventions.esphome.entity import EsphomeEntity, Fields

__all__ = ["EsphomeDevice", "EsphomeEntity", "Fields", "ListedEntity"]
