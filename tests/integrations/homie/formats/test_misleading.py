"""Names mislead: the type of a Homie node and the forms of its properties make its kind."""

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


def parts_of(nodes: Mapping[str, Mapping[str, object]], kind: str = "") -> list[DescribedPart]:
    """Return the parts of a device of version 5 with nodes of a type."""
    homie = Homie(HomieSettings())
    document = {
        "homie": "5.0",
        "version": 1,
        "name": "Thing",
        "nodes": {node: {"type": kind, "properties": props} for node, props in nodes.items()},
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
    ("kind", "props", "expected"),
    [
        ("thermostat", {"setpoint": number("5:30", "°C"), "child-lock": FLAG}, ["thermostat"]),
        ("", {"child-lock": FLAG}, []),
        ("lock", {"state": FLAG, "auto-lock": FLAG}, ["door_lock"]),
        ("", {"front-lock": FLAG, "child-lock": FLAG}, ["door_lock"]),
        ("shutter", {"position": PERCENT, "travel-time": number("0:120", "s")}, ["window_covering"]),
        ("shutter", {"travel-time": number("0:100", "s")}, []),
        ("thermostat", {"temperature-offset": number("-5:5", "°C"), "target": number("5:30", "°C")}, ["thermostat"]),
        ("thermostat", {"temperature": number("-10:10", "°C")}, []),
        ("fan", {"speed": choice("low", "high"), "power": FLAG}, ["fan"]),
        ("", {"level": PERCENT}, []),
        ("", {"position": number("0:3000", "mm")}, []),
        ("ev-charger", {"lock-state": {**choice("LOCKED", "UNLOCKED"), "settable": False}}, []),
        ("", {"color": {"datatype": "color", "format": "rgb", "settable": True}}, ["light"]),
    ],
)  # fmt: skip
def test_a_type_counts_only_where_one_form_bears_it_out(
    kind: str, props: dict[str, Mapping[str, object]], expected: list[str]
) -> None:
    assert loads(parts_of({"thing": props}, kind=kind)) == expected


def test_the_lock_of_a_plug_at_a_car_is_no_door_lock() -> None:
    """Source: eBus 0.9 (SPAN Drive): the device charges a car, and none of the words of its node says so."""
    assert loads(parts_of({"switch": {"lock-state": {"datatype": "enum", "format": "UNLOCKED,LOCKED"}}})) == []


HINTS = (
    "fan", "light", "lamp", "lock", "valve", "shutter",
    "blind", "garage", "thermostat", "heater", "speed", "power",
)  # fmt: skip
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
