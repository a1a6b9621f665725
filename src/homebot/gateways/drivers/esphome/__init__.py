"""The driver for ESPHome's native API."""

from homebot.gateways.drivers.esphome.driver import EsphomeDriver
from homebot.gateways.drivers.esphome.settings import EsphomeSettings

__all__ = ["EsphomeDriver", "EsphomeSettings"]
