import json
from collections.abc import Callable

import pytest
from tests.conventions.announced_parts import part_in

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced

Say = Callable[..., tuple[AnnouncementEvent, ...]]


def introduce(say: Say, key: str, status: object, config: object) -> tuple[AnnouncementEvent, ...]:
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"device": {}}, key: config}})
    return say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"mac": "A8"}, key: status}})


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
        ({}, "devicepower:0", "x_battery", {"external": {"present": True}}, {"plugged_in": True}),
        ({}, "cb:0", "x_binary_sensor", {"output": True}, {"power_detected": True}),
        (
            {"owner": "service:0", "role": "current_temperature", "access": "crw"},
            "number:200",
            "temperature_sensor",
            {"value": 21},
            {"temperature": 21.0},
        ),
        (
            {"owner": "service:0", "role": "target_temperature", "access": "crw", "min": 5, "max": 35},
            "number:201",
            "thermostat",
            {"value": 20.5},
            {"heating_setpoint": 20.5},
        ),
        (
            {},
            "devicepower:0",
            "x_battery",
            {"battery": {"percent": 57}, "external": {"present": True}},
            {"battery": 57.0, "plugged_in": True},
        ),
        ({}, "devicepower:0", "x_battery", {"battery": {"V": 5.41, "percent": 57}}, {"battery": 57.0, "voltage": 5.41}),
        ({"type": "switch"}, "input:0", "x_binary_sensor", {"state": True}, {"state": True}),
        ({"type": "analog"}, "input:0", "x_sensor", {"percent": 12}, {"measurement": 12.0}),
        ({"type": "count"}, "input:0", "x_sensor", {"counts": {"total": 5}}, {"measurement": 5.0}),
        ({}, "em1:0", "electrical_meter", {"act_power": 200, "freq": 50}, {"power": 200.0, "frequency": 50.0}),
        ({}, "pm1:0", "electrical_meter", {"apower": 42}, {"power": 42.0}),
        (
            {},
            "pm1:0",
            "electrical_meter",
            {"apower": -42, "aenergy": {"total": 1500}, "ret_aenergy": {"total": 250.5}},
            {"power": -42.0, "energy": 1.5, "energy_returned": 0.2505},
        ),
        (
            {},
            "switch:0/meter",
            "electrical_meter",
            {"apower": 1, "ret_aenergy": {"total": 1000}},
            {"power": 1.0, "energy_returned": 1.0},
        ),
        (
            {"owner": "service:0", "role": "average_temperature"},
            "number:200",
            "temperature_sensor",
            {"value": 17.5},
            {"temperature": 17.5},
        ),
        ({}, "presencezone:200/num_objects", "x_sensor", {"value": True, "num_objects": 2}, {"measurement": 2.0}),
        (
            {"type": "analog", "xpercent": {"expr": "x*0.16", "unit": "bar"}},
            "input:100/xpercent",
            "x_sensor",
            {"percent": 25.0, "xpercent": 4.0},
            {"measurement": 4.0},
        ),
        (
            {"type": "count", "xcounts": {"expr": "x/1000", "unit": "m³"}},
            "input:2/counts.xtotal",
            "x_sensor",
            {"counts": {"total": 56, "xtotal": 0.056}, "freq": 0.5},
            {"measurement": 0.056},
        ),
        ({"type": "count"}, "input:2/freq", "x_sensor", {"counts": {"total": 56}, "freq": 0.5}, {"measurement": 0.5}),
        ({"xvoltage": {"unit": "pH"}}, "voltmeter:100/xvoltage", "x_sensor", {"xvoltage": 7.1}, {"measurement": 7.1}),
        ({"access": "cr"}, "number:200", "x_sensor", {"value": 3}, {"measurement": 3.0}),
        ({"access": "cr"}, "boolean:200", "x_binary_sensor", {"value": True}, {"state": True}),
        ({}, "switch:0/temperature", "temperature_sensor", {"temperature": {"tC": 40.1}}, {"temperature": 40.1}),
    ],
)
def test_a_component_reports(
    say: Say, config: object, part_id: str, service_type: str, status: object, expected: object
) -> None:
    key = part_id.partition("/")[0]
    found = part_in(introduce(say, key, status, config), part_id)
    assert found.part.service_type == service_type
    assert found.codec.read(f"x/status/{key}", json.dumps(status).encode(), retained=False) == expected
    news = json.dumps({"method": "NotifyStatus", "params": {key: status}}).encode()
    assert found.codec.read("x/events/rpc", news, retained=False) == expected


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


def test_a_zone_of_an_irrigation_controller_is_a_valve(say: Say) -> None:
    config = {"id": 200, "name": "Lawn", "owner": "service:0", "role": "zone0", "access": "crw"}
    zone = part_in(introduce(say, "boolean:200", {"value": False}, config), "boolean:200")
    assert (zone.part.service_type, zone.part.name, zone.part.category) == ("water_valve", "Lawn", "")
    assert zone.codec.read("x/status/boolean:200", b'{"value":true}', retained=False) == {"valve": "open"}
    (told,) = zone.codec.write("valve", "open")
    call = json.loads(told.payload)
    assert (told.topic, call["method"], call["params"]) == ("x/rpc", "Boolean.Set", {"id": 200, "value": True})


def test_a_water_valve_of_a_maker_is_a_valve(say: Say) -> None:
    config = {"id": 200, "owner": "service:0", "role": "position", "access": "crw", "min": 0, "max": 100}
    valve = part_in(introduce(say, "number:200", {"value": 0}, config), "number:200")
    assert (valve.part.service_type, valve.part.category) == ("water_valve", "")
    read = [valve.codec.read("x/status/number:200", text, retained=False) for text in (b'{"value":40}', b'{"value":0}')]
    assert read == [{"position": 40.0, "valve": "open"}, {"position": 0.0, "valve": "closed"}]
    told = [valve.codec.write(*one)[0] for one in (("valve", "open"), ("valve", "closed"), ("position", 40.0))]
    calls = [json.loads(one.payload) for one in told]
    assert [(one["method"], one["params"]) for one in calls] == [
        ("Number.Set", {"id": 200, "value": percent}) for percent in (100, 0, 40)
    ]


def test_the_state_of_a_makers_device_is_a_switch(say: Say) -> None:
    config = {"id": 200, "name": "Power", "owner": "service:0", "role": "state", "access": "crw"}
    switch = part_in(introduce(say, "boolean:200", {"value": True}, config), "boolean:200")
    assert (switch.part.service_type, switch.part.category) == ("switch", "")
    assert switch.codec.read("x/status/boolean:200", b'{"value":true}', retained=False) == {"on_off": True}
    (told,) = switch.codec.write("on_off", False)
    assert json.loads(told.payload)["params"] == {"id": 200, "value": False}


def test_a_device_with_the_module_of_shelly_has_the_name_of_its_product(say: Say) -> None:
    info = {"id": "x", "mac": "A8032ABE54DC", "model": "S3XT-0S", "app": "XT1", "jwt": {"n": "NEO Water Valve"}}
    say("homebot/rpc", {"id": 1, "src": "x", "result": info})
    heard = say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"mac": "A8"}, "switch:0": {"output": True}}})
    (device,) = [one for one in heard if isinstance(one, DeviceAnnounced)]
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
        ("em1:1", "em1data:1", {"total_act_ret_energy": 500}, {"energy_returned": 0.5}),
    ],
)
def test_a_meter_counts_both_ways(say: Say, part_id: str, topic: str, status: object, expected: object) -> None:
    meter = part_in(introduce(say, part_id.partition("/")[0], {"a_act_power": 1, "act_power": 1}, {}), part_id)
    assert meter.codec.read(f"x/status/{topic}", json.dumps(status).encode(), retained=False) == expected
