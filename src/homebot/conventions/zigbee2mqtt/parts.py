"""The parts of a Zigbee device: what it exposes, each with its codec. Pure.

Source: zigbee2mqtt.io, Usage > Exposes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import with_own_ids
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text
from homebot.conventions.secrets import names_secret
from homebot.conventions.zigbee2mqtt.bridge_device import BridgeDevice
from homebot.conventions.zigbee2mqtt.climate import (
    FEATURES_OF_CLIMATE,
    build_climate,
    build_thermometer,
    climate_type,
    is_program,
)
from homebot.conventions.zigbee2mqtt.controls import (
    FEATURES_OF_COVER,
    FEATURES_OF_FAN,
    FEATURES_OF_LOCK,
    build_cover,
    build_fan,
    build_lock,
    build_opener,
    build_siren,
)
from homebot.conventions.zigbee2mqtt.expose import SPECIFIC_TYPES, Expose, read_exposes
from homebot.conventions.zigbee2mqtt.features import Zigbee2MqttPart, Zigbee2MqttTopics, text_of
from homebot.conventions.zigbee2mqtt.generic import build_generic
from homebot.conventions.zigbee2mqtt.light import FEATURES_OF_LIGHT, build_light
from homebot.devices.command_description import payload_digest

__all__ = ["build_parts"]


def build_parts(device: BridgeDevice) -> tuple[DescribedPart, ...]:
    """Describe the parts of a device, each id once. One unknown to the bridge shows its messages as they are."""
    topics = Zigbee2MqttTopics(device.topic, device.is_awake, device.takes_transition, device.bare_endpoints)
    exposes = read_exposes(device.exposes)
    return with_own_ids(_described(device, topics, exposes), _MOST_PARTS) or (_unknown(topics),)


_FEATURES: Mapping[str, frozenset[str]] = {
    "light": FEATURES_OF_LIGHT,
    "switch": frozenset({"state"}),
    "cover": FEATURES_OF_COVER,
    "lock": FEATURES_OF_LOCK,
    "climate": FEATURES_OF_CLIMATE,
    "fan": FEATURES_OF_FAN,
}
"""Features of the part itself; others are parts of their own, mostly settings."""

_MOST_PARTS = 500


def _described(device: BridgeDevice, whole: Zigbee2MqttTopics, exposes: tuple[Expose, ...]) -> Iterable[DescribedPart]:
    beside = _beside(exposes)
    around = tuple([one.of_commands() for one in beside.values()])
    for expose in map(_key_lock_as_setting, exposes):
        for part in _parts_of(device, whole, expose, exposes, beside):
            yield _with_payloads(part, (expose.of_commands(), around)) if part.part.writes else part
    if device.has_updates and exposes:
        yield _update(whole)


def _with_payloads(described: DescribedPart, announced: object) -> DescribedPart:
    part = described.part.with_checked(payloads=payload_digest(announced)).slimmed()
    return replace(described, part=part)


def _parts_of(
    device: BridgeDevice,
    whole: Zigbee2MqttTopics,
    expose: Expose,
    exposes: tuple[Expose, ...],
    beside: Mapping[str, Expose],
) -> Iterable[DescribedPart]:
    topics = whole.of(expose)
    if expose.type in SPECIFIC_TYPES:
        yield _specific(device, topics, expose, beside)
        has_thermometer = any(one.name in _THERMOMETERS and one.is_published for one in exposes)
        if expose.type == "climate" and not has_thermometer and (thermometer := build_thermometer(topics, expose)):
            yield thermometer
        rest = [one for one in expose.features if one.name not in _FEATURES[expose.type]]
    elif expose.type == "composite" and expose.name == "warning" and expose.is_settable:
        yield build_siren(Zigbee2MqttPart(topics, "siren" + expose.suffix, "siren", advertised="warning"), expose)
        rest = []
    elif expose is beside.get("opener"):
        is_pulse = all(one.name != "run_time" for one in exposes)
        yield build_opener(_opener_part(topics, expose), expose, beside["door"], is_pulse=is_pulse)
        rest = []
    elif expose is beside.get("siren"):
        yield _switched_siren(topics, expose)
        rest = []
    else:
        rest = [] if expose is beside.get("effect") else [expose]
    yield from (part for one in rest if (part := build_generic(topics, one)) is not None)


_THERMOMETERS = ("temperature", "local_temperature")
_KEY_LOCKS = ("child_lock", "keypad_lockout")


def _key_lock_as_setting(expose: Expose) -> Expose:
    """Return the setting in place of a lock that only locks the keys of a device, as older versions expose it."""
    state = expose.feature("state") if expose.type == "lock" else None
    if state is None or not state.key.startswith(_KEY_LOCKS):
        return expose
    label = expose.label or state.key.replace("_", " ").capitalize()
    return replace(state, name=state.key, label=label, category=expose.category)


def _beside(exposes: tuple[Expose, ...]) -> dict[str, Expose]:
    """Return the exposes that stand beside a part and belong to it, or are a part by what stands beside them.

    The effects of the lamp, how the motor of a cover turns, whether a thermostat follows its program, and the alarm of
    what has a melody or a volume for it, and what moves a garage door.
    """
    found: dict[str, Expose] = {}
    has_lamp = any(one.type == "light" and not one.endpoint for one in exposes)
    is_loud = any(one.name in _SOUNDS for one in exposes)
    door = next((one for one in exposes if one.name == "garage_door_contact" and one.type == "binary"), None)
    for one in exposes:
        if door is not None and one.type == "binary" and one.name in _TRIGGERS and one.is_settable:
            found.update(opener=one, door=door)
        if is_loud and one.type == "binary" and one.name in _ALARMS and one.is_settable:
            found.setdefault("siren", one)
        if one.type != "enum":
            continue
        if one.name == "effect" and one.is_settable and not one.endpoint and has_lamp:
            found.setdefault("effect", one)
        if one.name in ("motor_state", "moving") and one.is_published:
            found.setdefault(f"motor{one.suffix}", one)
        if is_program(one):
            found.setdefault("program", one)
    return found


_TRIGGERS = frozenset({"trigger", "state"})


def _opener_part(topics: Zigbee2MqttTopics, trigger: Expose) -> Zigbee2MqttPart:
    return Zigbee2MqttPart(topics, clean_text(trigger.key), "closure", name=trigger.title, advertised=trigger.name)


_ALARMS = frozenset({"alarm", "siren_on"})
_SOUNDS = frozenset({"alarm_duration", "alarm_ring", "melody", "ringtone", "volume"})


def _switched_siren(topics: Zigbee2MqttTopics, alarm: Expose) -> DescribedPart:
    """Describe a siren that is switched by a binary, as those of Tuya are; how it sounds is set beside it."""
    part = Zigbee2MqttPart(topics, clean_text(alarm.key), "siren", name=alarm.title, advertised=alarm.name)
    part.add_flag(alarm, "on_off")
    part.request(alarm)
    return part.build()


def _specific(
    device: BridgeDevice, topics: Zigbee2MqttTopics, expose: Expose, beside: Mapping[str, Expose]
) -> DescribedPart:
    if expose.type == "switch":
        return _switch(topics, expose)
    service_type = climate_type(expose) if expose.type == "climate" else _SERVICES[expose.type]
    part = Zigbee2MqttPart(
        topics,
        expose.type + expose.suffix,
        service_type,
        name=clean_text(expose.endpoint),
        advertised=expose.type,
        category=expose.category,
    )
    match expose.type:
        case "light":
            return build_light(part, expose, None if expose.endpoint else beside.get("effect"))
        case "cover":
            return build_cover(part, expose, beside.get(f"motor{expose.suffix}"))
        case "lock":
            return build_lock(part, expose)
        case "fan":
            return build_fan(part, expose, device.model)
        case _:
            return build_climate(part, expose, beside.get("program"))


_SERVICES: Mapping[str, str] = {"light": "light", "cover": "window_covering", "lock": "door_lock", "fan": "fan"}


def _switch(topics: Zigbee2MqttTopics, expose: Expose) -> DescribedPart:
    """Describe a relay. One whose property is no state, such as ``window_detection``, is a setting."""
    state = expose.feature("state")
    is_setting = state is not None and not state.key.startswith("state")
    part = Zigbee2MqttPart(
        topics,
        clean_text(state.key) if state is not None and is_setting else "switch" + expose.suffix,
        "x_setting" if is_setting else "switch",
        name=clean_text(expose.label if is_setting else expose.endpoint),
        advertised="switch",
        category=expose.category or ("config" if is_setting else ""),
    )
    part.add_flag(state, "on_off")
    part.request(state)
    return part.build()


def _update(topics: Zigbee2MqttTopics) -> DescribedPart:
    part = Zigbee2MqttPart(topics, "update", "x_update", advertised="update", category="diagnostic")
    part.read_from(topics.state, _read_update)
    for capability in ("version", "latest_version", "update_available"):
        part.add_capability(capability)
    return part.build()


def _read_update(message: JsonMessage) -> Readings:
    """Read versions; -1 and null are unknown ones."""
    update = message.get("update")
    if not isinstance(update, dict):
        return NO_READINGS
    versions = {"version": update.get("installed_version"), "latest_version": update.get("latest_version")}
    known = {name: None if value in (None, -1) else text_of(value) for name, value in versions.items()}
    state = update.get("state")
    return {**known, "update_available": state == "available" if isinstance(state, str) else None}


def _unknown(topics: Zigbee2MqttTopics) -> DescribedPart:
    part = Zigbee2MqttPart(topics, "", "x_unknown")
    part.read_from(topics.state, _read_raw)
    part.add_capability("raw")
    return part.build()


def _read_raw(message: JsonMessage) -> Readings:
    shown = [(key, value) for key, value in message.items() if not names_secret(key)]
    text = ", ".join(f"{key}={text_of(value)}" for key, value in shown[:_MOST_RAW])
    return {"raw": clean_text(text, _MAX_RAW)}


_MOST_RAW = 20
_MAX_RAW = 255
