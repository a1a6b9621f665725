"""Simulated ESPHome devices: real servers of the native API."""

from homebot.integrations.esphome.simulated.device import EsphomeServedDevice

__all__ = ["EsphomeServedDevice"]
