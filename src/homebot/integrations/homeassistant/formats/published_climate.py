"""Published thermostats, air conditioners, water heaters and humidifiers, each as one entity. Pure.

Source: Home Assistant core 2024.3 to 2026.11, ``components/mqtt``: climate.py, humidifier.py, water_heater.py.
"""

from collections.abc import Mapping

from homebot.devices.part import Part
from homebot.integrations.homeassistant.formats.published_entity import Available, PublishedEntity, Row, is_settable

_MODES = frozenset({"auto", "off", "cool", "heat", "heat_cool", "dry", "fan_only"})
_HEATING = frozenset({"heat", "heat_cool", "auto"})
_COOLING = frozenset({"cool", "heat_cool"})
_MODE_OF_TARGET = {
    ("temperature", "heating_setpoint"): "heat",
    ("temperature", "cooling_setpoint"): "cool",
    ("temperature_low", "heating_setpoint"): "heat_cool",
    ("temperature_high", "cooling_setpoint"): "heat_cool",
}
"""The only mode of a device without modes, by its target."""

_HEATER_MODES = frozenset({"eco", "electric", "gas", "heat_pump", "high_demand", "performance", "off"})
_MODE_ROW = Row("thermostat_mode", "mode_state_topic", "mode_command_topic")
_POWER_ROW = Row("on_off", "", "power_command_topic")
_PRESET_ROW = Row("preset_mode", "preset_mode_state_topic", "preset_mode_command_topic")
_HEATER_MODE_ROW = Row("water_heater_mode", "mode_state_topic", "mode_command_topic")
_TEMPERATURE_ROW = Row("local_temperature", "current_temperature_topic")
_CLIMATE_ROWS = (
    _TEMPERATURE_ROW,
    Row("humidity", "current_humidity_topic"),
    *(
        Row(name, f"{name}_state_topic", f"{name}_command_topic", f"{name}s")
        for name in ("fan_mode", "swing_mode", "swing_horizontal_mode")
    ),
    Row("thermostat_action", "action_topic"),
)
_HUMIDIFIER_ROWS = (
    Row("on_off", "state_topic", "command_topic"),
    Row("humidity_setpoint", "target_humidity_state_topic", "target_humidity_command_topic"),
    Row("humidity", "current_humidity_topic"),
    Row("humidifier_mode", "mode_state_topic", "mode_command_topic", "modes", reserved="None"),
)


def publish_climate(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish the targets, the measurements and the modes of a thermostat or an air conditioner.

    A target with another meaning in Home Assistant, by its modes, stays a number entity, and so does a mode with
    options that Home Assistant does not have.
    """
    modes = _known_modes(available, "thermostat_mode", _MODES)
    targets = _targets(available, modes)
    if not modes and not targets:
        return
    shown = modes or tuple(_MODE_OF_TARGET[key, name] for name, key in targets.items())[:1]
    entity.config |= {"temperature_unit": "C", "modes": list(shown)}
    if modes:
        entity.add(available.pop("thermostat_mode"), _MODE_ROW)
    if "off" in modes and is_settable(available, "on_off"):
        entity.add(available.pop("on_off"), _POWER_ROW)
    _add_targets(entity, available, targets)
    entity.add_rows(available, _CLIMATE_ROWS)
    preset = available.get("preset_mode")
    if preset is not None and preset.settable and "none" in preset.options and len(preset.options) > 1:
        entity.config["preset_modes"] = [option for option in preset.options if option != "none"]
        entity.add(available.pop("preset_mode"), _PRESET_ROW)


def publish_water_heater(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish the target, the temperature and the mode of a water heater."""
    modes = _known_modes(available, "water_heater_mode", _HEATER_MODES)
    entity.config |= {"temperature_unit": "C", "modes": list(modes)}
    _add_targets(entity, available, {"heating_setpoint": "temperature"})
    if modes:
        entity.add(available.pop("water_heater_mode"), _HEATER_MODE_ROW)
    entity.add_rows(available, (_TEMPERATURE_ROW,))


def publish_humidifier(entity: PublishedEntity, available: Available, part: Part) -> None:
    """Publish the switch, the target and the mode of a humidifier."""
    entity.config["device_class"] = "dehumidifier" if part.tag == "dehumidifier" else "humidifier"
    bounds = available["humidity_setpoint"].bounds
    if bounds and 0 <= bounds[0] < bounds[1] <= 100:
        entity.config |= {"min_humidity": bounds[0], "max_humidity": bounds[1]}
    entity.add_rows(available, _HUMIDIFIER_ROWS)


def _known_modes(available: Available, name: str, known: frozenset[str]) -> tuple[str, ...]:
    """Return the options of the mode *name*; empty if it is not settable, or Home Assistant lacks one of them."""
    mode = available.get(name)
    return mode.options if mode is not None and mode.settable and set(mode.options) <= known else ()


def _targets(available: Available, modes: tuple[str, ...]) -> Mapping[str, str]:
    """Return the names of the targets in Home Assistant, by capability."""
    heats, cools = (is_settable(available, name) for name in ("heating_setpoint", "cooling_setpoint"))
    if heats and cools:
        return {"heating_setpoint": "temperature_low", "cooling_setpoint": "temperature_high"}
    if heats and not _COOLING & set(modes):
        return {"heating_setpoint": "temperature"}
    if cools and (not modes or "cool" in modes) and not _HEATING & set(modes):
        return {"cooling_setpoint": "temperature"}
    return {}


def _add_targets(entity: PublishedEntity, available: Available, targets: Mapping[str, str]) -> None:
    bounds: list[tuple[float, ...]] = []
    for name, key in targets.items():
        target = available.pop(name)
        bounds.append(target.bounds)
        entity.add(target, Row(name, f"{key}_state_topic", f"{key}_command_topic"))
    known = [pair for pair in bounds if pair and pair[0] < pair[1]]
    if known:
        entity.config |= {"min_temp": min(low for low, _ in known), "max_temp": max(high for _, high in known)}
