"""The parts of a Zigbee device, from its exposes. Pure.

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
    """Describe the parts of a device with unique ids. A device unknown to the bridge shows its raw messages."""
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
"""Features of the part itself; other features are parts of their own, mostly settings."""

_MOST_PARTS = 500


def _described(device: BridgeDevice, whole: Zigbee2MqttTopics, exposes: tuple[Expose, ...]) -> Iterable[DescribedPart]:
    auxiliary = _auxiliary(exposes)
    around = tuple([expose.of_commands() for expose in auxiliary.values()])
    for expose in map(_key_lock_as_setting, exposes):
        for part in _parts_of(device, whole, expose, exposes, auxiliary):
            yield _with_payloads(part, (expose.of_commands(), around)) if part.part.writes else part
    if device.has_updates and exposes:
        yield _update(whole)


def _with_payloads(described: DescribedPart, announced: object) -> DescribedPart:
    part = described.part.model_copy(update={"payloads": payload_digest(announced)}).slimmed()
    return replace(described, part=part)


def _parts_of(
    device: BridgeDevice,
    whole: Zigbee2MqttTopics,
    expose: Expose,
    exposes: tuple[Expose, ...],
    auxiliary: Mapping[str, Expose],
) -> Iterable[DescribedPart]:
    topics = whole.of(expose)
    if expose.type in SPECIFIC_TYPES:
        yield _specific(device, topics, expose, auxiliary)
        has_thermometer = any(other.name in _THERMOMETERS and other.is_published for other in exposes)
        if expose.type == "climate" and not has_thermometer and (thermometer := build_thermometer(topics, expose)):
            yield thermometer
        for feature in expose.features:
            if feature.name not in _FEATURES[expose.type] and (part := build_generic(topics, feature)):
                yield part
    else:
        part = _siren_or_opener(topics, expose, exposes, auxiliary)
        if part is None and expose is not auxiliary.get("effect"):
            part = build_generic(topics, expose)
        if part is not None:
            yield part


def _siren_or_opener(
    topics: Zigbee2MqttTopics, expose: Expose, exposes: tuple[Expose, ...], auxiliary: Mapping[str, Expose]
) -> DescribedPart | None:
    if expose.type == "composite" and expose.name == "warning" and expose.is_settable:
        return build_siren(Zigbee2MqttPart(topics, "siren" + expose.suffix, "siren", advertised="warning"), expose)
    if expose is auxiliary.get("opener"):
        is_pulse = all(other.name != "run_time" for other in exposes)
        return build_opener(_part_of(topics, expose, "closure"), expose, auxiliary["door"], is_pulse=is_pulse)
    if expose is auxiliary.get("siren"):  # a binary, as for Tuya's sirens; their sounds are settings
        part = _part_of(topics, expose, "siren")
        part.add_flag(expose, "on_off")
        part.request(expose)
        return part.build()
    return None


def _part_of(topics: Zigbee2MqttTopics, expose: Expose, service_type: str) -> Zigbee2MqttPart:
    return Zigbee2MqttPart(topics, clean_text(expose.key), service_type, name=expose.title, advertised=expose.name)


_THERMOMETERS = ("temperature", "local_temperature")
_KEY_LOCKS = ("child_lock", "keypad_lockout")


def _key_lock_as_setting(expose: Expose) -> Expose:
    """Replace a lock of the keys of a device, as older versions expose it, by the setting."""
    state = expose.feature("state") if expose.type == "lock" else None
    if state is None or not state.key.startswith(_KEY_LOCKS):
        return expose
    label = expose.label or state.key.replace("_", " ").capitalize()
    return replace(state, name=state.key, label=label, category=expose.category)


_DOOR = "garage_door_contact"
_TRIGGERS = frozenset({"trigger", "state"})
_ALARMS = frozenset({"alarm", "siren_on"})
_SOUNDS = frozenset({"alarm_duration", "alarm_ring", "melody", "ringtone", "volume"})
_MOTORS = frozenset({"motor_state", "moving"})


def _auxiliary(exposes: tuple[Expose, ...]) -> dict[str, Expose]:
    """Return the exposes that complete a part, or become one by the exposes beside them.

    These are the effect of a lamp, the motor of a cover, the program of a thermostat, the alarm of a device with
    sounds, and opener and contact of a garage door.
    """
    found: dict[str, Expose] = {}
    door = next((expose for expose in exposes if expose.name == _DOOR and expose.type == "binary"), None)
    has_lamp = any(expose.type == "light" and not expose.endpoint for expose in exposes)
    has_sounds = any(expose.name in _SOUNDS for expose in exposes)
    for expose in exposes:
        role = _auxiliary_role(expose, has_lamp=has_lamp, has_sounds=has_sounds, has_door=door is not None)
        if role and (role == "opener" or role not in found):
            found[role] = expose
    return {**found, "door": door} if door is not None and "opener" in found else found


def _auxiliary_role(expose: Expose, *, has_lamp: bool, has_sounds: bool, has_door: bool) -> str:
    if expose.type == "binary" and expose.is_settable:
        if has_door and expose.name in _TRIGGERS:
            return "opener"
        return "siren" if has_sounds and expose.name in _ALARMS else ""
    if expose.type != "enum":
        return ""
    if expose.name in _MOTORS:
        return f"motor{expose.suffix}" if expose.is_published else ""
    if is_program(expose):
        return "program"
    is_effect = expose.name == "effect" and expose.is_settable and not expose.endpoint
    return "effect" if is_effect and has_lamp else ""


def _specific(
    device: BridgeDevice, topics: Zigbee2MqttTopics, expose: Expose, auxiliary: Mapping[str, Expose]
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
            return build_light(part, expose, None if expose.endpoint else auxiliary.get("effect"))
        case "cover":
            return build_cover(part, expose, auxiliary.get(f"motor{expose.suffix}"))
        case "lock":
            return build_lock(part, expose)
        case "fan":
            return build_fan(part, expose, device.model)
        case _:
            return build_climate(part, expose, auxiliary.get("program"))


_SERVICES: Mapping[str, str] = {"light": "light", "cover": "window_covering", "lock": "door_lock", "fan": "fan"}


def _switch(topics: Zigbee2MqttTopics, expose: Expose) -> DescribedPart:
    """Describe a relay, or a setting if its property is no state, such as ``window_detection``."""
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
