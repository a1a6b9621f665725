"""Entities with one value each: switches, numbers, selects, buttons, sensors, events. Pure.

Source: Home Assistant core 2024.3 to 2025.4, ``components/mqtt``: binary_sensor.py, button.py, event.py, number.py,
scene.py, select.py, sensor.py, switch.py, tag.py, text.py.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from homebot.conventions.device_classes import CONDITION_CLASSES, QUANTITY_CLASSES
from homebot.conventions.homeassistant.published_entity import (
    EntityTopics,
    PublishedEntity,
    Values,
    flag_text,
    number_text,
    read_flag,
    reader_of,
    unknown_text,
)
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part

__all__ = ["publish_single"]


def publish_single(part: Part, capability: Capability, topics: EntityTopics) -> tuple[PublishedEntity, ...]:
    """Return what shows *capability* by itself; nothing for one that nothing can show."""
    known = CAPABILITIES.get(capability.name)
    if known is None or known.kind == "numbers":
        return ()
    if capability.name in _BUTTONS:
        return _button(capability, topics)
    if capability.settable:
        return (_setting(part, capability, topics),)
    return (_watched(part, capability, topics),) if capability.readable else ()


_BUTTONS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    "push": ("button", {"payload_press": "PRESS"}),
    "locate": ("button", {"payload_press": "PRESS", "device_class": "identify"}),
    "scene": ("scene", {"payload_on": "PRESS"}),
}
"""Capabilities that are pressed or called: the component, and its fields."""


def _button(capability: Capability, topics: EntityTopics) -> tuple[PublishedEntity, ...]:
    if not capability.settable:
        return ()
    component, fields = _BUTTONS[capability.name]
    entity = PublishedEntity(topics, component, capability.name, fields)
    entity.add_command("command_topic", capability.name, read_flag(capability.name, {"PRESS": True}))
    return (entity,)


def _setting(part: Part, capability: Capability, topics: EntityTopics) -> PublishedEntity:
    known = CAPABILITIES[capability.name]
    if known.kind == "bool":
        fields = {"device_class": "outlet"} if part.service_type == "plug" and capability.name == "on_off" else {}
        entity = PublishedEntity(topics, "switch", capability.name, fields)
        entity.has(capability, "state_topic", flag_text(capability.name), "command_topic")
        return entity
    if known.kind == "number":
        entity = PublishedEntity(topics, "number", capability.name, _number_fields(capability))
        entity.has(capability, "state_topic", number_text(capability.name), "command_topic")
        return entity
    options = capability.options or known.options
    entity = PublishedEntity(topics, "select" if options else "text", capability.name)
    if options:
        entity.config["options"] = list(options)
    if capability.readable:
        entity.add_state("state_topic", capability.name, unknown_text(capability.name))
    entity.add_command("command_topic", capability.name, reader_of(capability))
    return entity


def _number_fields(capability: Capability) -> dict[str, object]:
    known = CAPABILITIES[capability.name]
    low, high = capability.bounds or known.bounds or _WIDE
    if low >= high:
        low, high = _WIDE
    span = high - low
    fields: dict[str, object] = {"min": low, "max": high, "mode": "box" if span > _MOST_STEPS else "auto"}
    fields["step"] = next((step for most, step in _STEPS if span <= most), 1.0)
    unit = capability.unit or known.unit
    return {**fields, "unit_of_measurement": unit} if unit else fields


_WIDE = (-1e15, 1e15)
_MOST_STEPS = 200.0
_STEPS = ((1.0, 0.01), (50.0, 0.1))
"""The distance of the numbers that a person chooses from, by how far they reach."""


def _watched(part: Part, capability: Capability, topics: EntityTopics) -> PublishedEntity:
    known = CAPABILITIES[capability.name]
    if known.kind == "bool":
        classes = CONDITION_CLASSES.get(capability.name, ())
        device_class = part.tag if part.tag in classes else _USUAL_CLASSES.get(capability.name, "".join(classes[:1]))
        entity = PublishedEntity(topics, "binary_sensor", capability.name, _filled(device_class=device_class))
        entity.add_state("state_topic", capability.name, flag_text(capability.name))
        return entity
    if capability.name in _EVENTS:
        return _event(capability, topics)
    entity = PublishedEntity(topics, "sensor", capability.name)
    if known.kind == "number":
        entity.config |= _filled(
            device_class=QUANTITY_CLASSES.get(capability.name, ""),
            unit_of_measurement=capability.unit or known.unit,
            state_class="total_increasing" if capability.name == "energy" else "measurement",
        )
        entity.add_state("state_topic", capability.name, number_text(capability.name))
    else:
        entity.add_state("state_topic", capability.name, unknown_text(capability.name))
    return entity


_USUAL_CLASSES: Mapping[str, str] = {"contact": "opening", "occupancy": "occupancy"}
"""Of several classes, the one that says least besides."""

_EVENTS = frozenset({"press", "scan"})


def _event(capability: Capability, topics: EntityTopics) -> PublishedEntity:
    """Build an event entity: its message is published as it happens, and not retained."""
    name = capability.name
    if name == "press" and capability.options:
        entity = PublishedEntity(topics, "event", name, {"event_types": list(capability.options)})
        entity.add_state("state_topic", name, _event_text, is_event=True)
    elif name == "scan":
        entity = PublishedEntity(topics, "tag", name)
        entity.add_state("topic", name, unknown_text(name), is_event=True)
    else:
        entity = PublishedEntity(topics, "sensor", name)
        entity.add_state("state_topic", name, unknown_text(name), is_event=True)
    return entity


def _event_text(values: Values) -> str:
    return json.dumps({"event_type": values.get("press")}, ensure_ascii=False)


def _filled(**fields: str) -> dict[str, object]:
    return {key: value for key, value in fields.items() if value}
