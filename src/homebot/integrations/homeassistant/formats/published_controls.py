"""Published devices, each as one entity: locks, lights, covers, climate, fans, robots, alarms and sirens. Pure.

Commands are the settable options of the vocabulary, never a state that is only reported, such as ``jammed``. A lamp is
a light of schema ``json``: one object reports it, one commands it.

Source: Home Assistant core 2024.3 to 2026.11, ``components/mqtt``: alarm_control_panel.py, climate.py, cover.py,
fan.py, humidifier.py, lawn_mower.py, ``light/schema_json.py``, lock.py, siren.py, vacuum.py, valve.py, water_heater.py.
"""

import json
from collections.abc import Mapping

from homebot.conventions.device_classes import CLOSURE_CLASSES
from homebot.conventions.entity_rows import ALARM_ACTIONS
from homebot.conventions.lamp import LightCommand
from homebot.conventions.light_color import kelvin_mired
from homebot.conventions.payload import compact_json, fields_of, number_of
from homebot.devices.part import Part
from homebot.integrations.homeassistant.formats.components import LOCK_STATES, MOWER_ACTIONS, VACUUM_ACTIONS
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.light_messages import JsonLight
from homebot.integrations.homeassistant.formats.published_entity import (
    Available,
    PublishedEntity,
    Row,
    Values,
    is_settable,
    payload_reader,
    settable_payloads,
)
from homebot.support.numbers import to_number

_LOCK_ROW = Row(
    "lock", "state_topic", "command_topic", commands={"LOCK": "locked", "UNLOCK": "unlocked", "OPEN": "open"}
)
_MOVES = {"OPEN": "open", "CLOSE": "closed", "STOP": "stopped"}
_MOVE_KEYS = {"payload_open": "OPEN", "payload_close": "CLOSE", "payload_stop": "STOP"}
_COVERINGS = frozenset({"awning", "blind", "curtain", "shade", "shutter"})
_COVER_ROWS = (
    Row("position", "position_topic", "set_position_topic", unknown="", is_reported=True),
    Row("tilt", "tilt_status_topic", "tilt_command_topic", unknown="", is_reported=True),
)
FAN_ROWS = (
    Row("on_off", "state_topic", "command_topic"),
    Row("fan_speed", "percentage_state_topic", "percentage_command_topic"),
    Row("preset_mode", "preset_mode_state_topic", "preset_mode_command_topic", "preset_modes", reserved="None"),
    Row(
        "oscillation",
        "oscillation_state_topic",
        "oscillation_command_topic",
        unknown="",
        payloads=("oscillate_on", "oscillate_off"),
    ),
    Row("direction", "direction_state_topic", "direction_command_topic", unknown=""),
)
_CODES = ("code_arm_required", "code_disarm_required", "code_trigger_required")


def publish_lock(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish the bolt, and the latch if the options have ``open``."""
    entity.config |= {f"state_{state}": state for state in LOCK_STATES}
    if "open" in available["lock"].options:
        entity.config["payload_open"] = "OPEN"
    entity.add(available.pop("lock"), _LOCK_ROW)


def publish_cover(entity: PublishedEntity, available: Available, part: Part) -> None:
    """Publish movement, position and tilt.

    A position or a tilt that is never reported is left out: Home Assistant sets none that it does not know.
    """
    movement = available.pop("movement") if is_settable(available, "movement") else None
    if part.service_type == "closure":
        entity.config["device_class"] = part.tag if part.tag in CLOSURE_CLASSES else "door"
    elif part.tag in _COVERINGS:
        entity.config["device_class"] = part.tag
    if movement is not None:
        payloads = settable_payloads(movement, _MOVES)
        entity.config |= {key: payload if payload in payloads else None for key, payload in _MOVE_KEYS.items()}
        entity.add(movement, Row("movement", "state_topic", "command_topic", commands=_MOVES))
    position = available.get("position")
    if movement is not None or (position is not None and _COVER_ROWS[0].fits(position)):
        entity.add_rows(available, _COVER_ROWS)


def publish_valve(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish a valve. With a reported position, open and closed are positions."""
    valve = available.pop("valve")
    payloads = settable_payloads(valve, _MOVES)
    if "STOP" in payloads:
        entity.config["payload_stop"] = "STOP"
    position = available.get("position")
    if valve.readable and position is not None and position.settable and position.readable:
        available.pop("position")
        entity.config["reports_position"] = True
        entity.add_state("state_topic", "valve", _valve_text, ("valve", "position"))
        entity.add_command("command_topic", "valve", _read_valve)
        return
    entity.config |= {
        key: payload if payload in payloads else None for key, payload in _MOVE_KEYS.items() if key != "payload_stop"
    }
    entity.add(valve, Row("valve", "state_topic", "command_topic", commands=_MOVES))


def _valve_text(values: Values) -> str:
    position, state = values.get("position"), values.get("valve")
    if position is None and state == "closed":
        position = 0.0
    if position is None:
        return "None"
    return json.dumps({"position": position, **({"state": state} if state in {"opening", "closing"} else {})})


def _read_valve(text: str) -> Values:
    if text == "STOP":
        return {"valve": "stopped"}
    percent = to_number(text)
    return {"position": percent} if percent is not None and 0 <= percent <= 100 else {}


def publish_vacuum(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish the state, the power and the locator of a robot that cleans."""
    vacuum = available.pop("vacuum")
    payloads = settable_payloads(vacuum, {action: state for state, (_, action) in VACUUM_ACTIONS.items()})
    commands: dict[str, Values] = {action: {"vacuum": state} for action, state in payloads.items()}
    features = [action.replace("return_to_base", "return_home") for action in payloads]
    if vacuum.readable:
        reported = ["vacuum"]
        speed = available.get("fan_mode")
        if speed is not None and speed.settable and speed.options:
            reported.append(available.pop("fan_mode").name)
            features.append("fan_speed")
            entity.config["fan_speed_list"] = list(speed.options)
            options = {option: option for option in speed.options}
            entity.add_command("set_fan_speed_topic", "fan_mode", payload_reader("fan_mode", options))
        entity.add_state("state_topic", "vacuum", _vacuum_text, reported)
    if is_settable(available, "locate"):
        available.pop("locate")
        features.append("locate")
        commands["locate"] = {"locate": True}
    entity.config["supported_features"] = features
    entity.add_command("command_topic", "vacuum", lambda text: commands.get(text, {}))


def _vacuum_text(values: Values) -> str:
    state, speed = values.get("vacuum"), values.get("fan_mode")
    message: dict[str, object] = {"state": "cleaning" if state == "spot" else state}
    if isinstance(speed, str):
        message["fan_speed"] = speed
    return compact_json(message)


def publish_mower(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish the activity of a robot that mows."""
    mower = available.pop("mower")
    payloads = settable_payloads(mower, {action: state for state, (_, action) in MOWER_ACTIONS.items()})
    if mower.readable:
        entity.add_state("activity_state_topic", "mower")
    for action in payloads:
        entity.add_command(f"{action}_command_topic", "mower", payload_reader("mower", payloads))


def publish_alarm(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish an alarm. It asks for no code: a client that may command homebot may command it."""
    payloads = {action.upper(): state for state, (_, action) in ALARM_ACTIONS.items()}
    features = [payload.lower() for payload in settable_payloads(available["alarm"], payloads) if payload != "DISARM"]
    entity.config |= {"supported_features": features, **dict.fromkeys(_CODES, False)}
    entity.add_state("state_topic", "alarm")  # required
    entity.add(available.pop("alarm"), Row("alarm", "", "command_topic", commands=payloads))


def publish_siren(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish the switch, the tones and the volume of a siren."""
    switch = available.pop("on_off")
    has_volume = is_settable(available, "volume")
    entity.config |= {"support_volume_set": has_volume, "support_duration": False}
    tone = available.get("siren_tone")
    tones = tone.options if tone is not None and tone.settable else ()
    names = ["on_off", *(["siren_tone"] if tones else []), *(["volume"] if has_volume else [])]
    if tones:
        entity.config["available_tones"] = list(tones)
    for name in names[1:]:
        available.pop(name)
    if switch.readable:
        entity.add_state("state_topic", "siren", _siren_text, names)
    entity.add_command("command_topic", "siren", lambda text: _read_siren(text, tones, has_volume=has_volume))


def _siren_text(values: Values) -> str:
    on, tone, volume = (values.get(name) for name in ("on_off", "siren_tone", "volume"))
    message: dict[str, object] = {} if on is None else {"state": "ON" if on else "OFF"}
    if isinstance(tone, str):
        message["tone"] = tone
    if isinstance(volume, float):
        message["volume_level"] = volume / 100
    return compact_json(message)


def _read_siren(text: str, tones: tuple[str, ...], *, has_volume: bool) -> Values:
    message = fields_of(text)
    if message.get("state") not in ("ON", "OFF"):
        return {}
    if message["state"] == "OFF":
        return {"on_off": False}
    tone, volume = message.get("tone"), number_of(message.get("volume_level"))
    return {
        **({"siren_tone": tone} if isinstance(tone, str) and tone in tones else {}),
        **({"volume": volume * 100} if has_volume and volume is not None and 0 <= volume <= 1 else {}),
        "on_off": True,
    }


_TINTS = ("color", "color_temperature")
_WHITES = (2_000.0, 6_500.0)


def publish_light(entity: PublishedEntity, available: Available, _part: Part) -> None:
    """Publish a lamp that can be switched.

    White and colour belong to it only if its brightness can be set: Home Assistant knows no other lamps.
    """
    switch = available.pop("on_off")
    names = (*_TINTS, "level", "effect") if is_settable(available, "level") else ("effect",)
    lamp = {name: available.pop(name) for name in names if is_settable(available, name)}

    def write(values: Values) -> str:
        command = _command_of({name: values.get(name) for name in ("on_off", *lamp)})
        message = light.message(command)
        if values.get("on_off") is None:
            message["state"] = None
        if command.mode or lamp.keys().isdisjoint(_TINTS):
            message["color_mode"] = command.mode or _modes(lamp)[0]
        return compact_json(message)

    def read(text: str) -> Values:
        readings = light.read(text.encode())
        if readings.get("on_off") is not True:
            return {"on_off": False} if readings.get("on_off") is False else {}
        return {**{name: readings[name] for name in lamp if readings.get(name) is not None}, "on_off": True}

    config: dict[str, object] = {"schema": "json", "color_mode": True, "supported_color_modes": _modes(lamp)}
    if "level" in lamp:
        config["brightness"] = True
    if "color_temperature" in lamp:
        low, high = lamp["color_temperature"].bounds or _WHITES
        config |= {"min_mireds": max(1, kelvin_mired(high)), "max_mireds": max(2, kelvin_mired(low))}
    if "effect" in lamp:
        config["effect"] = True
        if lamp["effect"].options:
            config["effect_list"] = list(lamp["effect"].options)
    entity.config |= config
    if switch.readable:
        entity.add_state("state_topic", "light", write, ("on_off", *lamp))
    entity.add_command("command_topic", "light", read)
    light = JsonLight(DiscoveryConfig("light", "", {**entity.config, "effect_list": None}))


def _command_of(values: Values) -> LightCommand:
    """Return the command that would set the *values*."""
    command = LightCommand(on=values["on_off"] is True)
    match values.get("color"), values.get("color_temperature"):
        case tuple() as color, _:
            command = command._replace(mode="hs", color=color)
        case _, float() as white if white > 0:
            command = command._replace(mode="color_temp", white=white)
    level, effect = values.get("level"), values.get("effect")
    if isinstance(level, float) and level > 0:
        command = command._replace(level=level)
    return command._replace(effect=effect) if isinstance(effect, str) else command


def _modes(lamp: Mapping[str, object]) -> list[str]:
    modes = [mode for name, mode in (("color_temperature", "color_temp"), ("color", "hs")) if name in lamp]
    return modes or ["brightness" if "level" in lamp else "onoff"]


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
