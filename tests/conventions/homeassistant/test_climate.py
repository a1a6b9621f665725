import json
from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.climate import build_climate
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

ZIGBEE_VALVE = {
    "action_template": "{% set values = {None:None,'idle':'idle','heat':'heating'} %}"
    '{{ values[value_json["running_state"]] }}',
    "action_topic": "zigbee2mqtt/valve",
    "current_temperature_template": '{{ value_json["local_temperature"] }}',
    "current_temperature_topic": "zigbee2mqtt/valve",
    "max_temp": "28",
    "min_temp": "7",
    "mode_command_topic": "zigbee2mqtt/valve/set/system_mode",
    "mode_state_template": '{{ value_json["system_mode"] }}',
    "mode_state_topic": "zigbee2mqtt/valve",
    "modes": ["off", "heat", "auto"],
    "preset_mode_command_topic": "zigbee2mqtt/valve/set/preset",
    "preset_mode_state_topic": "zigbee2mqtt/valve",
    "preset_mode_value_template": '{{ value_json["preset"] }}',
    "preset_modes": ["eco", "boost"],
    "temp_step": 0.5,
    "temperature_command_topic": "zigbee2mqtt/valve/set/occupied_heating_setpoint",
    "temperature_state_template": '{{ value_json["occupied_heating_setpoint"] }}',
    "temperature_state_topic": "zigbee2mqtt/valve",
    "temperature_unit": "C",
    "unique_id": "0x1_climate_zigbee2mqtt",
}
CONDITIONER = {
    "mode_command_topic": "ac/mode/set",
    "mode_state_topic": "ac/mode",
    "modes": ["off", "cool", "heat", "fan_only", "dry", "heat_cool"],
    "temperature_command_topic": "ac/t/set",
    "temperature_state_topic": "ac/t",
    "min_temp": 16,
    "max_temp": 30,
    "fan_mode_command_topic": "ac/fan/set",
    "fan_mode_state_topic": "ac/fan",
    "swing_mode_command_topic": "ac/swing/set",
    "swing_mode_state_topic": "ac/swing",
    "swing_modes": ["off", "vertical"],
}
AMERICAN = {
    "value_template": "{{ value_json.v }}",
    "modes": ["off", "heat", "cool"],
    "power_command_topic": "us/power",
    "payload_on": "1",
    "payload_off": "0",
    "temperature_unit": "F",
    "temperature_low_command_topic": "us/low/set",
    "temperature_low_command_template": '{"low": {{ value }}}',
    "temperature_low_state_topic": "us/low",
    "temperature_high_command_topic": "us/high/set",
    "temperature_high_state_topic": "us/high",
    "current_temperature_topic": "us/now",
    "current_humidity_topic": "us/hum",
    "target_humidity_command_topic": "us/hum/set",
    "target_humidity_state_topic": "us/hum/target",
    "min_temp": 45,
    "max_temp": 95,
    "qos": 1,
}


def climate(fields: Mapping[str, object]) -> DescribedPart:
    return build_climate(DiscoveryConfig("climate", "node_1", fields))


def told(fields: Mapping[str, object], capability: str, value: PlainValue) -> list[tuple[str, bytes]]:
    return [(one.topic, one.payload) for one in climate(fields).codec.write(capability, value)]


@pytest.mark.parametrize(
    ("fields", "service_type"),
    [
        (ZIGBEE_VALVE, "thermostat"),
        (AMERICAN, "thermostat"),
        (CONDITIONER, "room_air_conditioner"),
        ({"modes": ["off", "fan_only"]}, "thermostat"),
        ({"modes": ["cool", "dry"]}, "room_air_conditioner"),
        ({"mode_command_topic": "ac/mode/set"}, "room_air_conditioner"),
        ({"temperature_command_topic": "valve/t/set"}, "thermostat"),
    ],
)
def test_its_modes_say_whether_it_is_an_air_conditioner(fields: Mapping[str, object], service_type: str) -> None:
    assert climate(fields).part.service_type == service_type


def test_one_message_tells_all_that_a_radiator_valve_knows() -> None:
    said = {
        "local_temperature": 19.5,
        "occupied_heating_setpoint": 21,
        "preset": "eco",
        "running_state": "heat",
        "system_mode": "auto",
    }
    assert climate(ZIGBEE_VALVE).codec.read("zigbee2mqtt/valve", json.dumps(said).encode(), retained=False) == {
        "local_temperature": 19.5,
        "heating_setpoint": 21.0,
        "preset_mode": "eco",
        "thermostat_action": "heating",
        "thermostat_mode": "auto",
        "on_off": True,
    }


@pytest.mark.parametrize(
    ("topic", "said", "expected"),
    [
        ("ac/mode", "off", {"thermostat_mode": "off", "on_off": False}),
        ("ac/mode", "None", {"thermostat_mode": None, "on_off": None}),
        ("ac/mode", "auto", {}),
        ("ac/mode", "", {}),
        ("ac/t", "24", {"heating_setpoint": 24.0, "cooling_setpoint": 24.0}),
        ("ac/t", "None", {"heating_setpoint": None, "cooling_setpoint": None}),
        ("ac/t", "nan", {"heating_setpoint": None, "cooling_setpoint": None}),
        ("ac/t", "", {}),
        ("ac/fan", "medium", {"fan_mode": "medium"}),
        ("ac/swing", "sideways", {}),
    ],
)
def test_a_topic_of_an_air_conditioner_tells_one_thing(
    topic: str, said: str, expected: Mapping[str, PlainValue]
) -> None:
    assert climate(CONDITIONER).codec.read(topic, said.encode(), retained=False) == expected


@pytest.mark.parametrize(
    ("topic", "capability", "value"),
    [
        ("us/low", "heating_setpoint", 20.0),
        ("us/high", "cooling_setpoint", 20.0),
        ("us/now", "local_temperature", 20.0),
        ("us/hum", "humidity", 68.0),
        ("us/hum/target", "humidity_setpoint", 68.0),
    ],
)
def test_one_template_stands_for_all_and_fahrenheit_becomes_celsius(topic: str, capability: str, value: float) -> None:
    assert climate(AMERICAN).codec.read(topic, b'{"v": 68}', retained=False) == {capability: pytest.approx(value)}


@pytest.mark.parametrize(
    ("fields", "capability", "value", "expected"),
    [
        (ZIGBEE_VALVE, "heating_setpoint", 21.5, [("zigbee2mqtt/valve/set/occupied_heating_setpoint", b"21.5")]),
        (ZIGBEE_VALVE, "heating_setpoint", 21, [("zigbee2mqtt/valve/set/occupied_heating_setpoint", b"21.0")]),
        (ZIGBEE_VALVE, "thermostat_mode", "auto", [("zigbee2mqtt/valve/set/system_mode", b"auto")]),
        (ZIGBEE_VALVE, "preset_mode", "none", [("zigbee2mqtt/valve/set/preset", b"none")]),
        (ZIGBEE_VALVE, "on_off", True, [("zigbee2mqtt/valve/set/system_mode", b"heat")]),
        (ZIGBEE_VALVE, "on_off", False, [("zigbee2mqtt/valve/set/system_mode", b"off")]),
        (CONDITIONER, "on_off", True, [("ac/mode/set", b"heat_cool")]),
        ({**CONDITIONER, "modes": ["off", "dry"]}, "on_off", True, [("ac/mode/set", b"dry")]),
        (CONDITIONER, "cooling_setpoint", 24.0, [("ac/t/set", b"24.0")]),
        (CONDITIONER, "fan_mode", "high", [("ac/fan/set", b"high")]),
        (CONDITIONER, "swing_mode", "vertical", [("ac/swing/set", b"vertical")]),
        (AMERICAN, "on_off", True, [("us/power", b"1")]),
        (AMERICAN, "heating_setpoint", 20.0, [("us/low/set", b'{"low": 68.0}')]),
        (AMERICAN, "cooling_setpoint", 25.0, [("us/high/set", b"77.0")]),
        (AMERICAN, "humidity_setpoint", 45.0, [("us/hum/set", b"45")]),
    ],
)
def test_it_is_told_as_home_assistant_does(
    fields: Mapping[str, object], capability: str, value: PlainValue, expected: list[tuple[str, bytes]]
) -> None:
    assert told(fields, capability, value) == expected


def test_a_command_has_the_quality_of_service_of_the_config() -> None:
    assert climate(AMERICAN).codec.write("on_off", False) == (Publication("us/power", b"0", qos=1),)


@pytest.mark.parametrize(
    ("fields", "capability", "value", "why"),
    [
        (ZIGBEE_VALVE, "heating_setpoint", 30.0, "7 to 28"),
        (ZIGBEE_VALVE, "heating_setpoint", True, "number"),
        (ZIGBEE_VALVE, "heating_setpoint", None, "number"),
        (ZIGBEE_VALVE, "cooling_setpoint", 20.0, "takes"),
        (ZIGBEE_VALVE, "thermostat_mode", "cool", "off, heat, auto"),
        (ZIGBEE_VALVE, "local_temperature", 20.0, "takes"),
        ({**ZIGBEE_VALVE, "modes": ["heat", "auto"]}, "on_off", False, "none of its modes"),
        ({"mode_state_topic": "m"}, "on_off", True, "takes"),
        (AMERICAN, "heating_setpoint", 36.0, "7.2"),
    ],
)
def test_what_it_cannot_do_is_refused_with_the_reason(
    fields: Mapping[str, object], capability: str, value: PlainValue, why: str
) -> None:
    with pytest.raises(RefusedError, match=why):
        told(fields, capability, value)


def test_bounds_are_told_in_celsius() -> None:
    """Rounded outwards, because 45 °F are 7.22 °C, which nobody asks for."""
    bounds = {one.name: one.bounds for one in climate(AMERICAN).part.capabilities}
    assert bounds["heating_setpoint"] == (7.2, 35.0)


@pytest.mark.parametrize(
    "fields",
    [
        {"temperature_unit": "K"},
        {"preset_modes": ["none"], "preset_mode_command_topic": "p"},
        {"target_humidity_state_topic": "h"},
        {"min_humidity": 60, "max_humidity": 50},
        {"max_humidity": 101},
        {"min_temp": "cold", "temperature_command_topic": "t"},
        {"mode_command_topic": "m/#"},
    ],
)
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        climate(fields)


def test_one_without_modes_only_heats() -> None:
    part = climate({**CONDITIONER, "modes": [], "fan_modes": []}).part
    assert (part.service_type, [one.name for one in part.capabilities]) == (
        "thermostat",
        ["heating_setpoint", "swing_mode"],
    )


BOTH = {
    "modes": ["off", "heat", "cool", "heat_cool"],
    "mode_command_topic": "b/mode/set",
    "mode_state_topic": "b/mode",
    "temperature_command_topic": "b/t/set",
    "temperature_state_topic": "b/t",
    "temperature_low_command_topic": "b/low/set",
    "temperature_low_state_topic": "b/low",
    "temperature_high_command_topic": "b/high/set",
    "temperature_high_state_topic": "b/high",
}


@pytest.mark.parametrize(
    ("modes", "expected"),
    [
        (["heat"], "b/t/set"),
        (["heat_cool"], "b/low/set"),
        (["heat_cool", "off"], "b/t/set"),
        (["heat_cool", "no mode"], "b/low/set"),
    ],
)
def test_of_a_single_target_and_a_pair_the_mode_says_which_is_told(modes: list[str], expected: str) -> None:
    codec = climate(BOTH).codec
    for mode in modes:
        codec.read("b/mode", mode.encode(), retained=False)
    assert [(one.topic, one.payload) for one in codec.write("heating_setpoint", 21.0)] == [(expected, b"21.0")]
    high = expected.replace("low", "high")
    assert [(one.topic, one.payload) for one in codec.write("cooling_setpoint", 25.0)] == [(high, b"25.0")]


@pytest.mark.parametrize("modes", [[], ["heat_cool", "None"]])
@pytest.mark.parametrize("name", ["heating_setpoint", "cooling_setpoint"])
def test_of_a_single_target_and_a_pair_none_is_told_while_the_mode_is_unknown(modes: list[str], name: str) -> None:
    """The single target may be what it heats to, whoever wants it to cool to that."""
    codec = climate(BOTH).codec
    for mode in modes:
        codec.read("b/mode", mode.encode(), retained=False)
    with pytest.raises(RefusedError, match="its mode is unknown"):
        codec.write(name, 25.0)


def test_without_modes_the_pair_counts() -> None:
    codec = climate({key: value for key, value in BOTH.items() if not key.startswith("mode")}).codec
    assert [one.topic for one in codec.write("cooling_setpoint", 25.0)] == ["b/high/set"]


def test_a_mode_that_is_not_said_is_the_one_that_it_was_told() -> None:
    codec = climate({key: value for key, value in BOTH.items() if key != "mode_state_topic"}).codec
    codec.write("thermostat_mode", "heat")
    assert [one.topic for one in codec.write("heating_setpoint", 21.0)] == ["b/t/set"]
    codec.write("thermostat_mode", "heat_cool")
    assert [one.topic for one in codec.write("heating_setpoint", 21.0)] == ["b/low/set"]
    codec.write("on_off", False)
    assert [one.topic for one in codec.write("heating_setpoint", 21.0)] == ["b/t/set"]


def test_a_mode_that_it_says_counts_and_not_the_one_that_it_was_told() -> None:
    codec = climate(BOTH).codec
    codec.read("b/mode", b"heat", retained=False)
    codec.write("thermostat_mode", "heat_cool")
    assert [one.topic for one in codec.write("heating_setpoint", 21.0)] == ["b/t/set"]


def test_the_targets_that_count_are_those_of_the_mode() -> None:
    codec = climate(BOTH).codec

    def said(topic: str, payload: str) -> dict[str, PlainValue]:
        return dict(codec.read(topic, payload.encode(), retained=False))

    assert said("b/t", "20") == {"heating_setpoint": 20.0, "cooling_setpoint": 20.0}
    assert said("b/low", "18") == {}
    assert said("b/mode", "heat_cool") == {
        "thermostat_mode": "heat_cool",
        "on_off": True,
        "heating_setpoint": 18.0,
        "cooling_setpoint": None,
    }
    assert said("b/high", "26") == {"cooling_setpoint": 26.0}
    assert said("b/t", "21") == {}
    assert said("b/mode", "cool") == {
        "thermostat_mode": "cool",
        "on_off": True,
        "heating_setpoint": 21.0,
        "cooling_setpoint": 21.0,
    }


def test_one_message_tells_the_mode_and_its_targets() -> None:
    topics = {key: "all" if key.endswith("state_topic") else value for key, value in BOTH.items()}
    templates = {
        f"{name}_template": f"{{{{ value_json.{key} }}}}"
        for name, key in (
            ("mode_state", "mode"),
            ("temperature_state", "t"),
            ("temperature_low_state", "low"),
            ("temperature_high_state", "high"),
        )
    }
    codec = climate({**topics, **templates}).codec
    message = {"mode": "heat_cool", "t": 20, "low": 18, "high": 26}
    assert codec.read("all", json.dumps(message).encode(), retained=False) == {
        "thermostat_mode": "heat_cool",
        "on_off": True,
        "heating_setpoint": 18.0,
        "cooling_setpoint": 26.0,
    }


def test_a_valve_without_a_mode_has_none_and_only_heats() -> None:
    """As Zigbee2MQTT announces a Saswell SEA801, which Home Assistant shows with all modes that it knows."""
    part = climate({"temperature_command_topic": "valve/t/set", "temperature_state_topic": "valve/t"}).part
    assert [one.name for one in part.capabilities] == ["heating_setpoint"]
