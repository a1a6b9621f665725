"""The driver for ESPHome's native API."""

from homebot.integrations.esphome.driver.driver import EsphomeDriver
from homebot.integrations.esphome.driver.settings import EsphomeSettings

__all__ = ["EsphomeDriver", "EsphomeSettings"]
