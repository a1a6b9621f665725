"""Locks, covers, valves, fans, vacuum cleaners, mowers, alarms and sirens that are offered, each as one entity. Pure.

What is commanded is what the vocabulary says can be set, never a state that is only reported, such as ``jammed``.

Source: Home Assistant core 2024.3 to 2025.4, ``components/mqtt``: alarm_control_panel.py, cover.py, fan.py,
lawn_mower.py, lock.py, siren.py, vacuum.py, valve.py.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from homebot.conventions.homeassistant.published_entity import (
    Available,
    EntityTopics,
    PublishedEntity,
    Values,
    flag_text,
    number_text,
    read_flag,
    read_number,
    read_option,
    take_choice,
    take_reported,
    take_settable,
    unknown_text,
)
from homebot.conventions.payload import compact_json, fields_of, number_of
from homebot.devices.part import Capability, Part

__all__ = [
    "publish_alarm",
    "publish_cover",
    "publish_fan",
    "publish_lock",
    "publish_mower",
    "publish_siren",
    "publish_vacuum",
    "publish_valve",
]

Entities = tuple[PublishedEntity, ...]


def publish_lock(_part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take the bolt. Its latch can be drawn where its options say ``open``."""
    lock = take_settable(available, "lock")
    if lock is None:
        return ()
    fields = {f"state_{state}": state for state in _LOCK_STATES}
    entity = PublishedEntity(topics, "lock", "", fields)
    payloads = {"LOCK": "locked", "UNLOCK": "unlocked"}
    if "open" in lock.options:
        payloads["OPEN"] = "open"
        entity.config["payload_open"] = "OPEN"
    if lock.readable:
        entity.add_state("state_topic", "lock", unknown_text("lock"))
    entity.add_command("command_topic", "lock", read_option("lock", payloads))
    return (entity,)


_LOCK_STATES = ("locked", "unlocked", "locking", "unlocking", "open", "opening", "jammed")


def publish_cover(part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take what moves, how far it is open and how its slats are.

    A position or a tilt that is not reported back is no part of it: Home Assistant sets none that it does not know.
    """
    movement = take_settable(available, "movement")
    position = _take_percentage(available, "position")
    if movement is None and position is None:
        return ()
    entity = PublishedEntity(topics, "cover", "", _cover_class(part))
    if movement is not None:
        payloads = _settable_payloads(movement, _MOVES)
        entity.config |= {key: payload if payload in payloads else None for key, payload in _MOVE_KEYS.items()}
        if movement.readable:
            entity.add_state("state_topic", "movement", unknown_text("movement"))
        entity.add_command("command_topic", "movement", read_option("movement", payloads))
    if position is not None:
        entity.add_state("position_topic", "position", number_text("position", unknown=""))
        entity.add_command("set_position_topic", "position", read_number("position", _PERCENT))
    if _take_percentage(available, "tilt") is not None:
        entity.add_state("tilt_status_topic", "tilt", number_text("tilt", unknown=""))
        entity.add_command("tilt_command_topic", "tilt", read_number("tilt", _PERCENT))
    return (entity,)


_PERCENT = (0.0, 100.0)
_MOVES = {"OPEN": "open", "CLOSE": "closed", "STOP": "stopped"}
_MOVE_KEYS = {"payload_open": "OPEN", "payload_close": "CLOSE", "payload_stop": "STOP"}
_CLOSURES = frozenset({"damper", "door", "garage", "gate", "window"})
_COVERINGS = frozenset({"awning", "blind", "curtain", "shade", "shutter"})


def _cover_class(part: Part) -> dict[str, object]:
    if part.service_type == "closure":
        return {"device_class": part.tag if part.tag in _CLOSURES else "door"}
    return {"device_class": part.tag} if part.tag in _COVERINGS else {}


def _take_percentage(available: Available, name: str) -> Capability | None:
    known = available.get(name)
    return available.pop(name) if known is not None and known.settable and known.readable else None


def _settable_payloads(capability: Capability, payloads: Mapping[str, str]) -> dict[str, str]:
    """Return the payloads of what *capability* can be set to: of its options, or else all."""
    return {key: option for key, option in payloads.items() if not capability.options or option in capability.options}


def publish_valve(_part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take the valve, and how far it is open where that is reported back: then open and closed are positions."""
    valve = take_settable(available, "valve")
    if valve is None:
        return ()
    payloads = _settable_payloads(valve, _MOVES)
    position = _take_percentage(available, "position") if valve.readable else None
    entity = PublishedEntity(topics, "valve", "")
    if "STOP" in payloads:
        entity.config["payload_stop"] = "STOP"
    if position is not None:
        entity.config["reports_position"] = True
        entity.add_state("state_topic", "valve", _valve_text, ("valve", "position"))
        entity.add_command("command_topic", "valve", _read_valve)
        return (entity,)
    entity.config |= {
        key: payload if payload in payloads else None for key, payload in _MOVE_KEYS.items() if key != "payload_stop"
    }
    if valve.readable:
        entity.add_state("state_topic", "valve", unknown_text("valve"))
    entity.add_command("command_topic", "valve", read_option("valve", payloads))
    return (entity,)


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
    return read_number("position", _PERCENT)(text)


def publish_fan(part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take the switch of a fan, and with it its speed, its programmes, its swing and its direction."""
    if part.service_type != "fan":
        return ()
    switch = take_settable(available, "on_off")
    if switch is None:
        return ()
    entity = PublishedEntity(topics, "fan", "")
    entity.has(switch, "state_topic", flag_text("on_off"), "command_topic")
    if speed := take_settable(available, "fan_speed"):
        entity.has(speed, "percentage_state_topic", number_text("fan_speed"), "percentage_command_topic")
    if preset := take_choice(available, "preset_mode", unlike="None"):
        entity.config["preset_modes"] = list(preset.options)
        entity.has(preset, "preset_mode_state_topic", unknown_text("preset_mode"), "preset_mode_command_topic")
    if swing := take_settable(available, "oscillation"):
        entity.has(swing, "oscillation_state_topic", flag_text("oscillation", *_SWINGS, unknown=""))
        entity.add_command(
            "oscillation_command_topic",
            "oscillation",
            read_flag("oscillation", dict(zip(_SWINGS, (True, False), strict=True))),
        )
    if direction := take_settable(available, "direction"):
        entity.has(direction, "direction_state_topic", _direction_text, "direction_command_topic")
    return (entity,)


_SWINGS = ("oscillate_on", "oscillate_off")


def _direction_text(values: Values) -> str:
    direction = values.get("direction")
    return direction if isinstance(direction, str) else ""


def publish_vacuum(_part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take what a robot that cleans does, its power, its charge and how it is found."""
    vacuum = take_settable(available, "vacuum")
    if vacuum is None:
        return ()
    payloads = _settable_payloads(vacuum, {payload: option for payload, (option, _) in _VACUUM.items()})
    features = [_VACUUM[payload][1] for payload in payloads]
    entity = PublishedEntity(topics, "vacuum", "", {"supported_features": features})
    taken = {"vacuum"}
    if vacuum.readable:
        if speed := take_choice(available, "fan_mode"):
            taken.add("fan_mode")
            features.append("fan_speed")
            entity.config["fan_speed_list"] = list(speed.options)
            entity.add_command(
                "set_fan_speed_topic", "fan_mode", read_option("fan_mode", {one: one for one in speed.options})
            )
        if take_reported(available, "battery"):
            taken.add("battery")
            features.append("battery")
        entity.add_state("state_topic", "vacuum", _vacuum_text, taken)
    locate = take_settable(available, "locate")
    if locate is not None:
        features.append("locate")

    def read(text: str) -> Values:
        if text == "locate" and locate is not None:
            return {"locate": True}
        return {"vacuum": payloads[text]} if text in payloads else {}

    entity.add_command("command_topic", "vacuum", read)
    return (entity,)


_VACUUM: Mapping[str, tuple[str, str]] = {
    "start": ("cleaning", "start"),
    "pause": ("paused", "pause"),
    "stop": ("idle", "stop"),
    "return_to_base": ("returning", "return_home"),
    "clean_spot": ("spot", "clean_spot"),
}
"""By payload: what it commands, and the feature that says so."""


def _vacuum_text(values: Values) -> str:
    state, speed, charge = (values.get(name) for name in ("vacuum", "fan_mode", "battery"))
    message: dict[str, object] = {"state": "cleaning" if state == "spot" else state}
    if isinstance(speed, str):
        message["fan_speed"] = speed
    if isinstance(charge, float):
        message["battery_level"] = round(charge)
    return compact_json(message)


def publish_mower(_part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take what a robot that mows does."""
    mower = take_settable(available, "mower")
    if mower is None:
        return ()
    payloads = _settable_payloads(mower, _MOWER)
    entity = PublishedEntity(topics, "lawn_mower", "")
    if mower.readable:
        entity.add_state("activity_state_topic", "mower", unknown_text("mower"))
    for action in payloads:
        entity.add_command(f"{action}_command_topic", "mower", read_option("mower", payloads))
    return (entity,)


_MOWER = {"start_mowing": "mowing", "pause": "paused", "dock": "docked"}


def publish_alarm(_part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take the alarm. It asks for no code: what may command, may command it."""
    alarm = take_settable(available, "alarm")
    if alarm is None:
        return ()
    payloads = {payload: option for payload, option in _ALARM.items() if not alarm.options or option in alarm.options}
    features = [payload.lower() for payload in payloads if payload != "DISARM"]
    fields = {"supported_features": features, **dict.fromkeys(_CODES, False)}
    entity = PublishedEntity(topics, "alarm_control_panel", "", fields)
    entity.add_state("state_topic", "alarm", unknown_text("alarm"))
    entity.add_command("command_topic", "alarm", read_option("alarm", payloads))
    return (entity,)


_CODES = ("code_arm_required", "code_disarm_required", "code_trigger_required")
_ALARM = {
    "DISARM": "disarmed",
    "ARM_HOME": "armed_home",
    "ARM_AWAY": "armed_away",
    "ARM_NIGHT": "armed_night",
    "ARM_VACATION": "armed_vacation",
    "ARM_CUSTOM_BYPASS": "armed_custom_bypass",
    "TRIGGER": "triggered",
}


def publish_siren(part: Part, available: Available, topics: EntityTopics) -> Entities:
    """Take the switch of a siren, and with it its tones and its volume."""
    if part.service_type != "siren":
        return ()
    switch = take_settable(available, "on_off")
    if switch is None:
        return ()
    volume = take_settable(available, "volume")
    entity = PublishedEntity(topics, "siren", "", {"support_volume_set": volume is not None, "support_duration": False})
    tones: tuple[str, ...] = ()
    if tone := take_choice(available, "siren_tone"):
        tones = tone.options
        entity.config["available_tones"] = list(tones)
    taken = ("on_off", *(("siren_tone",) if tones else ()), *(("volume",) if volume else ()))
    if switch.readable:
        entity.add_state("state_topic", "siren", _siren_text, taken)
    entity.add_command("command_topic", "siren", lambda text: _read_siren(text, tones, has_volume=volume is not None))
    return (entity,)


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
