"""Exposes become parts that read and write the right properties."""

import json
from typing import Any

import pytest

from homebot.conventions.description import DescribedPart, Publication
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.zigbee2mqtt.formats.bridge_device import read_bridge_device
from homebot.integrations.zigbee2mqtt.formats.parts import build_parts

TOPIC = "zigbee2mqtt/a"


def feature(kind: str, name: str, access: int = 7, key: str = "", **more: Any) -> dict[str, Any]:
    return {"type": kind, "name": name, "property": key or name, "access": access, **more}


def onoff(suffix: str = "", access: int = 7) -> dict[str, Any]:
    return feature("binary", "state", access, f"state{suffix}", value_on="ON", value_off="OFF")


def level(suffix: str = "") -> dict[str, Any]:
    return feature("numeric", "brightness", key=f"brightness{suffix}", value_min=0, value_max=254)


WHITE = feature("numeric", "color_temp", value_min=153, value_max=500)
XY = feature("composite", "color_xy", key="color", features=[])
EFFECT = feature("enum", "effect", 2, values=["blink", "stop_effect"])


def built(
    *exposes: dict[str, Any], model: str = "m", power: str = "Mains", endpoints: object = None, **definition: Any
) -> list[DescribedPart]:
    entry = {
        "endpoints": endpoints,
        "ieee_address": "0x00158d0001abcdef",
        "friendly_name": "a",
        "power_source": power,
        "definition": {"model": model, "exposes": list(exposes), **definition},
    }
    return list(build_parts(read_bridge_device("zigbee2mqtt", entry)))


def only(*exposes: dict[str, Any], **more: Any) -> DescribedPart:
    (part,) = built(*exposes, **more)
    return part


def said(part: DescribedPart, *, retained: bool = False, **message: Any) -> dict[str, PlainValue]:
    return dict(part.codec.read(TOPIC, json.dumps(message).encode(), retained=retained))


def told(part: DescribedPart, capability: str, value: PlainValue, transition: float = 0.0) -> dict[str, Any]:
    (publication,) = part.codec.write(capability, value, transition=transition)
    assert publication.topic == f"{TOPIC}/set"
    message: dict[str, Any] = json.loads(publication.payload)
    return message


def names(part: DescribedPart) -> list[str]:
    return [one.name for one in part.part.capabilities]


def test_without_a_colour_mode_the_only_value_is_read() -> None:
    lamp = only({"type": "light", "features": [onoff(), level(), WHITE, XY]}, EFFECT)
    assert said(lamp, color_temp=370) == {"color_temperature": 2702.0, "color": None}
    assert said(lamp, color={"x": 0.7006, "y": 0.2993}) == {"color": (0.0, 100.0), "color_temperature": None}
    assert said(lamp, color={"hue": 240, "saturation": 50})["color"] == (240.0, 50.0)
    assert said(lamp, color_temp=370, color={"x": 0.7006, "y": 0.2993}) == {}
    assert said(lamp, color_temp=None, color_mode=None) == {}


def test_lamps_of_one_device_have_their_own_properties() -> None:
    first, second = built(
        {"type": "light", "endpoint": "l1", "features": [onoff("_l1"), level("_l1")]},
        {"type": "light", "endpoint": "l2", "features": [onoff("_l2"), level("_l2")]},
    )
    assert (first.part.id, first.part.name, second.part.id) == ("light_l1", "l1", "light_l2")
    assert said(second, state_l1="ON", state_l2="OFF", brightness_l2=254) == {"on_off": False, "level": 100.0}
    assert told(second, "level", 100.0) == {"state_l2": "ON", "brightness_l2": 254}
    assert first.state_requests == (Publication("zigbee2mqtt/a/get", b'{"state_l1":"","brightness_l1":""}'),)


def test_only_gettable_features_of_awake_devices_are_requested() -> None:
    exposes = {"type": "light", "features": [onoff(access=3), level()]}
    assert only(exposes).state_requests == (Publication("zigbee2mqtt/a/get", b'{"brightness":""}'),)
    assert only({"type": "switch", "features": [onoff(access=3)]}).state_requests == ()
    assert only(exposes, power="Battery").state_requests == ()


def test_a_switch_that_is_no_state_is_a_setting() -> None:
    state = feature("binary", "state", key="window_detection", value_on="ON", value_off="OFF")
    switch = only({"type": "switch", "label": "Window detection", "features": [state]})
    assert (switch.part.service_type, switch.part.category) == ("x_setting", "config")
    assert switch.part.id == "window_detection"


MOVING = feature("enum", "moving", 1, values=["UP", "STOP", "DOWN"])
POSITION = feature("numeric", "position", value_min=0, value_max=100)
COVER = {"type": "cover", "features": [feature("enum", "state", 3, values=["OPEN", "CLOSE", "STOP"]), POSITION]}


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ({"state": "OPEN", "position": 30}, {"movement": "open", "position": 30.0}),
        ({"state": "CLOSE", "position": 0}, {"movement": "closed", "position": 0.0}),
        ({"state": "OPEN", "position": 30, "moving": "DOWN"}, {"movement": "closing", "position": 30.0}),
        ({"state": "CLOSE", "position": 0, "moving": "DOWN"}, {"movement": "closed", "position": 0.0}),
        ({"state": "OPEN", "moving": "STOP"}, {"movement": "open"}),
        ({"state": "CLOSE", "position": 100, "running": True}, {"movement": "closing", "position": 100.0}),
        ({"state": "CLOSE", "position": 0, "running": True}, {"movement": "closed", "position": 0.0}),
        ({"state": "OPEN", "position": 0, "running": True}, {"movement": "opening", "position": 0.0}),
        ({"state": "OPEN", "position": 60, "running": True}, {"position": 60.0}),  # it may go either way
        ({"state": "CLOSE", "position": 30, "running": False}, {"movement": "open", "position": 30.0}),
        ({"state": None}, {"movement": None}),
        ({"position": 130}, {"position": 100.0}),
    ],
)
def test_a_cover_reports_position_and_movement(message: dict[str, Any], expected: dict[str, Any]) -> None:
    cover, _motor = built(COVER, MOVING)
    assert said(cover, **message) == expected


@pytest.mark.parametrize(
    ("message", "movement"),
    [
        ({"state": "OPEN", "position": 0, "running": False}, "closed"),
        ({"state": "OPEN", "position": 0, "moving": "STOP"}, "closed"),
        ({"state": "CLOSE", "position": 100, "moving": "STOP"}, "open"),
        ({"state": "STOP", "position": 0}, "closed"),
        ({"state": "STOP", "position": 100}, "open"),
        ({"state": "STOP", "position": 30}, "stopped"),
        ({"state": "OFF", "position": 0}, "closed"),
        ({"state": "OFF", "position": 60}, "stopped"),
        ({"state": "OFF"}, "stopped"),
        ({"state": "OPEN", "position": 0, "moving": "UP"}, "opening"),
    ],
)
def test_a_motor_that_stands_is_where_its_position_says(message: dict[str, Any], movement: str) -> None:
    cover, _motor = built(COVER, MOVING)
    assert said(cover, **message)["movement"] == movement


LOCK = {
    "type": "lock",
    "features": [
        feature("binary", "state", value_on="LOCK", value_off="UNLOCK"),
        feature("enum", "lock_state", 1, values=["not_fully_locked", "locked", "unlocked"]),
    ],
}


def test_a_lock_goes_by_its_state_and_else_by_its_bolt() -> None:
    lock = only(LOCK)
    assert lock.part.service_type == "door_lock"
    assert said(lock, state="LOCK", lock_state="unlocked") == {"lock": "locked"}
    assert said(lock, lock_state="not_fully_locked") == {"lock": "unlocked"}
    assert said(lock, state=None) == {"lock": None}
    assert said(lock, state="WHAT") == {}
    assert told(lock, "lock", "unlocked") == {"state": "UNLOCK"}
    with pytest.raises(RefusedError):
        lock.codec.write("lock", "open")


def test_an_approval_of_a_lock_is_none_of_one_whose_features_are_swapped() -> None:
    words: dict[str, Any] = {"value_on": "LOCK", "value_off": "UNLOCK"}
    locks = [
        built({"type": "lock", "features": [feature("binary", name, key=key, **words) for name, key in named]})[0]
        for named in ((("state", "state"), ("x", "latch")), (("x", "state"), ("state", "latch")))
    ]
    assert [told(lock, "lock", "locked") for lock in locks] == [{"state": "LOCK"}, {"latch": "LOCK"}]
    assert locks[0].part.payloads != locks[1].part.payloads


def test_the_main_purpose_of_a_device_comes_first() -> None:
    """Tuya's TS0601_thermostat exposes its window sensor first, so that it was listed as a contact sensor."""
    window = feature("binary", "window_open", 1, value_on=True, value_off=False)
    climate = {"type": "climate", "features": [feature("numeric", "occupied_heating_setpoint")]}
    assert [one.part.service_type for one in built(window, climate)] == ["thermostat", "contact_sensor"]

    key_lock = {
        "type": "lock",
        "features": [feature("binary", "state", 3, key="child_lock", value_on="LOCK", value_off="UNLOCK")],
    }
    switch = {"type": "switch", "features": [feature("binary", "state", 3, value_on="ON", value_off="OFF")]}
    assert [one.part.service_type for one in built(switch, key_lock)] == ["switch", "x_setting"]


@pytest.mark.parametrize("key", ["child_lock", "keypad_lockout"])
def test_a_key_lock_of_older_versions_is_a_setting(key: str) -> None:
    state = feature("binary", "state", 3, key=key, value_on="LOCK", value_off="UNLOCK")
    lock = only({"type": "lock", "features": [state]})
    part = lock.part
    assert (part.id, part.service_type, part.category, names(lock)) == (key, "x_setting", "config", ["on_off"])
    assert part.name == key.replace("_", " ").capitalize()
    assert dict(lock.codec.read(TOPIC, json.dumps({key: "LOCK"}).encode(), retained=False)) == {"on_off": True}
    assert told(lock, "on_off", value=False) == {key: "UNLOCK"}


def operating(mode: str, *modes: str) -> DescribedPart:
    """A thermostat of Bosch's: *mode* is the only one of its modes, or the first."""
    features = [feature("enum", "system_mode", values=[mode, *modes])]
    program = feature("enum", "operating_mode", values=["schedule", "manual", "pause"], category="config")
    return built({"type": "climate", "features": features}, program)[0]


def test_an_incomplete_mode_of_two_properties_is_ignored() -> None:
    part = operating("heat", "cool")
    assert said(part, system_mode="heat") == {}
    assert said(part, operating_mode="manual") == {}
    assert said(part, operating_mode="x") == {}
    assert said(part, operating_mode=None) == {"thermostat_mode": None, "on_off": None}


def thermostat(setpoints: str, *modes: str) -> DescribedPart:
    numbers = [feature("numeric", name, unit="°C", value_min=5, value_max=30) for name in setpoints.split()]
    return built({"type": "climate", "features": [*numbers, feature("enum", "system_mode", values=list(modes))]})[0]


@pytest.mark.parametrize(
    ("part", "on", "off"),
    [
        (operating("heat"), {"operating_mode": "manual"}, {"operating_mode": "pause"}),
        (thermostat("", "off", "auto"), {"system_mode": "auto"}, {"system_mode": "off"}),
        (thermostat("", "off", "auto", "dry", "cool"), {"system_mode": "cool"}, {"system_mode": "off"}),
    ],
)
def test_a_thermostat_is_switched_by_its_modes(part: DescribedPart, on: dict[str, Any], off: dict[str, Any]) -> None:
    """As Zigbee2MQTT's announcement to Home Assistant is."""
    assert told(part, "on_off", value=True) == on
    assert told(part, "on_off", value=False) == off
    assert said(part, **{"system_mode": "heat", **on})["on_off"] is True
    assert said(part, **off)["on_off"] is False


def test_a_thermostat_without_a_mode_that_is_on_is_only_turned_off() -> None:
    part = thermostat("", "off", "dry", "fan_only")
    assert told(part, "on_off", value=False) == {"system_mode": "off"}
    with pytest.raises(RefusedError, match="none of its modes is that: off, dry, fan_only"):
        part.codec.write("on_off", value=True)


@pytest.mark.parametrize(
    ("part", "setpoints"),
    [
        (thermostat("occupied_heating_setpoint", "off", "heat"), ["heating_setpoint"]),
        (thermostat("current_heating_setpoint", "cool", "heat", "dry"), ["cooling_setpoint", "heating_setpoint"]),
        (thermostat("current_heating_setpoint", "cool", "dry", "fan_only"), ["cooling_setpoint"]),
        (
            thermostat("occupied_heating_setpoint occupied_cooling_setpoint", "cool", "heat"),
            ["cooling_setpoint", "heating_setpoint"],
        ),
    ],
)
def test_a_single_setpoint_is_that_of_the_modes_that_use_it(part: DescribedPart, setpoints: list[str]) -> None:
    """A split air conditioner that is set by ``current_heating_setpoint`` alone cools by it."""
    assert [name for name in names(part) if name.endswith("setpoint")] == setpoints


def test_what_a_thermostat_does_is_only_reported() -> None:
    """AVATTO TRV26 and Tuya BAB-1413_Pro declare it settable."""
    action = feature("enum", "running_state", 3, values=["idle", "heat"])
    part = only({"type": "climate", "features": [action]})
    assert said(part, running_state="heat") == {"thermostat_action": "heating"}
    assert not part.part.capabilities[0].settable


def binary(name: str, on: object, off: object) -> dict[str, Any]:
    return feature("binary", name, 1, value_on=on, value_off=off)


def numeric(name: str, unit: str) -> dict[str, Any]:
    return feature("numeric", name, 1, unit=unit)


@pytest.mark.parametrize(
    ("expose", "service_type", "value", "expected"),
    [
        (binary("contact", False, True), "contact_sensor", False, {"contact": True}),
        (binary("contact", False, True), "contact_sensor", 0, {}),
        (binary("garage_door_contact", True, False), "contact_sensor", True, {"contact": False}),
        (binary("occupancy", True, False), "occupancy_sensor", True, {"occupancy": True}),
        (binary("water_leak", "Leak", "Dry"), "water_leak_detector", "Dry", {"water_leak": False}),
        (binary("active_water_leak", True, False), "water_leak_detector", True, {"water_leak": True}),  # CTM Lyng
        (binary("trouble", True, False), "x_binary_sensor", True, {"problem": True}),  # Shelly S4SN-0071A
        (binary("odd", "yes", "no"), "x_binary_sensor", None, {"state": None}),
        (numeric("temperature", "°C"), "temperature_sensor", 21.5, {"temperature": 21.5}),
        (numeric("temperature", "°F"), "temperature_sensor", 212, {"temperature": pytest.approx(100)}),
        (numeric("outdoor_temperature", "°C"), "temperature_sensor", 1, {"temperature": 1.0}),
        (numeric("pressure", "kPa"), "pressure_sensor", 101.3, {"pressure": 1013.0}),
        (numeric("power_a", "kW"), "electrical_meter", 1.5, {"power": 1500.0}),
        (numeric("energy", "Wh"), "electrical_meter", 1500, {"energy": 1.5}),
        (numeric("produced_energy_tier_1", "kWh"), "electrical_meter", 2.5, {"energy_returned": 2.5}),  # OBIS 2.8.1
        (numeric("EAIT", "kWh"), "electrical_meter", 2.5, {"energy_returned": 2.5}),  # LiXee ZLinky_TIC
        (numeric("total_output_energy", "kWh"), "electrical_meter", 1, {"energy_returned": 1.0}),  # Sonoff MINI-ZB1GSP
        (numeric("voltage", "mV"), "electrical_meter", 3000, {"voltage": 3.0}),
        (numeric("co2", "ppm"), "air_quality_sensor", 800, {"carbon_dioxide": 800.0}),
        (numeric("co_ppm", "ppm"), "air_quality_sensor", 4, {"carbon_monoxide": 4.0}),  # HALO
        (numeric("ambient_light", "Lx"), "light_sensor", 40, {"illuminance": 40.0}),  # Heiman HS1MIS-3.0
        (numeric("moisture", "%"), "soil_sensor", 30, {"soil_moisture": 30.0}),  # Excellux EZ-500FL
        (numeric("flow_rate", "L/h"), "flow_sensor", 90, {"flow": 0.09}),  # Tuya TS0601_water_valve
        (numeric("floor_temp", "°C"), "temperature_sensor", 24, {"temperature": 24.0}),  # CTM Lyng mTouch_One
        (numeric("carbon_monoxide", "ppm"), "air_quality_sensor", 3, {"carbon_monoxide": 3.0}),
        (numeric("battery", "%"), "x_battery", "full", {}),
        (numeric("heat_limit_temperature", "°C"), "x_sensor", 5, {"measurement": 5.0}),
        (numeric("linkquality", "lqi"), "x_sensor", 90, {"measurement": 90.0}),
        (feature("enum", "status", 1, values=["a"]), "x_sensor", "a", {"value": "a"}),
        (feature("list", "alarms", 1), "x_sensor", [1, "ä"], {"value": '[1, "ä"]'}),
    ],
)
def test_a_sensor_has_a_type_and_our_unit(
    expose: dict[str, Any], service_type: str, value: object, expected: dict[str, Any]
) -> None:
    sensor = only(expose)
    assert sensor.part.service_type == service_type
    payload = json.dumps({expose["property"]: value}).encode()
    assert sensor.codec.read(TOPIC, payload, retained=False) == expected


def test_settings_are_sent_in_their_own_types() -> None:
    number = only(feature("numeric", "countdown", 3, unit="s", value_min=0, value_max=100))
    assert told(number, "number", 5.0) == {"countdown": 5}
    option = only(feature("enum", "mode", 7, values=["a", 1, True]))
    assert [told(option, "option", text) for text in ("a", "1", "true")] == [{"mode": "a"}, {"mode": 1}, {"mode": True}]
    text = only(feature("text", "name", 3))
    assert told(text, "text", "ä") == {"name": "ä"}
    assert said(text, name="b") == {"text": "b"}
    with pytest.raises(RefusedError, match="UTF-8"):
        text.codec.write("text", "\ud800")
    with pytest.raises(RefusedError, match="4096"):
        text.codec.write("text", "x" * 5_000)


def test_a_siren_is_not_readable() -> None:
    features = [
        feature("enum", "mode", 2, values=["stop", "burglar", "emergency"]),
        feature("enum", "level", 2, values=["low"]),
    ]
    siren = only(feature("composite", "warning", 2, features=features))
    assert siren.part.service_type == "siren"
    assert not any(one.readable for one in siren.part.capabilities)
    on = {"warning": {"mode": "emergency", "level": "medium", "duration": 10}}
    assert told(siren, "on_off", value=True) == on
    assert told(siren, "on_off", value=False) == {"warning": {"mode": "stop"}}
    assert told(siren, "siren_tone", "burglar")["warning"]["mode"] == "burglar"
    assert told(siren, "volume", 80.0)["warning"]["level"] == "very_high"


def test_a_device_with_firmware_reports_updates() -> None:
    _, update = built({"type": "switch", "features": [onoff()]}, supports_ota=True)
    assert said(update, update={"installed_version": 100, "latest_version": -1, "state": "available"}) == {
        "version": "100",
        "latest_version": None,
        "update_available": True,
        "running": False,
        "update_progress": None,
    }
    assert said(update, state="ON") == {}
    assert said(update, update={"state": "updating", "progress": 13.37, "remaining": 219})["update_progress"] == 13.37
    for state, available, runs in (("updating", True, True), ("scheduled", True, False), ("idle", False, False)):
        found = said(update, update={"state": state})
        assert (found["update_available"], found["running"], found["update_progress"]) == (available, runs, None)


def test_the_scenes_in_a_device_are_parts() -> None:
    """Zigbee2MQTT lists them with each endpoint, and announces each to Home Assistant."""
    sunset, night = {"id": 3, "name": "Sunset"}, {"id": 4, "name": "Night"}
    broken = [None, 5, {"id": True}, {"id": "6", "name": "x"}, {"name": "x"}]
    endpoints = {"1": {"scenes": [sunset, *broken]}, "2": {"scenes": [night, sunset]}, "3": {"scenes": None}, "4": 7}
    lamp, *scenes = built({"type": "light", "features": [onoff()]}, endpoints=endpoints)
    assert [(one.part.id, one.part.name, one.part.service_type) for one in scenes] == [
        ("scene_3", "Sunset", "x_scene"),
        ("scene_4", "Night", "x_scene"),
    ]
    assert lamp.part.service_type == "light"
    assert told(scenes[0], "scene", value=True) == {"scene_recall": 3}
    assert [one.readable for one in scenes[0].part.capabilities] == [False]


def test_a_transition_must_fit_the_radio() -> None:
    lamp = only({"type": "light", "features": [onoff()]})
    for seconds in (-1.0, 6_554.0, float("nan"), float("inf")):
        with pytest.raises(RefusedError, match="transition"):
            lamp.codec.write("on_off", value=True, transition=seconds)


def test_an_expose_without_access_is_left_out() -> None:
    (part,) = built(feature("numeric", "x", 0), feature("composite", "y", 2), {"type": "new"}, {"type": "binary"})
    assert part.part.service_type == "x_unknown"


def test_a_lamp_that_cannot_fade_gets_no_transition() -> None:
    """The bridge lists it among the options of the models that know it."""
    lamp = {"type": "light", "features": [onoff(), level()]}
    fades = only(lamp, options=[{"name": "transition"}])
    switches = only(lamp, options=[{"name": "state_action"}])
    assert told(fades, "on_off", True, 2.0) == {"state": "ON", "transition": 2}
    assert told(switches, "on_off", True, 2.0) == {"state": "ON"}
    assert told(switches, "level", 50.0, 2.0) == {"state": "ON", "brightness": 127}


def test_an_endpoint_that_the_bridge_has_no_name_for_is_named_in_the_topic() -> None:
    """It finds ``state_l2`` by the names of endpoints; ``occupied_heating_setpoint_3`` it does not find at all."""
    target = feature("numeric", "occupied_heating_setpoint", key="occupied_heating_setpoint_3")
    valve, relay, floor, code = built(
        {"type": "switch", "endpoint": "l2", "features": [onoff("_l2")]},
        {"type": "climate", "endpoint": "3", "features": [target]},
        feature("numeric", "floor_min", key="floor_min_3", endpoint="3"),
        feature("numeric", "code_1"),
        endpoints={"1": {}, "2": {"name": "l2"}, "3": {}, "4": {"name": []}, "5": 7},
    )
    assert relay.codec.write("on_off", True) == (Publication(f"{TOPIC}/set", b'{"state_l2":"ON"}'),)
    (setpoint,) = valve.codec.write("heating_setpoint", 20.0)
    assert setpoint == Publication(f"{TOPIC}/3/set", b'{"occupied_heating_setpoint":20}')
    assert valve.part.writes == (f"{TOPIC}/3/set",)
    assert valve.state_requests == (Publication(f"{TOPIC}/3/get", b'{"occupied_heating_setpoint":""}'),)
    assert said(valve, occupied_heating_setpoint_3=19.5) == {"heating_setpoint": 19.5}
    assert floor.codec.write("number", 5.0) == (Publication(f"{TOPIC}/3/set", b'{"floor_min":5}'),)
    assert code.codec.write("number", 5.0) == (Publication(f"{TOPIC}/set", b'{"code_1":5}'),)


def test_codes_and_passwords_are_never_read() -> None:
    """A Yale lock reports the PIN that was set last, an Ecolink keypad the one that was typed."""
    pin = feature("composite", "pin_code", features=[feature("numeric", "user"), feature("numeric", "pin_code")])
    parts = built(pin, feature("text", "last_used_pin_code", 1), feature("text", "action_code", 1), onoff())
    assert [one.part.id for one in parts] == ["state"]
    password = only(feature("text", "wifi_password"))
    assert said(password, wifi_password="secret") == {}
    assert [one.readable for one in password.part.capabilities] == [False]
    assert not password.state_requests
    assert told(password, "text", "other") == {"wifi_password": "other"}


def test_a_code_within_another_value_is_never_read() -> None:
    user = feature("composite", "keypad", 1, features=[feature("numeric", "user"), feature("text", "pin_code")])
    assert [one.part.id for one in built(user, onoff())] == ["state"]


def test_settings_of_several_endpoints_have_names_of_their_own() -> None:
    both = [
        feature("enum", "power_on_behavior", key=f"power_on_behavior_{end}", endpoint=end, label="Power-on behavior")
        for end in ("l1", "l2")
    ]
    named = feature("numeric", "power", 1, key="power_a", endpoint="a", label="Power a")
    assert [one.part.name for one in built(*both, named)] == ["Power-on behavior l1", "Power-on behavior l2", "Power a"]


@pytest.mark.parametrize(
    ("name", "service_type", "capability"),
    [
        ("water_leak_alarm_1", "water_leak_detector", "water_leak"),
        ("gas_alarm_2", "smoke_co_alarm", "gas"),
        ("smoke_alarm_1", "smoke_co_alarm", "smoke"),
        ("carbon_monoxide_alarm_1", "smoke_co_alarm", "carbon_monoxide_alarm"),
        ("contact_alarm_1", "contact_sensor", "contact"),
        ("occupancy_alarm_1", "occupancy_sensor", "occupancy"),
    ],
)
def test_each_alarm_of_a_detector_has_its_condition(name: str, service_type: str, capability: str) -> None:
    part = only(feature("binary", name, 1, value_on=True, value_off=False))
    assert part.part.service_type == service_type
    assert said(part, **{name: True}) == {capability: True}
    assert said(part, **{name: False}) == {capability: False}


def test_an_alarm_that_has_a_sound_is_a_siren() -> None:
    alarm = feature("binary", "alarm", 3, value_on=True, value_off=False)
    siren, melody = built(alarm, feature("enum", "melody", 3, values=["1", "2"]))
    assert (siren.part.service_type, siren.part.category) == ("siren", "")
    assert said(siren, alarm=True) == {"on_off": True}
    assert told(siren, "on_off", value=False) == {"alarm": False}
    assert melody.part.service_type == "x_setting"


def test_an_alarm_without_a_sound_is_a_setting() -> None:
    """That of an air monitor only says whether it is to warn."""
    assert only(feature("binary", "alarm", 3, value_on="ON", value_off="OFF")).part.service_type == "x_setting"


def test_a_single_action_is_a_push() -> None:
    """A feeder reports no meal before and after each: a wait for its ``START`` would feed again and again."""
    feeder = only(feature("enum", "feed", 3, values=["", "START"]))
    assert [(one.name, one.readable) for one in feeder.part.capabilities] == [("push", False)]
    assert told(feeder, "push", value=True) == {"feed": "START"}
    assert said(feeder, feed="") == {}


def test_a_pulse_that_moves_a_garage_door_is_pushed() -> None:
    """Told that it is off, the relay moves the door too: to turn it off is not the safe side."""
    trigger = feature("binary", "trigger", 3, value_on=True, value_off=False)
    opener, contact = built(trigger, feature("binary", "garage_door_contact", 1, value_on=False, value_off=True))
    assert (opener.part.service_type, contact.part.service_type) == ("closure", "contact_sensor")
    assert [one.name for one in opener.part.capabilities] == ["push"]
    assert told(opener, "push", value=True) == {"trigger": True}
    with pytest.raises(RefusedError):
        told(opener, "push", value=False)


def test_a_garage_door_without_pulse_has_a_movement() -> None:
    trigger = feature("binary", "trigger", 3, value_on=True, value_off=False)
    contact = feature("binary", "garage_door_contact", 1, value_on=True, value_off=False)
    opener, *_ = built(trigger, contact, feature("numeric", "run_time", 3, value_min=0, value_max=120))
    assert opener.part.service_type == "closure"
    assert said(opener, trigger=False, garage_door_contact=True) == {"movement": "closed"}
    assert said(opener, garage_door_contact=False) == {"movement": "open"}
    assert told(opener, "movement", "closed") == {"trigger": False}


@pytest.mark.parametrize(
    ("name", "opened", "closed"),
    [("gas_valve_state", "OPEN", "CLOSE"), ("valve_1", "ON", "OFF"), ("valve_2", "ON", "OFF")],
)
def test_a_valve_of_its_own_name_is_a_valve_and_no_setting(name: str, opened: str, closed: str) -> None:
    """The models SiHAS GCM-300Z and GIEX GX03 (zigbee-herdsman-converters)."""
    valve, timeout = built(
        feature("binary", name, value_on=opened, value_off=closed),
        feature("numeric", "close_timeout", value_min=1, value_max=540),
    )
    assert (valve.part.service_type, valve.part.category, timeout.part.service_type) == ("water_valve", "", "x_setting")
    messages: list[dict[str, Any]] = [{name: opened}, {name: closed}]
    assert [said(valve, **one) for one in messages] == [{"valve": "open"}, {"valve": "closed"}]
    assert told(valve, "valve", "closed") == {name: closed}


@pytest.mark.parametrize(
    ("description", "exposes"),
    [
        (
            "Zigbee smart water valve",
            (numeric("flow", "m³/h"), {"type": "switch", "features": [onoff()]}),
        ),  # Sonoff SWV
        ("Water irrigation valve", (onoff(),)),  # Giex QT06_1
    ],
)
def test_a_switch_of_a_valve_is_a_valve(description: str, exposes: tuple[dict[str, Any], ...]) -> None:
    """An app that turns on all switches must not flood a garden, and a valve asks first."""
    valve = built(*exposes, description=description)[0]
    assert valve.part.service_type == "water_valve"
    assert said(valve, state="ON") == {"valve": "open"}
    assert told(valve, "valve", "closed") == {"state": "OFF"}


@pytest.mark.parametrize("description", ["Smart water heater controller", "Radiator valve with thermostat"])
def test_a_heater_is_no_water_valve(description: str) -> None:
    relay = {"type": "switch", "features": [{**onoff(), "property": "window_detection"}]}
    climate = {"type": "climate", "features": [feature("numeric", "local_temperature", 1)]}
    types = {one.part.service_type for one in built(relay, climate, description=description)}
    assert "water_valve" not in types


def test_presses_of_a_remote_are_events() -> None:
    remote = only(feature("enum", "action", 1, category="diagnostic", values=["single", "double"]))
    assert (remote.part.service_type, remote.part.category) == ("generic_switch", "")
    assert said(remote, action="single") == {"press": "single"}
    assert said(remote, action="") == {}
    assert said(remote, action=None) == {}
    assert said(remote, retained=True, action="single") == {}
