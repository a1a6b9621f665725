"""What descriptions of real things hold beside one value a property: objects, units, two setpoints."""

from typing import Any

import pytest

from homebot.devices.text.commands import decode_command
from homebot.errors import RefusedError
from homebot.integrations.things.formats.binding import ClassifiedPart, RequestBinding
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.formats.payload import decode_document, encode_document
from homebot.integrations.things.formats.thing import NO_SECURITY

HTTP = RequestBinding(frozenset({"http"}))


def parts(
    properties: dict[str, Any], types: tuple[str, ...] = (), title: str = "T", **actions: str
) -> tuple[ClassifiedPart, ...]:
    described = {
        "@context": CONTEXT,
        "title": title,
        "@type": list(types),
        **NO_SECURITY,
        "properties": {name: {"forms": [{"href": f"http://h/{name}"}], **one} for name, one in properties.items()},
        "actions": {name: {"@type": kind, "forms": [{"href": f"http://h/{name}"}]} for name, kind in actions.items()},
    }
    return parts_of(read_thing(described), HTTP)


AIR = {
    "type": "object",
    "readOnly": True,
    "title": "Air",
    "properties": {
        "temperature": {"type": "number", "unit": "Celsius"},
        "co2": {"type": "integer"},
        "pm25": {"type": "integer"},
        "raw": {"type": "object", "properties": {"a": {"type": "number"}, "b": {"type": "number"}}},
    },
}


def test_each_value_of_an_object_that_is_only_read_is_a_part() -> None:
    warm, air, dust = parts({"air": AIR})
    assert [(one.part.id, one.part.name, one.part.service_type) for one in (warm, air, dust)] == [
        ("air/temperature", "Air temperature", "temperature_sensor"),
        ("air/co2", "Air co2", "air_quality_sensor"),
        ("air/pm25", "Air pm25", "air_quality_sensor"),
    ]
    (found,) = warm.affordances
    document = {"temperature": 21.5, "co2": 600, "raw": {"a": 1}}
    assert decode_document(found.capability, found.affordance, document) == (21.5,)
    assert decode_document(found.capability, found.affordance, {"co2": 600}) is None
    assert found.observed is not None
    assert found.observed.href == "http://h/air"


def words(*texts: str) -> dict[str, object]:
    return {"type": "string", "enum": list(texts)}


@pytest.mark.parametrize(
    ("name", "states", "service_type", "capability"),
    [
        ("lockState", words("locked", "unlocked", "jammed"), "door_lock", "lock"),
        ("state", words("LOCKED", "UNLOCKED"), "door_lock", "lock"),
        ("mode", words("disarmed", "armed_home", "armed_away"), "x_alarm_panel", "alarm"),
        ("childLock", words("locked", "unlocked"), "x_setting", "option"),
    ],
)
def test_the_states_of_a_lock_or_an_alarm_make_it_one(
    name: str, states: dict[str, object], service_type: str, capability: str
) -> None:
    """And no setting, which would be set without being asked."""
    (part,) = parts({name: states})
    (found,) = part.affordances
    assert (part.part.service_type, found.capability.name) == (service_type, capability)


def test_a_lock_of_words_is_told_its_own() -> None:
    (part,) = parts({"state": words("LOCKED", "UNLOCKED")})
    (found,) = part.affordances
    assert encode_document(found.capability, found.affordance, "unlocked") == "UNLOCKED"
    assert decode_document(found.capability, found.affordance, "LOCKED") == ("locked",)


@pytest.mark.parametrize(
    ("name", "schema", "capability"),
    [
        ("targetPosition", {"type": "integer", "minimum": 0, "maximum": 100}, "position"),
        ("flowRate", {"type": "number", "unit": "L/min", "readOnly": True}, "flow"),
    ],
)
def test_common_names_and_units_are_known(name: str, schema: dict[str, object], capability: str) -> None:
    (part,) = parts({name: schema})
    assert [one.capability.name for one in part.affordances] == [capability]


FLAG, PERCENT = {"type": "boolean"}, {"type": "integer", "minimum": 0, "maximum": 100}


@pytest.mark.parametrize(
    ("properties", "types", "switch"),
    [
        ({"ecoMode": FLAG, "on": FLAG, "brightness": PERCENT}, ("Light",), "on"),
        ({"ecoMode": FLAG, "on": FLAG, "brightness": PERCENT}, (), "on"),
        ({"childLock": FLAG, "power": FLAG}, ("SmartPlug",), "power"),
        ({"led": FLAG, "state": {"type": "string", "enum": ["ON", "OFF"]}}, ("Light",), "state"),
        ({"identify": FLAG, "main": {**FLAG, "@type": "OnOffProperty"}}, ("OnOffSwitch",), "main"),
        ({"on": FLAG, "main": {**FLAG, "@type": "OnOffProperty"}}, ("Light",), "main"),
        ({"on": {**FLAG, "readOnly": True}, "power": FLAG}, ("Light",), "power"),
        ({"lamp1": FLAG, "lamp2": FLAG}, ("Light",), "lamp1"),
    ],
)
def test_the_switch_of_a_thing_is_its_best_known_switch(
    properties: dict[str, Any], types: tuple[str, ...], switch: str
) -> None:
    """And not the first value that is yes or no: to turn a lamp on locked it for children."""
    main = next(one for one in parts(properties, types) if not one.part.id)
    assert [one.affordance.name for one in main.affordances if one.capability.name == "on_off"] == [switch]


@pytest.mark.parametrize(
    ("types", "service_type", "capability"),
    [
        (("MultiLevelSensor",), "x_sensor", "measurement"),
        (("MultiLevelSensor", "TemperatureSensor"), "x_sensor", "measurement"),
        (("WindowCovering",), "window_covering", "position"),
    ],
)
def test_a_level_that_is_only_read_is_no_blind_without_its_type(
    types: tuple[str, ...], service_type: str, capability: str
) -> None:
    level = {"@type": "LevelProperty", "type": "number", "unit": "percent", "readOnly": True}
    (found,) = parts({"level": level}, types)
    assert (found.part.service_type, [one.name for one in found.part.capabilities]) == (service_type, [capability])


def test_members_that_may_be_missing_are_no_parts() -> None:
    (found,) = parts({"air": {**AIR, "required": ["co2"]}})
    assert found.part.id == "air/co2"


def test_an_object_that_can_be_set_is_one_value() -> None:
    (found,) = parts({"air": {**AIR, "readOnly": False}})
    assert [one.name for one in found.part.capabilities] == ["raw"]


@pytest.mark.parametrize(
    ("name", "unit", "wire", "capability", "value"),
    [
        ("power", "kilowatt", 1.5, "power", 1500.0),
        ("energy", "unit:W-HR", 250.0, "energy", 0.25),
        ("pressure", "om2:pascal", 101_325, "pressure", 1013.25),
        ("x", "unit:DEG_C", 20.5, "temperature", 20.5),
        ("x", "°F", 68.0, "temperature", 20.0),
        ("x", "mA", 250, "current", 0.25),
        ("x", "unit:V", 230, "voltage", 230.0),
        ("x", "parsec", 2.0, "measurement", 2.0),
    ],
)
def test_a_unit_is_converted_and_names_the_quantity(
    name: str, unit: str, wire: float, capability: str, value: float
) -> None:
    (part,) = parts({name: {"type": "number", "unit": unit, "readOnly": True}})
    (found,) = part.affordances
    assert found.capability.name == capability
    assert decode_document(found.capability, found.affordance, wire) == (value,)


def test_a_setpoint_is_sent_in_the_unit_of_the_thing() -> None:
    (part,) = parts({"targetTemperature": {"type": "number", "unit": "K"}})
    (found,) = part.affordances
    assert encode_document(found.capability, found.affordance, 20.0) == 293.15


def test_a_thermostat_heats_and_cools() -> None:
    setpoint = {"@type": "TargetTemperatureProperty", "type": "number"}
    (found,) = parts(
        {"heatingTargetTemperature": setpoint, "coolingTargetTemperature": setpoint, "temperature": {"type": "number"}},
        ("Thermostat",),
    )
    assert [one.name for one in found.part.capabilities] == [
        "heating_setpoint",
        "cooling_setpoint",
        "local_temperature",
    ]


@pytest.mark.parametrize(
    ("modes", "service_type", "setpoint"),
    [
        (["off", "cool"], "thermostat", "cooling_setpoint"),
        (["off", "Cool", "Dry", "fan_only"], "room_air_conditioner", "cooling_setpoint"),
        (["off", "cool", "heat", "dry"], "room_air_conditioner", "heating_setpoint"),
        (["off", "manual"], "thermostat", "heating_setpoint"),
    ],
)
def test_a_thermostat_that_never_heats_cools_to_its_setpoint(
    modes: list[str], service_type: str, setpoint: str
) -> None:
    (found,) = parts(
        {
            "target": {"@type": "TargetTemperatureProperty", "type": "number"},
            "mode": {"@type": "ThermostatModeProperty", "type": "string", "enum": modes},
        },
        ("Thermostat",),
    )
    assert found.part.service_type == service_type
    assert [one.name for one in found.part.capabilities] == [setpoint, "thermostat_mode"]


@pytest.mark.parametrize(
    ("title", "level", "service_type"),
    [
        ("Water valve", "level", "switch"),
        ("Pump 2", "level", "switch"),
        ("Porch", "level", "light"),
        ("Fan lamp", "brightness", "light"),
    ],
)
def test_a_level_of_a_valve_is_not_that_of_a_lamp(title: str, level: str, service_type: str) -> None:
    """A lamp harms nobody, and is turned on with all others."""
    (found,) = parts({"on": {"type": "boolean"}, level: {"type": "number"}}, title=title)
    assert found.part.service_type == service_type


def test_a_dimmer_from_zero_to_one_is_a_level() -> None:
    (part,) = parts({"dimmer-level": {"type": "number", "unit": "om2:percent", "minimum": 0, "maximum": 1}})
    (found,) = part.affordances
    assert found.capability.name == "level"
    assert decode_document(found.capability, found.affordance, 0.25) == (25.0,)


@pytest.mark.parametrize("keyword", ["oneOf", "anyOf"])
def test_a_number_with_words_for_unknown_is_a_number(keyword: str) -> None:
    """As the bridge of ECHONET Lite describes thermometers; others allow null beside the number."""
    word = {"type": "string", "enum": ["unmeasurable"]}
    number = {"type": "number", "unit": "Celsius", "minimum": -127, "maximum": 125}
    room, water = parts(
        {
            "roomTemperature": {keyword: [number, word], "readOnly": True},
            "waterTemperature": {keyword: [number, {"type": "null"}], "readOnly": True},
        }
    )
    assert {room.part.service_type, water.part.service_type} == {"temperature_sensor"}
    (found,) = room.affordances
    assert [decode_document(found.capability, found.affordance, one) for one in (21.5, "unmeasurable", "warm")] == [
        *((21.5,), (None,), None)
    ]


def test_of_several_numbers_none_is_chosen() -> None:
    (found,) = parts({"x": {"oneOf": [{"type": "integer"}, {"type": "number"}], "readOnly": True}})
    assert [one.capability.name for one in found.affordances] == ["raw"]


def test_a_colour_of_three_numbers_is_a_colour() -> None:
    """As Eclipse Ditto describes lamps."""
    channel = {"type": "integer", "minimum": 0, "maximum": 255}
    (lamp,) = parts(
        {
            "on": {"type": "boolean"},
            "color": {"type": "object", "properties": {"r": channel, "g": channel, "b": channel}},
        }
    )
    assert (lamp.part.service_type, [one.name for one in lamp.part.capabilities]) == ("light", ["on_off", "color"])
    color = lamp.affordances[1]
    assert encode_document(color.capability, color.affordance, (240.0, 100.0)) == {"r": 0, "g": 0, "b": 255}
    documents: list[object] = [{"r": 255, "g": 0, "b": 0}, {"r": 256, "g": 0, "b": 0}, {"r": 1}, "red"]
    assert [decode_document(color.capability, color.affordance, one) for one in documents] == [
        *(((0.0, 100.0),), None, None, None)
    ]


@pytest.mark.parametrize("least", [0, 1])
def test_a_lamp_with_a_brightness_alone_is_off_at_zero_where_its_range_has_that(least: int) -> None:
    (lamp,) = parts({"brightness": {"type": "integer", "minimum": least, "maximum": 100}}, ("Light",))
    with pytest.raises(RefusedError, match=r"this part takes off, a number from 0 to 1 \(0.4 for 40 %\)"):
        decode_command("banana", lamp.part)
    (level,) = lamp.affordances
    assert decode_command("off", lamp.part) == ("level", 0.0)
    if least == 0:
        assert encode_document(level.capability, level.affordance, 0.0) == 0
    else:
        with pytest.raises(RefusedError, match="its brightness is never below 1, and it has no switch"):
            encode_document(level.capability, level.affordance, 0.0)
    assert encode_document(level.capability, level.affordance, 100.0) == 100


def test_the_actions_of_a_lock_are_its_commands() -> None:
    """Source: w3c/wot-testing, WebThings, lock: its state is only read."""
    state = {"type": "string", "@type": "LockedProperty", "enum": ["locked", "unlocked", "jammed"], "readOnly": True}
    (lock,) = parts({"locked": state}, ("Lock",), lock="LockAction", unlock="UnlockAction")
    assert lock.part.service_type == "door_lock"
    by, form, value = lock.settable["lock"].request("unlocked")
    assert (by.affordance.kind, form.href, value) == ("action", "http://h/unlock", True)
    with pytest.raises(RefusedError, match="it takes locked or unlocked"):
        lock.settable["lock"].request("open")
    (swapped,) = parts({"locked": state}, ("Lock",), lock="UnlockAction", unlock="LockAction")
    assert swapped.part.payloads != lock.part.payloads  # an approval of one is none of the other
