"""Published entities with one value each: switches, numbers, selects, buttons, sensors, events. Pure.

Source: Home Assistant core 2024.3 to 2025.4, ``components/mqtt``: binary_sensor.py, button.py, event.py, number.py,
scene.py, select.py, sensor.py, switch.py, tag.py, text.py.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from homebot.conventions.device_classes import CONDITION_CLASSES, QUANTITY_CLASSES
from homebot.conventions.homeassistant.published_entity import WIDE, PublishedEntity, Row, Values, payload_reader
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part

__all__ = ["publish_single"]

_BUTTONS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    "push": ("button", {"payload_press": "PRESS"}),
    "locate": ("button", {"payload_press": "PRESS", "device_class": "identify"}),
    "scene": ("scene", {"payload_on": "PRESS"}),
}
"""Component and fields of the capabilities that are pressed."""

_MOST_STEPS = 200.0
_STEPS = ((1.0, 0.01), (50.0, 0.1))
"""The step of a number entity, by the width of its range."""

_USUAL_CLASSES: Mapping[str, str] = {"contact": "opening", "occupancy": "occupancy"}
"""The most general of several classes."""


def publish_single(part: Part, capability: Capability, base: str) -> tuple[PublishedEntity, ...]:
    """Return the entity of *capability* alone; none if Home Assistant has no component for it."""
    known = CAPABILITIES.get(capability.name)
    if known is None or known.kind == "numbers":
        return ()
    if capability.name in _BUTTONS:
        return _button(capability, base)
    if capability.settable:
        return (_setting(part, capability, base),)
    return (_sensor(part, capability, base),) if capability.readable else ()


def _button(capability: Capability, base: str) -> tuple[PublishedEntity, ...]:
    if not capability.settable:
        return ()
    component, fields = _BUTTONS[capability.name]
    entity = PublishedEntity(base, component, capability.name, fields)
    entity.add_command("command_topic", capability.name, payload_reader(capability.name, {"PRESS": True}))
    return (entity,)


def _setting(part: Part, capability: Capability, base: str) -> PublishedEntity:
    known = CAPABILITIES[capability.name]
    options = capability.options or known.options
    fields: Mapping[str, object] = {}
    if known.kind == "bool":
        component = "switch"
        if part.service_type == "plug" and capability.name == "on_off":
            fields = {"device_class": "outlet"}
    elif known.kind == "number":
        component, fields = "number", _number_fields(capability)
    else:
        component, fields = ("select", {"options": list(options)}) if options else ("text", {})
    entity = PublishedEntity(base, component, capability.name, fields)
    entity.add(capability, Row(capability.name, "state_topic", "command_topic"))
    return entity


def _number_fields(capability: Capability) -> dict[str, object]:
    known = CAPABILITIES[capability.name]
    low, high = capability.bounds or known.bounds or WIDE
    if low >= high:
        low, high = WIDE
    span = high - low
    fields: dict[str, object] = {"min": low, "max": high, "mode": "box" if span > _MOST_STEPS else "auto"}
    fields["step"] = next((step for most, step in _STEPS if span <= most), 1.0)
    unit = capability.unit or known.unit
    return {**fields, "unit_of_measurement": unit} if unit else fields


def _sensor(part: Part, capability: Capability, base: str) -> PublishedEntity:
    """Build a sensor or an event; the message of an event is not retained."""
    name, known = capability.name, CAPABILITIES[capability.name]
    if name == "press" and capability.options:
        entity = PublishedEntity(base, "event", name, {"event_types": list(capability.options)})
        entity.add_state("state_topic", name, _event_text, is_event=True)
        return entity
    if name == "scan":
        entity = PublishedEntity(base, "tag", name)
        entity.add_state("topic", name, is_event=True)
        return entity
    if known.kind == "bool":
        classes = CONDITION_CLASSES.get(name, ())
        device_class = part.tag if part.tag in classes else _USUAL_CLASSES.get(name, "".join(classes[:1]))
        entity = PublishedEntity(base, "binary_sensor", name, _filled(device_class=device_class))
    elif known.kind == "number":
        fields = _filled(
            device_class=QUANTITY_CLASSES.get(name, ""),
            unit_of_measurement=capability.unit or known.unit,
            state_class="total_increasing" if name == "energy" else "measurement",
        )
        entity = PublishedEntity(base, "sensor", name, fields)
    else:
        entity = PublishedEntity(base, "sensor", name)
    entity.add_state("state_topic", name, is_event=name == "press")
    return entity


def _event_text(values: Values) -> str:
    return json.dumps({"event_type": values.get("press")}, ensure_ascii=False)


def _filled(**fields: str) -> dict[str, object]:
    return {key: value for key, value in fields.items() if value}
