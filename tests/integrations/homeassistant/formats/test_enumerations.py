"""Enumerations of discovery, each in small letters and otherwise, against the validators of Home Assistant.

Source: Home Assistant core 2025.4: ``vol.Lower`` in ``DEVICE_CLASSES_SCHEMA`` and ``STATE_CLASSES_SCHEMA`` of each
component, and in the ``schema`` of lights; ``cv.temperature_unit``; ``vol.In`` and ``vol.Coerce`` of an enumeration,
which refuse capitals, elsewhere in ``components/mqtt``.
"""

from typing import Any

import pytest
from tests.integrations.announced_parts import homeassistant_parts

from homebot.errors import WireError

STATE, SET = {"state_topic": "s"}, {"command_topic": "c"}
LAMP = {**STATE, **SET}

AS_LOWER: list[tuple[str, dict[str, Any], str, str]] = [
    ("binary_sensor", STATE, "device_class", "Smoke"),
    ("button", SET, "device_class", "Identify"),
    ("cover", LAMP, "device_class", "Door"),
    ("event", {**STATE, "event_types": ["a"]}, "device_class", "Doorbell"),
    ("number", LAMP, "device_class", "Temperature"),
    ("sensor", {**STATE, "unit_of_measurement": "°C"}, "device_class", "Temperature"),
    ("sensor", STATE, "state_class", "Measurement"),
    ("switch", LAMP, "device_class", "OUTLET"),
    ("update", STATE, "device_class", "Firmware"),
    ("valve", LAMP, "device_class", "Water"),
    ("light", LAMP, "schema", "JSON"),
    ("climate", {"temperature_command_topic": "t"}, "temperature_unit", "F"),
]
REFUSED: list[tuple[str, dict[str, Any], str, Any]] = [
    ("sensor", STATE, "entity_category", "Diagnostic"),
    ("sensor", {**STATE, "availability": [{"topic": "a"}]}, "availability_mode", "ALL"),
    ("light", LAMP, "on_command_type", "First"),
    ("light", {**LAMP, "schema": "json"}, "supported_color_modes", ["RGB"]),
    ("sensor", STATE, "qos", 3),
    ("device_automation", {"topic": "t", "type": "a", "subtype": "b"}, "automation_type", "Trigger"),
]


@pytest.mark.parametrize(("component", "fields", "key", "value"), AS_LOWER)
def test_a_value_that_home_assistant_puts_in_small_letters_means_the_same(
    component: str, fields: dict[str, Any], key: str, value: str
) -> None:
    told, small = (homeassistant_parts(component, {**fields, key: one})[0] for one in (value, value.lower()))
    assert told.part.model_copy(update={"payloads": small.part.payloads}) == small.part  # a digest of the config


@pytest.mark.parametrize(("component", "fields", "key", "value"), REFUSED)
def test_a_value_that_home_assistant_refuses_is_refused(
    component: str, fields: dict[str, Any], key: str, value: object
) -> None:
    with pytest.raises(WireError, match=key):
        homeassistant_parts(component, {**fields, key: value})
    good = value.lower() if isinstance(value, str) else ["rgb"] if isinstance(value, list) else 1
    assert homeassistant_parts(component, {**fields, key: good})


@pytest.mark.parametrize(
    ("fields", "fades"),
    [
        ({"schema": "json", "brightness": True}, True),
        ({"schema": "json", "brightness": True, "transition": True}, True),
        ({"schema": "json", "brightness": True, "transition": False}, False),
        ({"brightness_command_topic": "x/level"}, False),
        ({"schema": "template", "command_on_template": "on,{{ brightness }}"}, False),
        ({"schema": "template", "command_on_template": "on,{{ brightness }},{{ transition }}"}, True),
    ],
)
def test_a_lamp_without_transitions_is_told_none_and_says_so(fields: dict[str, object], *, fades: bool) -> None:
    own = (
        {"brightness_template": "{{ value }}", "command_off_template": "off"} if "command_on_template" in fields else {}
    )
    (part,) = homeassistant_parts("light", {**LAMP, **own, **fields})
    assert part.part.fades is fades
    assert (part.codec.write("level", 50.0, transition=3.0) != part.codec.write("level", 50.0)) is fades


def test_glass_that_breaks_is_tampering() -> None:
    (part,) = homeassistant_parts("binary_sensor", {**STATE, "device_class": "glass_break"})
    assert [one.name for one in part.part.capabilities] == ["tamper"]
