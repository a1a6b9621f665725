"""The parts of a Zigbee device, from its exposes. Pure.

Source: zigbee2mqtt.io, Usage > Exposes.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial

from homebot.conventions.command_values import push_writer
from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import with_own_ids
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text, read_progress
from homebot.conventions.secrets import names_secret
from homebot.devices.part import payload_digest
from homebot.integrations.zigbee2mqtt.formats.bridge_device import BridgeDevice
from homebot.integrations.zigbee2mqtt.formats.controls import (
    build_climate,
    build_cover,
    build_fan,
    build_lock,
    build_opener,
    build_siren,
    build_thermometer,
    build_valve,
    is_program,
    type_of_climate,
)
from homebot.integrations.zigbee2mqtt.formats.expose import SPECIFIC_TYPES, Expose, read_exposes
from homebot.integrations.zigbee2mqtt.formats.features import Zigbee2MqttPart, Zigbee2MqttTopics, text_of
from homebot.integrations.zigbee2mqtt.formats.generic import build_generic
from homebot.integrations.zigbee2mqtt.formats.light import build_light


def build_parts(device: BridgeDevice) -> tuple[DescribedPart, ...]:
    """Describe the parts of a device with unique ids. A device unknown to the bridge shows its raw messages."""
    topics = Zigbee2MqttTopics(device.topic, device.is_awake, device.takes_transition, device.bare_endpoints)
    builder = _PartsBuilder(device, topics, read_exposes(device.exposes))
    return with_own_ids(builder.parts(), _MAX_PARTS) or (_unknown(topics),)


_MAX_PARTS = 500
_MAX_RAW_VALUES = 20
_MAX_RAW = 255
_SERVICES: Mapping[str, str] = {"light": "light", "cover": "window_covering", "lock": "door_lock", "fan": "fan"}
_MAIN = frozenset({"climate", "cover", "fan", "lock"})
"""Types that are the main purpose of any device that has one."""

_THERMOMETERS = ("temperature", "local_temperature")
_KEY_LOCKS = ("child_lock", "keypad_lockout")
_DOOR = "garage_door_contact"
_OWN_VALVES = frozenset({"gas_valve_state", "valve_1", "valve_2"})
"""Names of the binaries of valves that are no switches: SiHAS GCM-300Z, Giex GX03."""

_VALVES = re.compile(r"\b(valves?|walve|irrigation|sprinkler|water(ing)? timer)\b", re.IGNORECASE)
"""Words of models whose switch is a valve, which is on while it is open: Sonoff SWV, Giex QT06, Parkside PSBZS A1."""

_ROLES: Mapping[tuple[str, str], str] = {
    **dict.fromkeys((("binary", "trigger"), ("binary", "state")), "opener"),
    **dict.fromkeys((("binary", "alarm"), ("binary", "siren_on")), "siren"),
    ("enum", "effect"): "effect",
}
"""Role by type and name of a settable expose, if the exposes beside it make it possible."""

_SOUNDS = frozenset({"alarm_duration", "alarm_ring", "melody", "ringtone", "volume"})
_MOTORS = frozenset({"motor_state", "moving"})


class _PartsBuilder:
    """Builder of the parts of one device.

    Auxiliary exposes complete a part, or become one by the exposes beside them, by role: the effect of a lamp, the
    motor of a cover, the program of a thermostat, the alarm of a device with sounds (``siren``, as of Tuya), and opener
    and contact (``door``) of a garage door.
    """

    def __init__(self, device: BridgeDevice, topics: Zigbee2MqttTopics, exposes: tuple[Expose, ...]) -> None:
        self._device = device
        self._topics = topics
        self._exposes = exposes
        self._names = {expose.name for expose in exposes}
        types = {expose.type for expose in exposes} & SPECIFIC_TYPES.keys()
        is_valve = types <= {"switch"} and _VALVES.search(device.facts.get("model", ""))
        self._valves = _OWN_VALVES | {"state"} if is_valve else _OWN_VALVES
        self._door = next((expose for expose in exposes if expose.name == _DOOR and expose.type == "binary"), None)
        self._possible_roles = self._find_possible_roles()
        self._auxiliary: dict[str, Expose] = {}
        for expose in exposes:
            role = self._role(expose)
            if role == "opener" or (role and role not in self._auxiliary):
                self._auxiliary[role] = expose
        if self._door is not None and "opener" in self._auxiliary:
            self._auxiliary["door"] = self._door

    def parts(self) -> Iterable[DescribedPart]:
        exposes = map(_key_lock_as_setting, self._exposes)
        mains = _MAIN | {"switch"} if "state" in self._valves else _MAIN
        for expose in sorted(exposes, key=lambda expose: expose.type not in mains):
            yield from self._parts_of(self._topics.of(expose), expose)
        if self._device.has_updates and self._exposes:
            part = Zigbee2MqttPart(self._topics, "update", "x_update", advertised="update", category="diagnostic")
            part.read_from(self._topics.state, _read_update)
            for capability in ("version", "latest_version", "update_available", "running"):
                part.add_capability(capability)
            part.add_capability("update_progress", unit="%")
            yield part.build()
        for number, name in self._device.scenes.items():
            part = Zigbee2MqttPart(
                self._topics, f"scene_{number}", "x_scene", name=clean_text(name), advertised="scene"
            )
            writer = push_writer("scene", partial(self._topics.publish, {"scene_recall": number}))
            part.add_capability("scene", readable=False, writer=writer)
            yield part.build()

    def _find_possible_roles(self) -> frozenset[str]:
        roles = {
            "opener": self._door is not None,
            "siren": not _SOUNDS.isdisjoint(self._names),
            "effect": any(expose.type == "light" and not expose.endpoint for expose in self._exposes),
        }
        return frozenset(role for role, is_possible in roles.items() if is_possible)

    def _role(self, expose: Expose) -> str:
        """Return the role of an auxiliary expose; empty for any other."""
        if expose.type == "enum" and expose.name in _MOTORS and expose.is_published:
            return f"motor{expose.suffix}"
        if is_program(expose):
            return "program"
        role = _ROLES.get((expose.type, expose.name), "")
        is_of_endpoint = role == "effect" and expose.endpoint
        return role if role in self._possible_roles and expose.is_settable and not is_of_endpoint else ""

    def _parts_of(self, topics: Zigbee2MqttTopics, expose: Expose) -> Iterable[DescribedPart]:
        """Describe *expose*, with a digest of all that its commands follow from."""
        digest = ""
        for part in self._valve(topics, expose) or self._build_parts(topics, expose):
            if not part.part.writes:
                yield part
                continue
            if not digest:
                around = [expose.of_commands() for expose in self._auxiliary.values()]
                digest = payload_digest((expose.of_commands(), tuple(around)))
            yield part._replace(part=part.part.model_copy(update={"payloads": digest}))

    def _valve(self, topics: Zigbee2MqttTopics, expose: Expose) -> tuple[DescribedPart, ...]:
        """Describe a valve by its own binary, or by the switch of a model that is one; empty for any other expose."""
        state = expose.feature("state") or expose
        if state.name not in self._valves or not state.is_settable:
            return ()
        name = clean_text(expose.endpoint)
        part = Zigbee2MqttPart(topics, clean_text(state.key), "water_valve", name=name, advertised=expose.type)
        return (build_valve(part, state),)

    def _build_parts(self, topics: Zigbee2MqttTopics, expose: Expose) -> Iterable[DescribedPart]:
        if expose.type not in SPECIFIC_TYPES:
            part: DescribedPart | None = None
            if expose.type == "composite" and expose.name == "warning" and expose.is_settable:
                siren = Zigbee2MqttPart(topics, "siren" + expose.suffix, "siren", advertised="warning")
                part = build_siren(siren, expose)
            elif expose is self._auxiliary.get("opener"):
                closure = Zigbee2MqttPart.of(topics, expose, "closure")
                is_pulse = "run_time" not in self._names
                part = build_opener(closure, expose, self._auxiliary["door"], is_pulse=is_pulse)
            elif expose is self._auxiliary.get("siren"):
                siren = Zigbee2MqttPart.of(topics, expose, "siren")
                siren.add_flag(expose, "on_off")
                siren.request(expose)
                part = siren.build()
            elif expose is not self._auxiliary.get("effect"):
                part = build_generic(topics, expose)
            return (part,) if part else ()
        codecs = [self._specific(topics, expose)]
        if expose.type == "climate" and not any(
            expose.name in _THERMOMETERS and expose.is_published for expose in self._exposes
        ):
            codecs.append(build_thermometer(topics, expose))
        own = SPECIFIC_TYPES[expose.type]
        codecs += [build_generic(topics, other) for other in expose.features if other.name not in own]
        return filter(None, codecs)

    def _specific(self, topics: Zigbee2MqttTopics, expose: Expose) -> DescribedPart | None:
        if expose.type == "switch":
            return _switch(topics, expose)
        part = Zigbee2MqttPart(
            topics,
            expose.type + expose.suffix,
            type_of_climate(expose) if expose.type == "climate" else _SERVICES[expose.type],
            name=clean_text(expose.endpoint),
            advertised=expose.type,
            category=expose.category,
        )
        match expose.type:
            case "light":
                return build_light(part, expose, None if expose.endpoint else self._auxiliary.get("effect"))
            case "cover":
                return build_cover(part, expose, self._auxiliary.get(f"motor{expose.suffix}"))
            case "lock":
                return build_lock(part, expose)
            case "fan":
                return build_fan(part, expose, self._device.model)
            case _:
                return build_climate(part, expose, self._auxiliary.get("program"))


def _key_lock_as_setting(expose: Expose) -> Expose:
    """Replace a lock of the keys of a device, as older versions expose it, by the setting."""
    state = expose.feature("state") if expose.type == "lock" else None
    if state is None or not state.key.startswith(_KEY_LOCKS):
        return expose
    label = expose.label or state.key.replace("_", " ").capitalize()
    return replace(state, name=state.key, label=label, category=expose.category)


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


def _read_update(message: JsonMessage) -> Readings:
    """Read versions; -1 and null are unknown ones."""
    update = message.get("update")
    if not isinstance(update, dict):
        return NO_READINGS
    versions = {"version": update.get("installed_version"), "latest_version": update.get("latest_version")}
    known = {name: None if value in (None, -1) else text_of(value) for name, value in versions.items()}
    state = update.get("state")
    is_known = isinstance(state, str)
    progress = read_progress({**update, "updating": state == "updating" if is_known else None}, "updating", "progress")
    return {**known, "update_available": state in _AVAILABLE if is_known else None, **progress}


_AVAILABLE = frozenset({"available", "scheduled", "updating"})


def _unknown(topics: Zigbee2MqttTopics) -> DescribedPart:
    part = Zigbee2MqttPart(topics, "", "x_unknown")
    part.read_from(topics.state, _read_raw)
    part.add_capability("raw")
    return part.build()


def _read_raw(message: JsonMessage) -> Readings:
    shown = [(key, value) for key, value in message.items() if not names_secret(key)]
    text = ", ".join(f"{key}={text_of(value)}" for key, value in shown[:_MAX_RAW_VALUES])
    return {"raw": clean_text(text, _MAX_RAW)}
