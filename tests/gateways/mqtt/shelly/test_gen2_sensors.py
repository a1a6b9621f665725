import json
from collections.abc import Callable

import pytest

from homebot.gateways.mqtt.description import DescribedPart, Heard

Say = Callable[..., tuple[Heard, ...]]
Find = Callable[[tuple[Heard, ...], str], DescribedPart]


def introduce(say: Say, key: str, status: object, config: object) -> tuple[Heard, ...]:
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"device": {}}, key: config}})
    return say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"mac": "A8"}, key: status}})


@pytest.mark.parametrize(
    ("key", "config", "part_id", "service_type", "status", "expected"),
    [
        ("smoke:0", {}, "smoke:0", "smoke_co_alarm", {"alarm": True}, {"smoke": True}),
        ("flood:0", {}, "flood:0", "water_leak_detector", {"alarm": False}, {"water_leak": False}),
        ("flood:0", {}, "flood:0", "water_leak_detector", {"alarm": None}, {"water_leak": None}),
        ("humidity:0", {}, "humidity:0", "humidity_sensor", {"rh": 45.5}, {"humidity": 45.5}),
        ("illuminance:0", {}, "illuminance:0", "light_sensor", {"lux": 100}, {"illuminance": 100.0}),
        ("voltmeter:100", {}, "voltmeter:100", "electrical_meter", {"voltage": 12.1}, {"voltage": 12.1}),
        ("presencezone:200", {}, "presencezone:200", "occupancy_sensor", {"state": True}, {"occupancy": True}),
        (
            "devicepower:0",
            {},
            "devicepower:0",
            "x_battery",
            {"battery": {"percent": 57}, "external": {"present": True}},
            {"battery": 57.0, "plugged_in": True},
        ),
        ("input:0", {"type": "switch"}, "input:0", "x_binary_sensor", {"state": True}, {"state": True}),
        ("input:0", {"type": "analog"}, "input:0", "x_sensor", {"percent": 12}, {"measurement": 12.0}),
        ("input:0", {"type": "count"}, "input:0", "x_sensor", {"counts": {"total": 5}}, {"measurement": 5.0}),
        ("em1:0", {}, "em1:0", "electrical_meter", {"act_power": 200, "freq": 50}, {"power": 200.0, "frequency": 50.0}),
        ("pm1:0", {}, "pm1:0", "electrical_meter", {"apower": 42}, {"power": 42.0}),
        (
            "switch:0",
            {},
            "switch:0/temperature",
            "temperature_sensor",
            {"temperature": {"tC": 40.1}},
            {"temperature": 40.1},
        ),
        (
            "blutrv:200",
            {},
            "blutrv:200",
            "thermostat",
            {"target_C": 21, "current_C": 20, "pos": 40},
            {"heating_setpoint": 21.0, "local_temperature": 20.0, "position": 40.0},
        ),
        (
            "bthomesensor:200",
            {"obj_id": 69},
            "bthomesensor:200",
            "temperature_sensor",
            {"value": 21},
            {"temperature": 21.0},
        ),
    ],
)
def test_a_component_tells(
    say: Say, part: Find, key: str, config: object, part_id: str, service_type: str, status: object, expected: object
) -> None:
    found = part(introduce(say, key, status, config), part_id)
    assert found.part.service_type == service_type
    assert found.codec.read(f"x/status/{key}", json.dumps(status).encode(), retained=False) == expected
    news = json.dumps({"method": "NotifyStatus", "params": {key: status}}).encode()
    assert found.codec.read("x/events/rpc", news, retained=False) == expected


@pytest.mark.parametrize(
    ("key", "config"),
    [("input:0", {"enable": False}), ("bthomesensor:200", {"obj_id": 9999}), ("ble:0", {}), ("switch:", {})],
)
def test_what_is_off_or_unknown_is_no_part(say: Say, key: str, config: object) -> None:
    assert introduce(say, key, {"state": True, "value": 1}, config) == ()
