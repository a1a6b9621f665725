"""Published locks, covers, valves, fans, vacuum cleaners, mowers, alarms and sirens, each as one entity. Pure.

Commands are the settable options of the vocabulary, never a state that is only reported, such as ``jammed``.

Source: Home Assistant core 2024.3 to 2026.11, ``components/mqtt``: alarm_control_panel.py, cover.py, fan.py,
lawn_mower.py, lock.py, siren.py, vacuum.py, valve.py.
"""

import json

from homebot.conventions.device_classes import CLOSURE_CLASSES
from homebot.conventions.entity_rows import ALARM_ACTIONS
from homebot.conventions.payload import compact_json, fields_of, number_of
from homebot.devices.part import Part
from homebot.integrations.homeassistant.formats.components import LOCK_STATES, MOWER_ACTIONS, VACUUM_ACTIONS
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
    entity.config |= _cover_class(part)
    if movement is not None:
        payloads = settable_payloads(movement, _MOVES)
        entity.config |= {key: payload if payload in payloads else None for key, payload in _MOVE_KEYS.items()}
        entity.add(movement, Row("movement", "state_topic", "command_topic", commands=_MOVES))
    position = available.get("position")
    if movement is not None or (position is not None and _COVER_ROWS[0].fits(position)):
        entity.add_rows(available, _COVER_ROWS)


def _cover_class(part: Part) -> dict[str, object]:
    if part.service_type == "closure":
        return {"device_class": part.tag if part.tag in CLOSURE_CLASSES else "door"}
    return {"device_class": part.tag} if part.tag in _COVERINGS else {}


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
