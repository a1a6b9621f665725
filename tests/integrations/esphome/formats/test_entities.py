"""Entities of every component: their parts, what their states report, and their commands."""

import math
from typing import Any

import pytest

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WrongCodeError
from homebot.integrations.esphome.formats.device import EsphomeDevice
from homebot.integrations.esphome.formats.entity import EsphomeEntity

RGB_CT = {"supported_color_modes": [11, 35], "min_mireds": 154.0, "max_mireds": 370.0}
RGBWW = {"supported_color_modes": [19, 51], "min_mireds": 154.0, "max_mireds": 370.0}
THERMOSTAT = {
    "feature_flags": 1,
    "supported_modes": [0, 3],
    "visual_min_temperature": 5.0,
    "visual_max_temperature": 30.0,
}
CONDITIONER = {
    "feature_flags": 1 | 2 | 32,
    "supported_modes": [0, 1, 2, 3, 5],
    "supported_fan_modes": [2, 3],
    "supported_custom_fan_modes": ["turbo"],
    "supported_presets": [0, 5],
    "visual_min_temperature": 16.0,
    "visual_max_temperature": 30.0,
}


def entity(kind: str, **info: Any) -> EsphomeEntity:
    device = EsphomeDevice({}, [(kind, {"key": 1, "object_id": "one", **info})])
    return device.entity(f"{kind}_one")


@pytest.mark.parametrize(
    ("kind", "info", "state", "values"),
    [
        ("light", {"supported_color_modes": [1]}, {"state": True}, {"on_off": True}),
        ("light", RGB_CT, {"state": True, "brightness": 0.5, "color_mode": 11, "color_temperature": 250.0},
         {"on_off": True, "level": 50.0, "color_temperature": 4000.0, "color": None}),
        (
            "light",
            RGB_CT,
            {"state": True, "brightness": 1.0, "color_mode": 35, "color_brightness": 1.0, "red": 0.0, "green": 1.0}
            | {"blue": 0.0, "color_temperature": 250.0},
            {"on_off": True, "level": 100.0, "color_temperature": None, "color": (120.0, 100.0)},
        ),
        ("light", RGBWW, {"state": True, "brightness": 1.0, "color_mode": 19, "cold_white": 1.0, "warm_white": 0.0},
         {"on_off": True, "level": 100.0, "color_temperature": 6494.0, "color": None}),
        ("light", RGB_CT, {"state": True, "brightness": math.nan, "color_mode": 99}, {"on_off": True, "level": None}),
        ("sensor", {"device_class": "temperature", "unit_of_measurement": "°F"}, {"state": 68.0},
         {"temperature": 20.0}),
        ("sensor", {"device_class": "energy", "unit_of_measurement": "Wh"}, {"state": 1500.0}, {"energy": 1.5}),
        ("sensor", {"unit_of_measurement": "bananas"}, {"state": 0.30000001192092896}, {"measurement": 0.3}),
        ("sensor", {}, {"state": math.nan}, {"measurement": None}),
        ("sensor", {}, {"state": 0.0, "missing_state": True}, {"measurement": None}),
        ("binary_sensor", {"device_class": "motion"}, {"state": True}, {"occupancy": True}),
        ("binary_sensor", {"device_class": "new"}, {"state": False}, {"state": False}),
        ("cover", {}, {"position": 1.0, "current_operation": 0}, {"movement": "open"}),
        ("cover", {"supports_position": True, "supports_tilt": True},
         {"position": 0.3, "tilt": 0.5, "current_operation": 2},
         {"movement": "closing", "position": 30.0, "tilt": 50.0}),
        ("valve", {"supports_position": True}, {"position": 0.0}, {"valve": "closed", "position": 0.0}),
        ("lock", {}, {"state": 7}, {"lock": "open"}),
        ("lock", {}, {"state": 0}, {"lock": None}),
        ("fan", {"supports_speed": True, "supported_speed_count": 4}, {"state": True, "speed_level": 1},
         {"fan_speed": 25.0}),
        ("fan", {"supports_speed": True, "supported_speed_count": 4}, {"state": False, "speed_level": 1},
         {"fan_speed": 0.0}),
        ("climate", THERMOSTAT, {"mode": 3, "current_temperature": 19.5, "target_temperature": 21.0},
         {"thermostat_mode": "heat", "on_off": True, "local_temperature": 19.5, "heating_setpoint": 21.0}),
        (
            "climate",
            CONDITIONER,
            {"mode": 1, "target_temperature_low": 20.0, "target_temperature_high": 24.0, "action": 2, "fan_mode": 3}
            | {"preset": 5, "custom_fan_mode": "turbo"},
            {"heating_setpoint": 20.0, "cooling_setpoint": 24.0, "thermostat_action": "cooling", "fan_mode": "turbo"}
            | {"preset_mode": "eco"},
        ),
        (
            "climate",
            CONDITIONER,
            {"mode": 2, "target_temperature": 0.0, "target_temperature_low": 20.0, "target_temperature_high": 24.0}
            | {"fan_mode": 3},
            {"heating_setpoint": 20.0, "cooling_setpoint": 24.0, "thermostat_mode": "cool", "fan_mode": "low"},
        ),
        ("climate", {**THERMOSTAT, "temperature_unit": 1}, {"current_temperature": 68.0}, {"local_temperature": 20.0}),
        ("water_heater", {"supported_features": 1 | 2 | 4 | 16, "supported_modes": [0, 1]},
         {"current_temperature": 48.0, "target_temperature": 55.0, "mode": 1, "state": 2},
         {"local_temperature": 48.0, "heating_setpoint": 55.0, "water_heater_mode": "eco", "on_off": True}),
        ("media_player", {"feature_flags": 4}, {"state": 2, "volume": 0.25}, {"playback": "playing", "volume": 25.0}),
        ("media_player", {"feature_flags": 9}, {"state": 5, "muted": True}, {"playback": "stopped", "muted": True}),
        ("alarm_control_panel", {}, {"state": 9}, {"alarm": "triggered"}),
        ("event", {"event_types": ["ring"]}, {"event_type": "ring"}, {"press": "ring"}),
        ("event", {"event_types": ["ring"]}, {"event_type": "other"}, {}),
        ("select", {"options": ["a", "b"]}, {"state": "c"}, {"option": None}),
        ("text", {"max_length": 10, "mode": 1}, {"state": "secret"}, {}),
        ("text_sensor", {}, {"state": "a\x00b"}, {"value": "a b"}),
        ("date", {}, {"year": 2026, "month": 2, "day": 30}, {"text": None}),
        ("time", {}, {"hour": 7, "minute": 5, "second": 0}, {"text": "07:05:00"}),
        ("datetime", {}, {"epoch_seconds": 0}, {"text": "1970-01-01T00:00:00+00:00"}),
        ("update", {}, {"current_version": "1", "latest_version": "2"},
         {"version": "1", "latest_version": "2", "update_available": True}),
    ],
)  # fmt: skip
def test_states_are_read(kind: str, info: dict[str, Any], state: dict[str, Any], values: dict[str, PlainValue]) -> None:
    read = entity(kind, **info).read(state)
    assert {name: read.get(name) for name in values} == values
    assert values or not read


@pytest.mark.parametrize(
    ("kind", "info", "capability", "value", "fields"),
    [
        ("light", RGB_CT, "level", 0.0, {"state": False}),
        ("light", RGB_CT, "color_temperature", 4000.0, {"state": True, "color_mode": 11, "color_temperature": 250.0}),
        ("light", RGB_CT, "color", (0.0, 100.0),
         {"state": True, "color_mode": 35, "rgb": (1.0, 0.0, 0.0), "color_brightness": 1.0}),
        ("light", RGBWW, "color_temperature", 5000.0, {"state": True, "color_mode": 19, "color_temperature": 200.0}),
        ("cover", {"supports_stop": True}, "movement", "stopped", {"stop": True}),
        ("cover", {"supports_position": True}, "position", 40.0, {"position": 0.4}),
        ("lock", {"supports_open": True}, "lock", "open", {"command": 2, "code": "12"}),
        ("fan", {"supports_speed": True, "supported_speed_count": 3}, "fan_speed", 34.0,
         {"state": True, "speed_level": 2}),
        ("fan", {"supports_speed": True, "supported_speed_count": 3}, "fan_speed", 0.0, {"state": False}),
        ("climate", THERMOSTAT, "heating_setpoint", 21.0, {"target_temperature": 21.0}),
        ("climate", CONDITIONER, "heating_setpoint", 21.0, {"target_temperature_low": 21.0}),
        ("climate", {**CONDITIONER, "feature_flags": 4}, "cooling_setpoint", 25.0, {"target_temperature_high": 25.0}),
        ("climate", THERMOSTAT, "on_off", False, {"mode": 0}),
        ("climate", CONDITIONER, "fan_mode", "turbo", {"custom_fan_mode": "turbo"}),
        ("climate", CONDITIONER, "fan_mode", "low", {"fan_mode": 3}),
        ("water_heater", {"supported_features": 16}, "on_off", True, {"on": True}),
        ("media_player", {"feature_flags": 1 | 8}, "playback", "paused", {"command": 1}),
        ("media_player", {"feature_flags": 1 | 8}, "muted", False, {"command": 4}),
        ("siren", {"supports_volume": True}, "volume", 50.0, {"state": True, "volume": 0.5}),
        ("alarm_control_panel", {"supported_features": 2}, "alarm", "armed_away", {"command": 1, "code": "12"}),
        ("button", {}, "push", True, {}),
        ("time", {}, "text", "07:05", {"hour": 7, "minute": 5, "second": 0}),
        ("datetime", {}, "text", "1970-01-01T01:00:00+00:00", {"epoch_seconds": 3600}),
    ],
)  # fmt: skip
def test_commands_are_made(
    kind: str, info: dict[str, Any], capability: str, value: PlainValue, fields: dict[str, Any]
) -> None:
    made = entity(kind, **info).command(capability, value, code="12")
    assert {name: pytest.approx(one) if isinstance(one, float) else one for name, one in fields.items()} == made


@pytest.mark.parametrize(
    ("kind", "info", "capability", "value"),
    [
        ("light", {"supported_color_modes": [1]}, "level", 50.0),
        ("light", RGB_CT, "color_temperature", 9000.0),
        ("climate", THERMOSTAT, "heating_setpoint", 40.0),
        ("number", {"min_value": 0.0, "max_value": 10.0}, "number", 11.0),
        ("number", {"min_value": 0.0, "max_value": 10.0}, "number", math.nan),
        ("text", {"min_length": 2, "max_length": 3}, "text", "long"),
        ("text", {"max_length": 9, "pattern": "[0-9]+$"}, "text", "12a"),
        ("select", {"options": ["a"]}, "option", "b"),
        ("button", {}, "push", False),
        ("alarm_control_panel", {}, "alarm", "armed_away"),
        ("date", {}, "text", "tomorrow"),
        ("datetime", {}, "text", "2026-01-01T00:00:00"),
        ("update", {}, "version", "2"),
    ],
)
def test_an_impossible_command_of_an_entity_is_refused(
    kind: str, info: dict[str, Any], capability: str, value: PlainValue
) -> None:
    with pytest.raises(RefusedError):
        entity(kind, **info).command(capability, value)


def test_a_missing_code_is_refused() -> None:
    with pytest.raises(WrongCodeError, match="it needs a code"):
        entity("lock", requires_code=True).command("lock", "unlocked")
    panel = entity("alarm_control_panel", requires_code=True, supported_features=2)
    with pytest.raises(WrongCodeError):
        panel.command("alarm", "disarmed")
    assert panel.command("alarm", "armed_away") == {"command": 1}
    assert panel.part("x").capabilities[0].code == "digits"


def test_a_transition_is_for_lights_alone() -> None:
    lamp = entity("light", **RGB_CT)
    assert lamp.command("on_off", True, 1.5) == {"state": True, "transition_length": 1.5}
    assert entity("switch").command("on_off", True, 1.5) == {"state": True}
    assert (lamp.part("x").fades, entity("switch").part("x").fades) == (True, False)


def test_the_main_part_comes_first_and_ids_are_unique() -> None:
    listed = [
        ("sensor", {"key": 1, "object_id": "x", "name": "Signal", "entity_category": 2}),
        ("switch", {"key": 2, "object_id": "x", "name": "Indicator", "entity_category": 1}),
        ("light", {"key": 3, "object_id": "x", "name": "Lamp"}),
        ("sensor", {"key": 4, "object_id": "x", "name": "X", "disabled_by_default": True}),
        ("sensor", {"key": 1, "device_id": 7, "object_id": "x", "name": "Signal"}),
        ("camera", {"key": 5, "object_id": "x"}),
    ]
    info = {"name": "hall", "devices": [{"device_id": 7, "name": "Shed"}]}
    device = EsphomeDevice(info, listed)
    parts = device.parts()
    assert [(part.id, part.name, part.category) for part in parts] == [
        ("light_x", "Lamp", ""),
        ("switch_x", "Indicator", "config"),
        ("sensor_x", "Signal", "diagnostic"),
        ("sensor_x@7", "Shed Signal", ""),
    ]
    assert device.part_of("sensor", {"key": 1, "device_id": 7}) == "sensor_x@7"
    assert device.part_of("sensor", {"key": 9}) is None


@pytest.mark.parametrize(("modes", "has_switch"), [([3], False), ([3, 6], False), ([0, 3], True)])
def test_a_thermostat_that_cannot_be_off_has_no_switch(modes: list[int], *, has_switch: bool) -> None:
    part = entity("climate", supported_modes=modes).part("")
    assert ("on_off" in {one.name for one in part.capabilities}) is has_switch


def test_a_device_without_hardware_address_is_known_by_its_name() -> None:
    """Else the name is none: two devices of two protocols may be called ``kitchen``."""
    assert EsphomeDevice({"name": "kitchen"}, []).identifiers == ("id:kitchen",)
    known = EsphomeDevice({"name": "kitchen", "mac_address": "06:35:69:AB:F6:79"}, [])
    assert known.identifiers == ("mac:063569abf679",)


@pytest.mark.parametrize("kind", ["cover", "lock", "switch", "valve"])
@pytest.mark.parametrize("is_assumed", [False, True])
def test_an_assumed_state_is_an_echo(kind: str, *, is_assumed: bool) -> None:
    part = entity(kind, assumed_state=is_assumed).part("")
    assert {one.echoed for one in part.capabilities if one.settable} == {is_assumed}


@pytest.mark.parametrize(("name", "is_read"), [("Guest PIN", False), ("Wi-Fi password", False), ("Last card", True)])
def test_a_text_that_is_called_a_code_or_password_is_not_read(name: str, *, is_read: bool) -> None:
    sensors = EsphomeDevice({}, [("text_sensor", {"key": 1, "object_id": "one", "name": name})]).entities
    assert bool(sensors) is is_read
    (capability,) = entity("text", name=name, max_length=20).part("one").capabilities
    assert (capability.readable, capability.settable) == (is_read, True)


def test_the_icon_of_what_can_be_set_is_its_kind_without_a_class() -> None:
    assert entity("switch", icon="mdi:gate").part("x").tag == "mdi:gate"
    assert entity("cover", icon="mdi:gate", device_class="blind").part("x").tag == "blind"
    assert entity("sensor", icon="mdi:gate").part("x").tag == ""
