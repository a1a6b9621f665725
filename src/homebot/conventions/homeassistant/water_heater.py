"""The component ``water_heater``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/water_heater.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.temperature import Thermometer, read_thermometer, source_of

__all__ = ["build_water_heater"]


def build_water_heater(config: DiscoveryConfig) -> DescribedPart:
    """Describe a water heater. It is switched where it has a topic for that, and never reports it."""
    thermometer = read_thermometer(config)
    limits = thermometer.limits(config, *_CELSIUS)
    entity = Entity(config, "water_heater")
    entity.add_number(
        "heating_setpoint",
        source_of(config, "temperature_state"),
        config.command("temperature_command_topic", "temperature_command_template"),
        bounds=limits.bounds,
        unit="°C",
        from_device=thermometer.celsius,
        to_device=limits.number,
    )
    measured = source_of(config, "current_temperature")
    entity.add_number("local_temperature", measured, None, unit="°C", from_device=thermometer.celsius)
    mode = config.command("mode_command_topic", "mode_command_template")
    modes = config.options("modes") if config.has("modes") else _MODES
    entity.add_choice("water_heater_mode", source_of(config, "mode_state"), mode, modes)
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    entity.add_flag("on_off", None, config.command("power_command_topic", "power_command_template"), payloads)
    return entity.build()


_CELSIUS = (Thermometer(is_fahrenheit=True).celsius(110.0), Thermometer(is_fahrenheit=True).celsius(140.0))
"""Bounds where the config has none: 110 to 140 °F."""

_MODES = ("eco", "electric", "gas", "heat_pump", "high_demand", "performance", "off")
