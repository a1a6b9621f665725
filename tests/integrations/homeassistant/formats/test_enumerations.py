"""Enumerations of discovery, each in small letters and otherwise, against the validators of Home Assistant.

Source: Home Assistant core: ``vol.Lower`` in ``DEVICE_CLASSES_SCHEMA`` and ``STATE_CLASSES_SCHEMA`` of each component,
and in the ``schema`` of lights; ``cv.temperature_unit``; ``vol.In``, ``vol.Coerce`` of an enumeration or a literal,
which refuse capitals, elsewhere: ``availability_mode`` and ``qos`` in ``mqtt/schemas.py`` (0f5c1b54),
``ENTITY_CATEGORIES_SCHEMA`` in ``helpers/entity.py``, ``on_command_type`` in ``mqtt/light/schema_basic.py``,
``AUTOMATION_TYPES_SCHEMA`` in ``mqtt/device_automation.py``, ``device_class`` in ``mqtt/humidifier.py`` (20dc1b2c),
``mode`` in ``mqtt/number.py`` and ``mqtt/text.py``, ``image_encoding`` in ``mqtt/image.py`` and ``mqtt/camera.py``.
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
TAKEN: list[tuple[str, dict[str, Any], str, str]] = [
    ("humidifier", {**LAMP, "target_humidity_command_topic": "h"}, "device_class", "Dehumidifier"),
    ("number", LAMP, "mode", "Box"),
    ("text", LAMP, "mode", "Password"),
    ("camera", {"topic": "t"}, "image_encoding", "B64"),
    ("image", {"image_topic": "t"}, "image_encoding", "B64"),
]
"""What Home Assistant refuses although its meaning is plain: a device that works is not lost for it."""


@pytest.mark.parametrize(("component", "fields", "key", "value"), AS_LOWER + TAKEN)
def test_a_value_in_capitals_that_home_assistant_puts_in_small_letters_means_the_same(
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
