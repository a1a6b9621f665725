"""Names mislead: the forms of its properties must prove the kind of a Homie node."""

import json
from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.integrations.homie.formats.valetudo import STATUS, VALETUDO, robot

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.integrations.homie.formats import Homie, HomieSettings

FLAG = {"datatype": "boolean", "settable": True}
WATCHED = {"datatype": "boolean"}
PERCENT = {"datatype": "integer", "format": "0:100", "unit": "%", "settable": True}
LOADS = frozenset(
    {"light", "switch", "plug", "fan", "door_lock", "water_valve", "window_covering", "closure", "thermostat"}
)


def choice(*words: str) -> dict[str, object]:
    return {"datatype": "enum", "format": ",".join(words), "settable": True}


def number(form: str, unit: str = "") -> dict[str, object]:
    return {"datatype": "float", "format": form, "unit": unit, "settable": True}


def parts_of(nodes: Mapping[str, Mapping[str, object]], name: str = "Thing") -> list[DescribedPart]:
    """Return the parts of a device of version 5 with nodes without a type."""
    homie = Homie(HomieSettings())
    document = {
        "homie": "5.0",
        "version": 1,
        "name": name,
        "nodes": {node: {"properties": props} for node, props in nodes.items()},
    }
    homie.read_message("homie/5/thing/$description", json.dumps(document).encode(), retained=True)
    found = homie.read_message("homie/5/thing/$state", b"ready", retained=True)
    return [part for one in found if isinstance(one, DeviceAnnounced) for part in one.parts]


def loads(parts: list[DescribedPart]) -> list[str]:
    return [one.part.service_type for one in parts if one.part.service_type in LOADS]


@pytest.mark.parametrize("has_status", [True, False], ids=["with its state", "before its state came"])
def test_a_robot_that_cleans_is_no_fan_and_its_water_tank_does_not_leak(has_status: bool) -> None:  # noqa: FBT001
    described = robot("homie/robot", {**VALETUDO, **({"StatusStateAttribute": STATUS} if has_status else {})})
    parts = {one.part.id: one for one in described.parts}
    types = {name: one.part.service_type for name, one in parts.items()}
    assert types["BasicControlCapability"] == "robotic_vacuum_cleaner"
    assert set(types.values()).isdisjoint(LOADS | {"water_leak_detector"})
    assert types["AttachmentStateAttribute/watertank"] == "x_binary_sensor"
    assert types["BatteryStateAttribute/level"] == "x_battery"
    cleaner = parts["BasicControlCapability"]
    capabilities = {one.name: one for one in cleaner.part.capabilities}
    assert capabilities["vacuum"].readable == has_status
    assert capabilities["fan_mode"].options == ("off", "low", "medium", "high", "max")
    (told,) = cleaner.codec.write("fan_mode", "max")
    assert told.topic == "homie/robot/FanSpeedControlCapability/preset/set"
    assert "FanSpeedControlCapability/preset" not in types, "what the robot is told is no second setting"
    assert types["WaterUsageControlCapability/preset"] == "x_setting"


@pytest.mark.parametrize(
    ("node", "props", "expected"),
    [
        ("trv", {"setpoint": number("5:30", "°C"), "child-lock": FLAG}, ["thermostat"]),
        ("child-lock", {"state": FLAG}, []),
        ("child-lock", {"child-lock": FLAG}, []),
        ("keypad-lock", {"lock": FLAG}, []),
        ("front-lock", {"state": FLAG, "auto-lock": FLAG}, ["door_lock"]),
        ("shutter", {"position": PERCENT, "travel-time": number("0:120", "s")}, ["window_covering"]),
        ("shutter", {"travel-time": number("0:100", "s")}, []),
        ("heater", {"temperature-offset": number("-5:5", "°C"), "target": number("5:30", "°C")}, ["thermostat"]),
        ("heater", {"temperature": number("-10:10", "°C")}, []),
        ("heater", {"target-humidity": number("0:100", "%")}, []),
        ("fan", {"mode": choice("auto", "low", "high")}, []),
        ("fan", {"speed": choice("off", "low", "high")}, ["fan"]),
        ("fan", {"speed": choice("low", "high"), "power": FLAG}, ["fan"]),
        ("thermostat", {"display-brightness": PERCENT, "setpoint": number("5:30", "°C")}, ["thermostat"]),
        ("speaker", {"level": PERCENT}, []),
        ("speaker", {"volume": PERCENT}, []),
        ("arm", {"position": number("0:3000", "mm")}, []),
        ("motion-light", {"sensitivity": PERCENT}, []),
        ("led-indicator", {"indicator": FLAG}, []),
        ("garden-valve", {"water-valve": FLAG}, ["water_valve"]),
        ("valve", {"valve-position": PERCENT}, []),
        ("garage", {"light": {"datatype": "enum", "format": "off,on", "settable": True}}, []),
        ("window-lock", {"locked": FLAG}, ["door_lock"]),
        ("ev-charger", {"lock-state": {**choice("LOCKED", "UNLOCKED"), "settable": False}}, []),
        ("radiator", {"color": {"datatype": "color", "format": "rgb", "settable": True}}, ["light"]),
    ],
)  # fmt: skip
def test_a_name_counts_only_where_the_form_bears_it_out(
    node: str, props: dict[str, Mapping[str, object]], expected: list[str]
) -> None:
    assert loads(parts_of({node: props})) == expected


def test_the_lock_of_a_plug_at_a_car_is_no_door_lock() -> None:
    """Source: eBus 0.9 (SPAN Drive): the device charges a car, and none of the words of its node says so."""
    lock = {"datatype": "enum", "format": "UNLOCKED,LOCKED"}
    assert loads(parts_of({"switch": {"lock-state": lock}}, name="EVSE")) == []
    assert loads(parts_of({"switch": {"lock-state": lock}}, name="Door")) == ["door_lock"]


def test_another_switch_is_not_that_of_a_lamp() -> None:
    parts = {one.part.id: one for one in parts_of({"pump": {"power": FLAG}, "lamp": {"brightness": PERCENT}})}
    assert {name: one.part.service_type for name, one in parts.items()} == {"pump": "switch", "lamp": "light"}
    assert {one.topic for one in parts["lamp"].codec.write("on_off", False)} == {"homie/5/thing/lamp/brightness/set"}


HINTS = (
    "fan", "light", "lamp", "lock", "valve", "shutter",
    "blind", "garage", "thermostat", "heater", "speed", "power",
)  # fmt: skip
BESIDE = (
    "child", "offset", "display", "enabled", "delay",
    "sensitivity", "schedule", "indicator", "calibration", "timeout",
)  # fmt: skip
OBJECTS = ("tank", "heater", "meter", "bell", "filter", "empty", "installed", "dock")
CONDITIONS = ("water", "gas", "door", "smoke", "leak", "window")
forms: st.SearchStrategy[dict[str, object]] = st.sampled_from(
    [
        FLAG,
        PERCENT,
        number("0:1:0.01"),
        number("5:30", "°C"),
        number("-5:5", "°C"),
        number("2700:6500", "K"),
        choice("off", "low", "high"),
        choice("low", "high"),
        choice("open", "close", "stop"),
        choice("lock", "unlock"),
        choice("off", "heat"),
        {"datatype": "color", "format": "rgb", "settable": True},
        {"datatype": "string", "settable": True},
    ]
)
hints = st.lists(st.sampled_from(HINTS), min_size=1, max_size=3).map("-".join)
nodes = st.dictionaries(hints, st.dictionaries(hints, forms, min_size=1, max_size=4), min_size=1, max_size=3)


@given(nodes, st.sampled_from(BESIDE))
def test_a_property_of_something_beside_controls_nothing(made: dict[str, Any], beside: str) -> None:
    qualified = {node: {f"{prop}-{beside}": form for prop, form in props.items()} for node, props in made.items()}
    parts = parts_of(qualified)
    assert loads(parts) == []
    assert all(one.part.category == "config" for one in parts)


@given(nodes)
def test_a_kind_needs_its_evidence(made: dict[str, Any]) -> None:
    for one in parts_of(made):
        capabilities = {known.name: known for known in one.part.capabilities}
        match one.part.service_type:
            case "fan":
                assert "on_off" in capabilities or "off" in capabilities["fan_mode"].options
            case "door_lock":
                one.codec.write("lock", "locked")
            case "window_covering" | "closure":
                assert capabilities.keys() & {"position", "tilt", "movement"}
            case "thermostat":
                assert capabilities.keys() & {"heating_setpoint", "cooling_setpoint", "thermostat_mode"}
                for bounds in (capabilities[name].bounds for name in capabilities if name.endswith("setpoint")):
                    assert bounds == () or bounds[0] <= 20 <= bounds[1]


@given(nodes)
def test_of_a_robot_that_cleans_nothing_else_is_taken_for_a_load(made: dict[str, Any]) -> None:
    robot: dict[str, Any] = {
        "status": {"status": {"datatype": "enum", "format": "docked,cleaning"}},
        "basic": {"operation": choice("START", "STOP", "PAUSE", "HOME")},
    }
    parts = parts_of({**made, **robot})
    assert loads(parts) == []
    assert [one.part.service_type for one in parts].count("robotic_vacuum_cleaner") == 1


@given(st.sampled_from(CONDITIONS), st.sampled_from(OBJECTS), st.booleans())
def test_a_condition_in_the_name_of_a_thing_is_none(condition: str, thing: str, is_node: bool) -> None:  # noqa: FBT001
    name = f"{condition}-{thing}"
    (part,) = parts_of({name: {"state": WATCHED}} if is_node else {"node": {name: WATCHED}})
    assert [one.name for one in part.part.capabilities] == ["state"]
