"""Devices of the second generation with components of their own: thermostats of makers, and diffusers."""

import json
from collections.abc import Mapping

import pytest
from tests.integrations.announced_parts import Say

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.devices.value import PlainValue

Fields = Mapping[str, object]


def parts_of(say: Say, config: Fields, status: Fields) -> dict[str, DescribedPart]:
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"id": "x", "mac": "A8032ABE54DC"}})
    say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"device": {}}, **config}})
    heard = say("homebot/rpc", {"id": 1, "src": "x", "result": {"sys": {"mac": "A8"}, **status}})
    (device,) = [one for one in heard if isinstance(one, DeviceAnnounced)]
    return {one.part.id: one for one in device.parts}


def calls(publications: tuple[Publication, ...]) -> list[tuple[str, object]]:
    frames = [json.loads(one.payload) for one in publications]
    return [(one["method"], one["params"]) for one in frames]


def of_service(role: str, **config: object) -> Fields:
    return {"owner": "service:0", "role": role, "access": "crw", **config}


FLOOR = {
    "boolean:201": of_service("enable"),
    "number:201": of_service("current_temperature"),
    "number:203": of_service("target_temperature", min=5, max=35),
}
AIR = {
    **FLOOR,
    "enum:200": of_service("fan_speed", options=["auto", "low", "high"]),
    "enum:201": of_service("working_mode", options=["cool", "dry", "heat", "ventilation"]),
}


def thermostat(say: Say, config: Fields) -> DescribedPart:
    parts = parts_of(say, config, {key: {"value": None} for key in config})
    assert parts.keys() == {"number:201", "number:203"}
    return parts["number:203"]


def test_a_thermostat_of_a_maker_is_one_part(say: Say) -> None:
    """As the LinkedGo ST802."""
    part = thermostat(say, AIR)
    options = {one.name: one.options for one in part.part.capabilities if one.settable}
    assert part.part.service_type == "thermostat"
    assert options == {
        "heating_setpoint": (),
        "cooling_setpoint": (),
        "thermostat_mode": ("off", "cool", "dry", "heat", "fan_only"),
        "fan_mode": ("auto", "low", "high"),
    }
    status = {
        "boolean:201": {"value": True},
        "enum:200": {"value": "auto"},
        "enum:201": {"value": "ventilation"},
        "number:201": {"value": 25.1},
        "number:203": {"value": 20.5},
    }
    frame = json.dumps({"method": "NotifyStatus", "params": status})
    assert part.codec.read("x/events/rpc", frame.encode(), retained=False) == {
        "heating_setpoint": 20.5,
        "cooling_setpoint": 20.5,
        "local_temperature": 25.1,
        "thermostat_mode": "fan_only",
        "fan_mode": "auto",
    }


def test_a_thermostat_that_is_turned_off_keeps_its_working_mode(say: Say) -> None:
    codec = thermostat(say, AIR).codec
    said = [("enum:201", "heat"), ("boolean:201", False), ("enum:201", "cool"), ("boolean:201", True)]
    heard = [
        codec.read(f"x/status/{key}", json.dumps({"value": value}).encode(), retained=False) for key, value in said
    ]
    assert [one["thermostat_mode"] for one in heard] == ["heat", "off", "off", "cool"]


@pytest.mark.parametrize(
    ("config", "mode", "expected"),
    [
        (AIR, "off", [("Boolean.Set", {"id": 201, "value": False})]),
        (AIR, "heat", [("Boolean.Set", {"id": 201, "value": True}), ("Enum.Set", {"id": 201, "value": "heat"})]),
        (FLOOR, "heat", [("Boolean.Set", {"id": 201, "value": True})]),
    ],
)
def test_the_mode_of_a_thermostat_is_commanded_where_it_is(
    say: Say, config: Fields, mode: str, expected: list[tuple[str, object]]
) -> None:
    codec = thermostat(say, config).codec
    assert calls(codec.write("thermostat_mode", mode)) == expected
    assert calls(codec.write("heating_setpoint", 21.0)) == [("Number.Set", {"id": 203, "value": 21})]


def test_a_diffuser_has_a_switch_for_each_slot(say: Say) -> None:
    left = {"on": False, "intensity": 70, "vial": {"level": 93, "name": "Sea"}}
    status = {"cury:0": {"id": 0, "slots": {"left": left, "right": {"on": True, "intensity": 45, "vial": None}}}}
    parts = parts_of(say, {"cury:0": {"id": 0, "name": None}}, status)
    types = {part_id: (one.part.service_type, one.part.category) for part_id, one in parts.items()}
    assert types == {
        f"cury:0/{slot}{suffix}": known
        for slot in ("left", "right")
        for suffix, known in (
            ("", ("switch", "")),
            ("/intensity", ("x_setting", "config")),
            ("/vial", ("x_sensor", "diagnostic")),
        )
    }
    assert parts["cury:0/left"].part.name == "left"
    payload = json.dumps({"params": status}).encode()
    heard = {part_id: dict(one.codec.read("x/events/rpc", payload, retained=False)) for part_id, one in parts.items()}
    assert (heard["cury:0/left"], heard["cury:0/right"]) == ({"on_off": False}, {"on_off": True})
    assert (heard["cury:0/left/intensity"], heard["cury:0/left/vial"]) == ({"number": 70.0}, {"measurement": 93.0})
    assert calls(parts["cury:0/right"].codec.write("on_off", False)) == [
        ("Cury.Set", {"id": 0, "slot": "right", "on": False})
    ]
    assert calls(parts["cury:0/left/intensity"].codec.write("number", 30.0)) == [
        ("Cury.Set", {"id": 0, "slot": "left", "intensity": 30})
    ]


STRIP = {"on": True, "brightness": 40, "rgb": [255, 0, 0], "effect": "rainbow"}


@pytest.mark.parametrize(
    ("capability", "value", "params"),
    [
        ("on_off", False, {"on": False}),
        ("level", 50.0, {"on": True, "brightness": 50}),
        ("color", (120.0, 100.0), {"on": True, "rgb": [0, 255, 0]}),
        ("effect", "static", {"on": True, "effect": "static"}),
    ],
)
def test_a_strip_of_leds_is_a_lamp_with_effects(
    say: Say, capability: str, value: PlainValue, params: Mapping[str, object]
) -> None:
    """As Home Assistant 2026.11 reads and commands it."""
    config = {"ledstrip:0": {"id": 0, "effects": ["static", "rainbow"]}}
    strip = parts_of(say, config, {"ledstrip:0": {"id": 0, **STRIP}})["ledstrip:0"]
    assert strip.part.service_type == "light"
    frame = json.dumps({"params": {"ledstrip:0": STRIP}}).encode()
    assert strip.codec.read("x/events/rpc", frame, retained=False) == {
        "on_off": True, "level": 40.0, "color": (0.0, 100.0), "effect": "rainbow",
    }  # fmt: skip
    assert not strip.part.fades
    assert calls(strip.codec.write(capability, value, transition=1.0)) == [("LedStrip.Set", {"id": 0, **params})]


NEO = {
    "boolean:200": of_service("state"),
    "number:200": of_service("water_temperature", meta={"ui": {"unit": "°C"}}),
    "object:200": of_service("water_consumption"),
    "object:201": of_service("other"),
}


def test_a_state_beside_a_water_meter_is_a_valve(say: Say) -> None:
    """As the Neo smart water valve: it opens the water of a house, and asks before."""
    parts = parts_of(say, NEO, {key: {"value": None} for key in NEO})
    assert {key: one.part.service_type for key, one in parts.items()} == {
        "boolean:200": "water_valve",
        "number:200": "temperature_sensor",
        "object:200": "x_sensor",
    }
    assert calls(parts["boolean:200"].codec.write("valve", "open")) == [("Boolean.Set", {"id": 200, "value": True})]
    frame = json.dumps({"params": {"object:200": {"value": {"counter": {"total": 12.345}}}}}).encode()
    assert parts["object:200"].codec.read("x/events/rpc", frame, retained=False) == {"measurement": 12.345}


def test_the_phases_of_a_charger_are_meters(say: Say) -> None:
    """Of the Top AC Portable EV Charger, in kilowatts, as Home Assistant 2026.11 reads it."""
    phase = {"voltage": 231.5, "current": 15.9, "power": 3.68}
    value = {"phase_a": phase, "phase_b": phase, "phase_c": phase, "total_power": 11.04, "total_act_energy": 5.2}
    parts = parts_of(say, {"object:200": of_service("phase_info")}, {"object:200": {"value": value}})
    assert {one.part.service_type for one in parts.values()} == {"electrical_meter"}
    frame = json.dumps({"params": {"object:200": {"value": value}}}).encode()
    heard = {key: dict(one.codec.read("x/events/rpc", frame, retained=False)) for key, one in parts.items()}
    assert heard["object:200"] == {"power": 11_040.0, "energy": 5.2}
    assert heard["object:200/phase_b"] == {"power": 3680.0, "voltage": 231.5, "current": 15.9}
