"""ESPHome's native API: the entities of a device, their reports and commands. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``.
"""

from homebot.conventions.esphome.device import EsphomeDevice, ListedEntity
from homebot.conventions.esphome.entity import EsphomeEntity, Fields

__all__ = ["EsphomeDevice", "EsphomeEntity", "Fields", "ListedEntity"]
