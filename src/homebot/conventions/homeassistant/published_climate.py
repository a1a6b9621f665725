"""Thermostats, air conditioners, water heaters and humidifiers that are offered, each as one entity. Pure.

Source: Home Assistant core 2024.3 to 2025.4, ``components/mqtt``: climate.py, humidifier.py, water_heater.py.
"""

from __future__ import annotations

from homebot.conventions.homeassistant.published_entity import (
    Available,
    EntityTopics,
    PublishedEntity,
    flag_text,
    number_text,
    take_choice,
    take_reported,
    take_settable,
    unknown_text,
)
from homebot.devices.part import Part

__all__ = ["publish_climate", "publish_humidifier", "publish_water_heater"]

Entities = tuple[PublishedEntity, ...]


def publish_climate(part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take what a thermostat or an air conditioner reaches, measures and does.

    A target that Home Assistant would take for another one by its modes stays a number of its own, and so does a mode
    with options that are none of Home Assistant's.
    """
    if part.service_type not in _CLIMATES:
        return ()
    mode = available.get("thermostat_mode")
    modes = mode.options if mode is not None and mode.settable and set(mode.options) <= _MODES else ()
    targets = _targets(available, modes)
    if not modes and not targets:
        return ()
    shown = modes or tuple(_MODE_OF[key, name] for name, key in targets.items())[:1]
    entity = PublishedEntity(topics, "climate", "", {"temperature_unit": "C", "modes": list(shown)})
    if modes:
        entity.has(
            available.pop("thermostat_mode"), "mode_state_topic", unknown_text("thermostat_mode"), "mode_command_topic"
        )
        if "off" in modes and (switch := available.get("on_off")) and switch.settable:
            entity.has(
                available.pop("on_off").model_copy(update={"readable": False}),
                "",
                flag_text("on_off"),
                "power_command_topic",
            )
    _add_targets(entity, available, targets)
    _add_measured(entity, available)
    _add_choices(entity, available)
    if take_reported(available, "thermostat_action"):
        entity.add_state("action_topic", "thermostat_action", unknown_text("thermostat_action"))
    return (entity,)


_CLIMATES = frozenset({"thermostat", "room_air_conditioner"})
_MODES = frozenset({"auto", "off", "cool", "heat", "heat_cool", "dry", "fan_only"})
_HEATING = frozenset({"heat", "heat_cool", "auto"})
_COOLING = frozenset({"cool", "heat_cool"})
_MODE_OF = {
    ("temperature", "heating_setpoint"): "heat",
    ("temperature", "cooling_setpoint"): "cool",
    ("temperature_low", "heating_setpoint"): "heat_cool",
    ("temperature_high", "cooling_setpoint"): "heat_cool",
}
"""The mode of one that has no modes, by its target."""


def _targets(available: Available, modes: tuple[str, ...]) -> dict[str, str]:
    """Return by capability what Home Assistant calls it there."""
    heats, cools = (name in available and available[name].settable for name in ("heating_setpoint", "cooling_setpoint"))
    if heats and cools:
        return {"heating_setpoint": "temperature_low", "cooling_setpoint": "temperature_high"}
    if heats and not _COOLING & set(modes):
        return {"heating_setpoint": "temperature"}
    if cools and (not modes or "cool" in modes) and not _HEATING & set(modes):
        return {"cooling_setpoint": "temperature"}
    return {}


def _add_targets(entity: PublishedEntity, available: Available, targets: dict[str, str]) -> None:
    bounds: list[tuple[float, ...]] = []
    for name, key in targets.items():
        target = available.pop(name)
        bounds.append(target.bounds)
        entity.has(target, f"{key}_state_topic", number_text(name), f"{key}_command_topic")
    known = [one for one in bounds if one and one[0] < one[1]]
    if known:
        entity.config |= {"min_temp": min(one[0] for one in known), "max_temp": max(one[1] for one in known)}


def _add_measured(entity: PublishedEntity, available: Available) -> None:
    for name, key in (("local_temperature", "current_temperature_topic"), ("humidity", "current_humidity_topic")):
        if take_reported(available, name):
            entity.add_state(key, name, number_text(name))


def _add_choices(entity: PublishedEntity, available: Available) -> None:
    for name in ("fan_mode", "swing_mode"):
        if choice := take_choice(available, name):
            entity.config[f"{name}s"] = list(choice.options)
            entity.has(choice, f"{name}_state_topic", unknown_text(name), f"{name}_command_topic")
    preset = available.get("preset_mode")
    if preset is not None and preset.settable and "none" in preset.options and len(preset.options) > 1:
        available.pop("preset_mode")
        entity.config["preset_modes"] = [one for one in preset.options if one != "none"]
        entity.has(preset, "preset_mode_state_topic", unknown_text("preset_mode"), "preset_mode_command_topic")


def publish_water_heater(part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take how warm the water shall be, how warm it is, and how it is heated."""
    if part.service_type != "water_heater":
        return ()
    target = take_settable(available, "heating_setpoint")
    if target is None:
        return ()
    mode = available.get("water_heater_mode")
    modes = mode.options if mode is not None and mode.settable and set(mode.options) <= _HEATER_MODES else ()
    entity = PublishedEntity(topics, "water_heater", "", {"temperature_unit": "C", "modes": list(modes)})
    available[target.name] = target
    _add_targets(entity, available, {target.name: "temperature"})
    if modes:
        entity.has(
            available.pop("water_heater_mode"),
            "mode_state_topic",
            unknown_text("water_heater_mode"),
            "mode_command_topic",
        )
    if take_reported(available, "local_temperature"):
        entity.add_state("current_temperature_topic", "local_temperature", number_text("local_temperature"))
    return (entity,)


_HEATER_MODES = frozenset({"eco", "electric", "gas", "heat_pump", "high_demand", "performance", "off"})


def publish_humidifier(part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take the switch of a humidifier with the humidity that it shall reach."""
    is_whole = all(name in available and available[name].settable for name in ("on_off", "humidity_setpoint"))
    if part.service_type != "x_humidifier" or not is_whole:
        return ()
    kind = "dehumidifier" if part.tag == "dehumidifier" else "humidifier"
    entity = PublishedEntity(topics, "humidifier", "", {"device_class": kind})
    entity.has(available.pop("on_off"), "state_topic", flag_text("on_off"), "command_topic")
    target = available.pop("humidity_setpoint")
    if target.bounds and 0 <= target.bounds[0] < target.bounds[1] <= _MOST_HUMID:
        entity.config |= {"min_humidity": target.bounds[0], "max_humidity": target.bounds[1]}
    entity.has(target, "target_humidity_state_topic", number_text(target.name), "target_humidity_command_topic")
    if take_reported(available, "humidity"):
        entity.add_state("current_humidity_topic", "humidity", number_text("humidity"))
    if mode := take_choice(available, "humidifier_mode", unlike="None"):
        entity.config["modes"] = list(mode.options)
        entity.has(mode, "mode_state_topic", unknown_text("humidifier_mode"), "mode_command_topic")
    return (entity,)


_MOST_HUMID = 100.0
