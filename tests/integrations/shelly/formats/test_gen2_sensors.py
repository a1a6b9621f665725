import json
from typing import Any

import pytest
from tests.integrations.announced_parts import Say, device_in, heard, part_in, told

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced
from homebot.errors import RefusedError


def introduce(say: Say, key: str, status: object, config: object) -> tuple[AnnouncementEvent, ...]:
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"device": {}}, key: config}})
    return say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"mac": "A8"}, key: status}})


def of_service(role: str, **config: object) -> dict[str, object]:
    return {"owner": "service:0", "role": role, "access": "crw", **config}


ZONE, POSITION, STATE = of_service("zone0", name="Lawn"), of_service("position", min=0, max=100), of_service("state")
BAR, CUBIC = {"expr": "x*0.16", "unit": "bar"}, {"expr": "x/1000", "unit": "m³"}
LABEL = {"access": "*", "owner": "", "meta": {"ui": {"view": "label"}}}
COOLING = {"type": "cooling"}
COOLED = {"enable": True, "target_C": 24, "current_C": 26.5, "output": True}
PHASES = {"a_act_power": 200, "a_voltage": 230, "b_act_power": 100, "c_act_power": 50, "total_act_power": 350}


@pytest.mark.parametrize(
    ("config", "part_id", "service_type", "status", "expected"),
    [
        ({}, "smoke:0", "smoke_co_alarm", {"alarm": True}, {"smoke": True}),
        ({}, "flood:0", "water_leak_detector", {"alarm": False}, {"water_leak": False}),
        ({}, "flood:0", "water_leak_detector", {"alarm": None}, {"water_leak": None}),
        ({}, "humidity:0", "humidity_sensor", {"rh": 45.5}, {"humidity": 45.5}),
        ({}, "illuminance:0", "light_sensor", {"lux": 100}, {"illuminance": 100.0}),
        ({}, "voltmeter:100", "electrical_meter", {"voltage": 12.1}, {"voltage": 12.1}),
        ({}, "presencezone:200", "occupancy_sensor", {"state": True}, {"occupancy": True}),
        ({}, "presencezone:200", "occupancy_sensor", {"value": True}, {"occupancy": True}),
        ({}, "illuminance:0", "x_sensor", {"illumination": "dark"}, {"value": "dark"}),
        ({}, "temperature:0", "temperature_sensor", {"tC": -275.1, "errors": ["x"]}, {"temperature": None}),
        ({}, "humidity:0", "humidity_sensor", {"rh": -2, "errors": ["x"]}, {"humidity": None}),
        ({}, "cb:0", "x_binary_sensor", {"output": True}, {"power_detected": True}),
        (of_service("current_temperature"), "number:200", "temperature_sensor", {"value": 21}, {"temperature": 21.0}),
        (of_service("average_temperature"), "number:200", "temperature_sensor", {"value": 17.5}, {"temperature": 17.5}),
        (of_service("target_temperature", min=5, max=35), "number:201", "thermostat", {"value": 20.5},
         {"heating_setpoint": 20.5}),
        ({}, "devicepower:0", "x_battery", {"external": {"present": True}}, {"plugged_in": True}),
        ({}, "devicepower:0", "x_battery", {"battery": {"percent": 57}, "external": {"present": True}},
         {"battery": 57.0, "plugged_in": True}),
        ({}, "devicepower:0", "x_battery", {"battery": {"V": 5.41, "percent": 57}}, {"battery": 57.0, "voltage": 5.41}),
        ({"type": "switch"}, "input:0", "x_binary_sensor", {"state": True}, {"state": True}),
        ({"type": "analog"}, "input:0", "x_sensor", {"percent": 12}, {"measurement": 12.0}),
        ({"type": "count"}, "input:0", "x_sensor", {"counts": {"total": 5}}, {"measurement": 5.0}),
        ({}, "em1:0", "electrical_meter", {"act_power": 200, "freq": 50}, {"power": 200.0, "frequency": 50.0}),
        ({}, "em:0", "electrical_meter", PHASES, {"power": 350.0}),
        ({}, "em:0/a", "electrical_meter", PHASES, {"power": 200.0, "voltage": 230.0}),
        ({}, "pm1:0", "electrical_meter", {"apower": 42}, {"power": 42.0}),
        ({}, "pm1:0", "electrical_meter",
         {"apower": -42, "aenergy": {"total": 1500}, "ret_aenergy": {"total": 250.5}},
         {"power": -42.0, "energy": 1.5, "energy_returned": 0.2505}),
        ({}, "switch:0/meter", "electrical_meter", {"apower": 1, "ret_aenergy": {"total": 1000}},
         {"power": 1.0, "energy_returned": 1.0}),
        ({}, "presencezone:200/num_objects", "x_sensor", {"value": True, "num_objects": 2}, {"measurement": 2.0}),
        ({"type": "analog", "xpercent": BAR}, "input:100/xpercent", "x_sensor", {"percent": 25.0, "xpercent": 4.0},
         {"measurement": 4.0}),
        ({"type": "count", "xcounts": CUBIC}, "input:2/counts.xtotal", "x_sensor",
         {"counts": {"total": 56, "xtotal": 0.056}, "freq": 0.5}, {"measurement": 0.056}),
        ({"type": "count"}, "input:2/freq", "x_sensor", {"counts": {"total": 56}, "freq": 0.5}, {"measurement": 0.5}),
        ({"xvoltage": {"unit": "pH"}}, "voltmeter:100/xvoltage", "x_sensor", {"xvoltage": 7.1}, {"measurement": 7.1}),
        ({"access": "cr"}, "number:200", "x_sensor", {"value": 3}, {"measurement": 3.0}),
        ({"access": "cr"}, "boolean:200", "x_binary_sensor", {"value": True}, {"state": True}),
        ({"access": "*"}, "boolean:200", "x_setting", {"value": True}, {"state": True}),
        (LABEL, "number:200", "x_sensor", {"value": 3}, {"measurement": 3.0}),
        ({}, "switch:0/temperature", "temperature_sensor", {"temperature": {"tC": 40.1}}, {"temperature": 40.1}),
        ({}, "rgb:0", "light", {"output": True, "brightness": 75, "rgb": [255, 128, 0]},
         {"on_off": True, "level": 75.0, "color": (30.118, 100.0)}),
        (COOLING, "thermostat:0", "thermostat", COOLED,
         {"cooling_setpoint": 24.0, "local_temperature": 26.5, "thermostat_mode": "cool",
          "thermostat_action": "cooling"}),
        (ZONE, "boolean:200", "water_valve", {"value": True}, {"valve": "open"}),
        (POSITION, "number:200", "water_valve", {"value": 40}, {"position": 40.0, "valve": "open"}),
        (POSITION, "number:200", "water_valve", {"value": 0}, {"position": 0.0, "valve": "closed"}),
        (STATE, "boolean:200", "switch", {"value": True}, {"on_off": True}),
        (of_service("start_charging"), "boolean:200", "switch", {"value": True}, {"on_off": True}),
    ],
)  # fmt: skip
def test_a_component_reports(
    say: Say, config: object, part_id: str, service_type: str, status: object, expected: object
) -> None:
    key = part_id.partition("/")[0]
    found = part_in(introduce(say, key, status, config), part_id)
    assert found.part.service_type == service_type
    assert heard(found, f"x/status/{key}", status) == expected
    assert heard(found, "x/events/rpc", {"method": "NotifyStatus", "params": {key: status}}) == expected


def test_the_mode_of_a_lamp_rules_what_has_a_value(say: Say) -> None:
    lamp = part_in(introduce(say, "rgbcct:0", {"mode": "cct"}, {}), "rgbcct:0")
    said = {"mode": "rgb", "rgb": [255, 0, 0]}
    assert heard(lamp, "x/status/rgbcct:0", said) == {"color": (0.0, 100.0), "color_temperature": None}
    assert heard(lamp, "x/status/rgbcct:0", {"mode": "cct", "ct": 2700}) == {"color": None, "color_temperature": 2700.0}


BOUNDS = {"min": 0, "max": 10}


@pytest.mark.parametrize(
    ("key", "config", "order", "method", "params"),
    [
        ("cover:0", {}, ("movement", "open"), "Cover.Open", {}),
        ("cover:0", {}, ("movement", "closed"), "Cover.Close", {}),
        ("cover:0", {}, ("movement", "stopped"), "Cover.Stop", {}),
        ("cover:0", {}, ("position", 30.4), "Cover.GoToPosition", {"pos": 30}),
        ("cover:0", {"slat": {"enable": True}}, ("tilt", 50.0), "Cover.GoToPosition", {"slat_pos": 50}),
        ("light:0", {}, ("on_off", False), "Light.Set", {"on": False}),
        ("light:0", {}, ("level", 40.0), "Light.Set", {"on": True, "brightness": 40}),
        ("light:0", {}, ("level", 0.0), "Light.Set", {"on": False}),
        ("light:1", {}, ("level", 40.0, 3.0), "Light.Set", {"on": True, "brightness": 40, "transition_duration": 3.0}),
        ("cct:0", {}, ("color_temperature", 4000.0), "CCT.Set", {"on": True, "ct": 4000}),
        ("rgb:0", {}, ("color", (240.0, 100.0)), "RGB.Set", {"on": True, "rgb": [0, 0, 255]}),
        ("rgbw:0", {}, ("color", (0.0, 0.0)), "RGBW.Set", {"on": True, "rgb": [255, 255, 255], "white": 0}),
        ("rgbcct:0", {}, ("color_temperature", 3000.0), "RGBCCT.Set", {"on": True, "mode": "cct", "ct": 3000}),
        ("thermostat:0", {}, ("heating_setpoint", 21.5), "Thermostat.SetConfig", {"config": {"target_C": 21.5}}),
        ("thermostat:0", {}, ("thermostat_mode", "off"), "Thermostat.SetConfig", {"config": {"enable": False}}),
        ("thermostat:0", COOLING, ("cooling_setpoint", 23.0), "Thermostat.SetConfig", {"config": {"target_C": 23.0}}),
        ("thermostat:0", COOLING, ("thermostat_mode", "cool"), "Thermostat.SetConfig", {"config": {"enable": True}}),
        ("number:200", BOUNDS, ("number", 7.0), "Number.Set", {"value": 7}),
        ("boolean:200", ZONE, ("valve", "open"), "Boolean.Set", {"value": True}),
        ("number:200", POSITION, ("valve", "open"), "Number.Set", {"value": 100}),
        ("number:200", POSITION, ("valve", "closed"), "Number.Set", {"value": 0}),
        ("number:200", POSITION, ("position", 40.0), "Number.Set", {"value": 40}),
        ("boolean:200", STATE, ("on_off", False), "Boolean.Set", {"value": False}),
    ],
)
def test_a_component_is_called(
    say: Say, key: str, config: object, order: tuple[Any, ...], method: str, params: dict[str, object]
) -> None:
    ((topic, payload),) = told(part_in(introduce(say, key, {"output": False}, config), key), *order)
    call = json.loads(payload)
    assert (topic, call["method"], call["params"]) == ("x/rpc", method, {"id": int(key.partition(":")[2]), **params})


@pytest.mark.parametrize(
    ("key", "config", "order", "reason"),
    [
        ("number:200", BOUNDS, ("number", 11.0), "0 to 10"),
        ("thermostat:0", COOLING, ("thermostat_mode", "heat"), "off, cool"),
    ],
)
def test_a_command_out_of_bounds_is_refused(
    say: Say, key: str, config: object, order: tuple[str, Any], reason: str
) -> None:
    with pytest.raises(RefusedError, match=reason):
        told(part_in(introduce(say, key, {}, config), key), *order)


@pytest.mark.parametrize(
    ("key", "config", "category", "name"),
    [
        ("number:200", BOUNDS, "config", ""),
        ("boolean:200", ZONE, "", "Lawn"),
        ("number:200", POSITION, "", ""),
        ("boolean:200", STATE, "", ""),
    ],
)
def test_values_of_users_are_settings_and_those_of_makers_are_none(
    say: Say, key: str, config: object, category: str, name: str
) -> None:
    part = part_in(introduce(say, key, {"value": None}, config), key).part
    assert (part.category, part.name) == (category, name)


def test_a_value_by_a_formula_of_the_owner_has_its_unit(say: Say) -> None:
    config = {"type": "analog", "xpercent": {"expr": "x*0.16", "unit": "bar"}}
    found = introduce(say, "input:100", {"percent": 25.0, "xpercent": 4.0}, config)
    assert part_in(found, "input:100/xpercent").part.capabilities[0].unit == "bar"
    assert part_in(found, "input:100").part.capabilities[0].unit == "%"


@pytest.mark.parametrize(
    ("key", "config"),
    [("input:0", {"enable": False}), ("bthomesensor:200", {"obj_id": 9999}), ("ble:0", {}), ("switch:", {})],
)
def test_disabled_and_unknown_inputs_are_no_parts(say: Say, key: str, config: object) -> None:
    assert introduce(say, key, {"state": True, "value": 1}, config) == ()


@pytest.mark.parametrize(("has_relay", "expected"), [(True, ["thermostat"]), (False, ["thermostat", "switch"])])
def test_the_relay_of_a_thermostat_is_no_switch(say: Say, has_relay: bool, expected: list[str]) -> None:  # noqa: FBT001
    """A Wall Display says whether its own relay is the one that its thermostat switches."""
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    status = {
        "sys": {"mac": "A8", "relay_in_thermostat": has_relay},
        "thermostat:0": COOLED,
        "switch:0": {"output": True},
    }
    device = device_in(say("homebot/rpc", {"id": 1, "src": "x", "result": status}))
    assert [one.part.service_type for one in device.parts] == expected


@pytest.mark.parametrize(
    ("components", "key", "category"),
    [
        ({"em:0": {"total_act_power": 1}}, "temperature:0", "diagnostic"),
        ({"em1:0": {"act_power": 1}}, "temperature:0", "diagnostic"),
        ({"em:0": {"total_act_power": 1}}, "temperature:100", ""),
        ({"switch:0": {"output": True}}, "temperature:0", ""),
    ],
)
def test_the_warmth_of_an_energy_meter_is_not_that_of_the_room(
    say: Say, components: dict[str, object], key: str, category: str
) -> None:
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    status = {"sys": {"mac": "A8"}, **components, key: {"tC": 50.2}}
    thermometer = part_in(say("homebot/rpc", {"id": 1, "src": "x", "result": status}), key).part
    assert (thermometer.service_type, thermometer.category) == ("temperature_sensor", category)


def test_a_device_with_the_module_of_shelly_has_the_name_of_its_product(say: Say) -> None:
    info = {"id": "x", "mac": "A8032ABE54DC", "model": "S3XT-0S", "app": "XT1", "jwt": {"n": "NEO Water Valve"}}
    say("homebot/rpc", {"id": 1, "src": "x", "result": info})
    events = say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"mac": "A8"}, "switch:0": {"output": True}}})
    (device,) = [one for one in events if isinstance(one, DeviceAnnounced)]
    assert (device.facts["model"], device.facts["model_id"]) == ("NEO Water Valve", "XT1")


@pytest.mark.parametrize(("access", "capability"), [("crw", "number"), ("cr", "measurement")])
def test_a_number_of_the_user_has_the_unit_that_the_device_shows(say: Say, access: str, capability: str) -> None:
    config = {"id": 200, "access": access, "meta": {"ui": {"view": "slider", "unit": "W", "step": 1}}}
    (found,) = part_in(introduce(say, "number:200", {"value": 5}, config), "number:200").part.capabilities
    assert (found.name, found.unit) == (capability, "W")


def test_a_boolean_of_the_user_is_no_zone_in_any_role(say: Say) -> None:
    mine = part_in(introduce(say, "boolean:200", {"value": False}, {"name": "zone0", "role": "zone0"}), "boolean:200")
    assert mine.part.service_type == "x_setting"


@pytest.mark.parametrize(
    ("part_id", "topic", "status", "expected"),
    [
        ("em:0", "emdata:0", {"total_act": 2000, "total_act_ret": 500}, {"energy": 2.0, "energy_returned": 0.5}),
        ("em:0/a", "emdata:0", {"a_total_act_ret_energy": 500}, {"energy_returned": 0.5}),
        ("em:0/a", "emdata:0", {"a_total_act_energy": 1500}, {"energy": 1.5}),
        ("em1:1", "em1data:1", {"total_act_ret_energy": 500}, {"energy_returned": 0.5}),
    ],
)
def test_a_meter_counts_both_ways(say: Say, part_id: str, topic: str, status: object, expected: object) -> None:
    meter = part_in(introduce(say, part_id.partition("/")[0], {"a_act_power": 1, "act_power": 1}, {}), part_id)
    assert heard(meter, f"x/status/{topic}", status) == expected


@pytest.mark.parametrize(("key", "expected"), [("temperature:100", None), ("temperature:0", 85.0)])
def test_85_degrees_of_a_probe_of_the_add_on_are_no_reading(say: Say, key: str, expected: float | None) -> None:
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    status = {"sys": {"mac": "A8"}, "switch:0": {"output": True}, key: {"tC": 21.5}}
    codec = part_in(say("homebot/rpc", {"id": 1, "src": "x", "result": status}), key).codec
    read = [
        codec.read(f"x/status/{key}", b'{"tC": %s}' % of, retained=False).get("temperature") for of in (b"85", b"85.2")
    ]
    assert read == [expected, 85.2]
