"""The steps that devices announce: what a command becomes before it is sent, and what the device is told."""

import json
from collections.abc import Mapping

import pytest
from tests.integrations.announced_parts import heard, homeassistant_part, homie_part, zigbee2mqtt_part
from tests.integrations.homeassistant.gateway.test_entities import only
from tests.integrations.homekit.formats.test_parts import part as homekit_service

from homebot.control.command import device_settings
from homebot.conventions.capability_row import described
from homebot.conventions.description import DescribedPart
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.integrations.esphome.formats.kinds import KINDS

TOPICS = {
    "command_topic": "c",
    "state_topic": "s",
    "brightness_command_topic": "b",
    "brightness_state_topic": "bs",
    "percentage_command_topic": "p",
    "percentage_state_topic": "ps",
    "set_position_topic": "o",
    "position_topic": "os",
    "tilt_command_topic": "t",
    "tilt_status_topic": "ts",
    "temperature_command_topic": "h",
    "temperature_state_topic": "hs",
}


def sent(described: DescribedPart, capability: str, wanted: float) -> tuple[PlainValue, list[str]]:
    """What control makes of *wanted*, and the payloads that the device gets."""
    ((name, value),) = device_settings({capability: wanted}, described.part).items()
    return value, [one.payload.decode() for one in described.codec.write(name, value)]


@pytest.mark.parametrize(
    ("component", "fields", "capability", "wanted", "value", "payload"),
    [
        ("light", {"brightness_scale": 10}, "level", 44.0, 40.0, "4"),
        ("light", {"brightness_scale": 10}, "level", 1.0, 10.0, "1"),  # not off
        ("light", {"brightness_scale": 10}, "level", 99.0, 100.0, "10"),
        ("light", {"brightness_scale": 1}, "level", 44.0, 100.0, "1"),
        ("light", {"brightness_scale": 100}, "level", 50.0, 50.0, "50"),
        ("light", {"brightness_scale": 99}, "level", 50.0, pytest.approx(50 / 0.99), "50"),
        ("light", {"brightness_scale": 254}, "level", 10.0, 10.0, "26"),  # as Home Assistant
        ("fan", {"speed_range_max": 3}, "fan_speed", 44.0, pytest.approx(200 / 3), "2"),
        ("fan", {"speed_range_max": 3}, "fan_speed", 67.0, pytest.approx(200 / 3), "2"),
        ("fan", {"speed_range_max": 3}, "fan_speed", 34.0, pytest.approx(200 / 3), "2"),
        ("fan", {"speed_range_max": 3}, "fan_speed", 0.2, pytest.approx(100 / 3), "1"),
        ("fan", {"speed_range_min": 4, "speed_range_max": 10}, "fan_speed", 50.0, pytest.approx(400 / 7), "7"),
        ("cover", {"position_open": 10}, "position", 44.0, 40.0, "4"),
        ("cover", {"position_open": 0, "position_closed": 10}, "position", 44.0, 40.0, "6"),
        ("cover", {"position_open": 0, "position_closed": 100}, "position", 44.0, 44.0, "56"),
        ("cover", {"tilt_min": 0, "tilt_max": 4}, "tilt", 40.0, 50.0, "2"),
        ("cover", {"tilt_min": 4, "tilt_max": 0}, "tilt", 80.0, 75.0, "1"),
        ("climate", {"temp_step": 5, "min_temp": 10, "max_temp": 40}, "heating_setpoint", 22.0, 20.0, "20.0"),
        ("climate", {"temp_step": 5}, "heating_setpoint", 22.0, 20.0, "20.0"),  # from 0, not from the usual 7
        ("climate", {"precision": 0.5}, "heating_setpoint", 21.3, 21.5, "21.5"),
        ("climate", {"precision": 1.0, "temp_step": 0.5}, "heating_setpoint", 21.4, 21.5, "21.5"),
        (
            "climate",
            {"temperature_unit": "F", "temp_step": 1},
            "heating_setpoint",
            21.0,
            pytest.approx(190 / 9),
            "70.0",
        ),
        ("climate", {}, "heating_setpoint", 21.3, 21.3, "21.3"),
        ("number", {"min": 1, "max": 10, "step": 2}, "number", 4.2, 5.0, "5"),
        ("number", {"min": 1, "max": 10, "step": 2}, "number", 10.0, 9.0, "9"),
        ("number", {"min": -5, "max": 5, "step": 0.1}, "number", 0.04, 0.0, "0"),
        ("number", {"min": 0, "max": 5, "step": 10}, "number", 3.0, 3.0, "3"),  # a step that cannot be meant
        ("number", {"min": 0, "max": 5, "step": "often"}, "number", 3.3, 3.3, "3.3"),
        ("number", {"min": 0, "max": 5}, "number", 3.3, 3.3, "3.3"),
    ],
)
def test_a_device_of_home_assistant_gets_a_value_that_it_can_do(
    component: str, fields: Mapping[str, object], capability: str, wanted: float, value: object, payload: str
) -> None:
    described = homeassistant_part(capability, component, {**TOPICS, **fields})
    found, payloads = sent(described, capability, wanted)
    assert found == value
    assert payload in payloads


@pytest.mark.parametrize(
    ("scale", "payload", "level"), [(100, "50", 50.0), (10, "4", 40.0), (254, "127", 50.0), (255, "255", 100.0)]
)
@pytest.mark.parametrize("schema", ["basic", "json"])
def test_a_brightness_is_read_on_its_own_scale(schema: str, scale: int, payload: str, level: float) -> None:
    fields = {**TOPICS, "schema": schema, "brightness": True, "brightness_scale": scale}
    part = homeassistant_part("level", "light", fields)
    topic, told = ("bs", payload) if schema == "basic" else ("s", f'{{"state":"ON","brightness":{payload}}}')
    assert heard(part, topic, told)["level"] == level


@pytest.mark.rooms("homie")
@pytest.mark.parametrize(
    ("field", "wanted", "value", "told"),
    [
        ({"datatype": "integer", "format": "0:100:5"}, 23.0, 25.0, "25"),
        ({"datatype": "integer", "format": "0:100:30"}, 99.0, 90.0, "90"),
        ({"datatype": "integer", "format": "3:100:10"}, 20.0, 23.0, "23"),
        ({"datatype": "float", "format": ":2:0.25"}, 1.1, 1.0, "1"),
        ({"datatype": "float", "format": "0:1"}, 0.3, 0.3, "0.3"),
    ],
)
def test_a_number_of_homie_has_its_step(field: Mapping[str, object], wanted: float, value: float, told: str) -> None:
    described = homie_part("number", {"n": {**field, "settable": True}}, "vent")
    assert sent(described, "number", wanted) == (value, [told])


@pytest.mark.rooms("homie")
def test_a_level_of_homie_has_its_step_in_percent() -> None:
    props = {"on": {"datatype": "boolean", "settable": True}}
    props["brightness"] = {"datatype": "integer", "format": "0:100:25", "unit": "%", "settable": True}
    level = next(one for one in homie_part("level", props, "light").part.capabilities if one.name == "level")
    assert [level.nearest(one) for one in (0.0, 1.0, 44.0, 100.0)] == [0.0, 25.0, 50.0, 100.0]


@pytest.mark.rooms("zigbee2mqtt")
@pytest.mark.parametrize(("wanted", "told"), [(200.0, 225), (30.0, 0), (600.0, 600)])
def test_a_setting_of_zigbee2mqtt_has_its_value_step(wanted: float, told: int) -> None:
    expose = {"type": "numeric", "name": "range", "property": "range", "access": 7}
    described = zigbee2mqtt_part("number", {**expose, "value_min": 0, "value_max": 600, "value_step": 75})
    assert sent(described, "number", wanted) == (float(told), [json.dumps({"range": told}, separators=(",", ":"))])


@pytest.mark.parametrize(
    ("entity", "attributes", "capability", "wanted", "value", "data"),
    [
        ("number.a", {"min": 1, "max": 10, "step": 3}, "number", 5.0, 4.0, {"value": 4.0}),
        ("input_number.a", {"min": 0, "max": 10, "step": 0.5}, "number", 5.3, 5.5, {"value": 5.5}),
        ("fan.a", {"percentage_step": 100 / 3, "supported_features": 1}, "fan_speed", 44.0, 66.67, {"percentage": 66}),
        ("fan.a", {"percentage_step": 100 / 3, "supported_features": 1}, "fan_speed", 90.0, 100.0, {"percentage": 100}),
        (
            "climate.a",
            {"hvac_modes": ["heat"], "supported_features": 1, "target_temp_step": 0.5, "min_temp": 7, "max_temp": 35},
            "heating_setpoint",
            21.3,
            21.5,
            {"temperature": 21.5},
        ),
        (
            "humidifier.a",
            {"humidity": 40, "min_humidity": 30, "max_humidity": 80, "target_humidity_step": 10},
            "humidity_setpoint",
            57.0,
            60.0,
            {"humidity": 60},
        ),
    ],
)
def test_an_entity_of_a_home_assistant_has_its_step(
    entity: str, attributes: dict[str, object], capability: str, wanted: float, value: float, data: object
) -> None:
    found = only(entity, "on", **attributes)
    ((name, rounded),) = device_settings({capability: wanted}, found.part()).items()
    assert rounded == pytest.approx(value, abs=0.005)
    assert found.call(name, rounded).data == data


def esphome(kind: str, capability: str, info: Mapping[str, object]) -> Capability:
    return next(one for one, _ in described(KINDS[kind].rows, info) if one.name == capability)


@pytest.mark.parametrize(
    ("kind", "capability", "info", "wanted", "value"),
    [
        ("number", "number", {"min_value": 1.0, "max_value": 9.0, "step": 2.0}, 4.2, 5.0),
        ("number", "number", {"min_value": 0.0, "max_value": 1.0, "step": 0.10000000149011612}, 0.72, 0.7),
        ("fan", "fan_speed", {"supports_speed": True, "supported_speed_count": 4}, 51.0, 75.0),
        (
            "climate",
            "heating_setpoint",
            {
                "supported_modes": [3],
                "visual_min_temperature": 10.0,
                "visual_max_temperature": 30.0,
                "visual_target_temperature_step": 0.5,
            },
            21.3,
            21.5,
        ),
    ],
)
def test_an_entity_of_esphome_has_its_step(
    kind: str, capability: str, info: Mapping[str, object], wanted: float, value: float
) -> None:
    assert esphome(kind, capability, info).nearest(wanted) == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "characteristic", "limits", "capability", "wanted", "value"),
    [
        ("43", "8", {"minValue": 0, "maxValue": 100, "minStep": 10}, "level", 44.0, 40.0),
        ("43", "8", {"minValue": 0, "maxValue": 100, "minStep": 10}, "level", 2.0, 10.0),
        ("BD", "CA", {"minValue": 30, "maxValue": 80, "minStep": 10}, "humidity_setpoint", 57.0, 60.0),
    ],
)
def test_a_characteristic_of_homekit_has_its_step(
    kind: str, characteristic: str, limits: dict[str, object], capability: str, wanted: float, value: float
) -> None:
    switch = {"43": "25", "BD": "B0"}[kind]
    found = homekit_service(kind, {switch: 1, characteristic: 50}, "", **{f"c{characteristic}": limits})
    (described,) = [one for one in found.part.capabilities if one.name == capability]
    assert described.nearest(wanted) == value


def test_a_value_on_the_grid_stays_and_one_out_of_bounds_is_left_to_be_refused() -> None:
    for step in (0.1, 0.3, 1 / 3, 5.0, 7.0):
        capability = Capability(name="number", bounds=(-20.0, 20.0), grid=(-20.0, step))
        for number in range(int(40 / step)):
            value = round(-20 + number * step, 9)
            assert capability.nearest(value) == value
        assert capability.nearest(20.5) == 20.5


def test_rounding_touches_only_numbers_with_a_grid_and_keeps_the_order() -> None:
    grid = Capability(name="level", settable=True, grid=(0.0, 10.0))
    part = Part(id="", service_type="light", capabilities=(grid, Capability(name="on_off", settable=True)))
    assert [*device_settings({"on_off": True, "level": 44.0}, part).items()] == [("on_off", True), ("level", 40.0)]
    assert device_settings({"level": 0.0}, part) == {"on_off": False}
