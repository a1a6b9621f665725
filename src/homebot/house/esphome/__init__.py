"""Simulated ESPHome devices: real servers of the native API."""

from homebot.house.esphome.device import EsphomeServedDevice

__all__ = ["EsphomeServedDevice"]
