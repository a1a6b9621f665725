from collections.abc import Callable
from typing import Any

import pytest
from tests.devices.handles.conftest import device

from homebot.conventions.description import DescribedPart
from homebot.devices.always_ask import always_asks, is_declared
from homebot.devices.device import DevicePart
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

Introduce = Callable[..., dict[str, DescribedPart]]

CAP = "hc-smarthome/v2/cap/"
FLAG = {"datatype": "boolean", "settable": True}
WATCHED = {"datatype": "boolean"}
PERCENT = {"datatype": "integer", "format": "0:100", "unit": "%", "settable": True}
SWITCH = {"type": f"{CAP}switch", "properties": {"state": FLAG}}
LEVEL = {"type": f"{CAP}level", "properties": {"value": PERCENT}}
COLOR = {
    "type": f"{CAP}color",
    "properties": {
        "color": {"datatype": "color", "format": "rgb,hsv", "settable": True},
        "color-temperature": {"datatype": "integer", "format": "153:500", "unit": "MK⁻¹", "settable": True},
    },
}
SHUTTER = {
    "position": PERCENT,
    "action": {"datatype": "enum", "format": "up,down,stop", "settable": True, "retained": False},
}


def order(*words: str) -> dict[str, object]:
    return {"datatype": "enum", "format": ",".join(words), "settable": True, "retained": False}


def states(words: str, *, settable: bool = False) -> dict[str, object]:
    return {"datatype": "enum", "format": words, "settable": settable}


def told(part: DescribedPart, capability: str, value: PlainValue) -> list[tuple[str, str]]:
    publications = part.codec.write(capability, value)
    assert not any(one.retain for one in publications)
    return [(one.topic.removeprefix("homie/5/thing/"), one.payload.decode()) for one in publications]


def read(part: DescribedPart, topic: str, payload: str, *, retained: bool = False) -> object:
    return dict(part.codec.read(f"homie/5/thing/{topic}", payload.encode(), retained=retained))


THINGS: dict[str, tuple[str, str, dict[str, Any], str, dict[str, object], dict[tuple[str, PlainValue], str | None]]] = {
    "a lamp without switch is off at zero": (
        "level", "dimmer", {"dim": {"datatype": "float", "format": "0:1:0.01", "settable": True}}, "light",
        {"dim 0.5": {"level": 50.0, "on_off": True}, "dim 0": {"level": 0.0, "on_off": False}},
        {("on_off", True): "dim 1", ("level", 50.0): "dim 0.5"},
    ),
    "a shutter takes movements and positions": (
        "shutter", f"{CAP}shutter", SHUTTER, "window_covering",
        {"position 30": {"position": 30.0}, "position 130": {}},
        {("movement", "open"): "action up", ("movement", "closed"): "action down",
         ("movement", "stopped"): "action stop", ("position", 30.0): "position 30"},
    ),
    "a shutter without words is moved by its position": (
        "blind", "shutter", {"position": PERCENT}, "window_covering", {},
        {("movement", "open"): "position 100", ("movement", "stopped"): None},
    ),
    "a garage door is a closure": (
        "garage-door", f"{CAP}garage-door",
        {"state": states("open,closed,opening,closing,stopped"), "action": order("open", "close", "trigger", "stop")},
        "closure", {"state opening": {"movement": "opening"}}, {("movement", "closed"): "action close"},
    ),
    "a lock is locked where it is true": (
        "lock", f"{CAP}lock", {"state": FLAG}, "door_lock", {"state true": {"lock": "locked"}},
        {("lock", "unlocked"): "state false", ("lock", "open"): None},
    ),
    "a lock with orders draws its latch": (
        "lock", f"{CAP}lock", {"state": WATCHED, "action": order("lock", "unlock", "open")}, "door_lock", {},
        {("lock", "locked"): "action lock", ("lock", "open"): "action open"},
    ),
    "a lock of words is no setting": (
        "bolt", "lock", {"state": states("locked,unlocked", settable=True)}, "door_lock",
        {"state locked": {"lock": "locked"}}, {("lock", "unlocked"): "state unlocked"},
    ),
    "a lock of capital words": (
        "bolt", "lock", {"state": states("LOCKED,UNLOCKED", settable=True)}, "door_lock",
        {"state LOCKED": {"lock": "locked"}}, {("lock", "unlocked"): "state UNLOCKED"},
    ),
    "a lock of words with orders": (
        "bolt", "lock", {"state": states("locked,unlocked,jammed"), "action": order("lock", "unlock")}, "door_lock",
        {"state locked": {"lock": "locked"}}, {("lock", "unlocked"): "action unlock"},
    ),
    "an alarm is an alarm panel and no setting": (
        "panel", "alarm", {"state": states("disarmed,armed_home,armed_away", settable=True)}, "x_alarm_panel",
        {"state armed_away": {"alarm": "armed_away"}},
        {("alarm", "disarmed"): "state disarmed", ("alarm", "triggered"): None},
    ),
    "the state of an alarm is not what it was told": (
        "panel", "alarm",
        {"target": states("disarmed,armed_away", settable=True), "state": states("disarmed,armed_away,triggered")},
        "x_alarm_panel", {"state triggered": {"alarm": "triggered"}, "target armed_away": {}},
        {("alarm", "armed_away"): "target armed_away"},
    ),
    "a valve is open where it is true": (
        "valve", f"{CAP}valve", {"state": FLAG}, "water_valve", {"state true": {"valve": "open"}},
        {("valve", "closed"): "state false"},
    ),
    "a fan takes its speed as an option": (
        "fan", "fan", {"speed": states("OFF,LOW,HIGH", settable=True)}, "fan", {}, {("fan_mode", "low"): "speed LOW"},
    ),
    "a fan with a switch is switched by that": (
        "fan", f"{CAP}fan", {"state": FLAG, "speed": PERCENT}, "fan", {"speed 30": {"fan_speed": 30.0}},
        {("on_off", False): "state false"},
    ),
    "an enum of on and off is a boolean": (
        "relay", "switch", {"state": states("ON,OFF", settable=True)}, "switch",
        {"state ON": {"on_off": True}, "state UNKNOWN": {}}, {("on_off", False): "state OFF"},
    ),
    "a relay is on where it is closed": (
        "circuit", "", {"relay": states("UNKNOWN,OPEN,CLOSED", settable=True)}, "switch",
        {"relay CLOSED": {"on_off": True}, "relay UNKNOWN": {}}, {("on_off", False): "relay OPEN"},
    ),
    "a valve of words is closed where it is closed": (
        "lawn", "", {"valve": states("OPEN,CLOSED", settable=True)}, "water_valve",
        {"valve CLOSED": {"valve": "closed"}, "valve UNKNOWN": {}}, {("valve", "open"): "valve OPEN"},
    ),
}  # fmt: skip


@pytest.mark.parametrize(("node", "kind", "properties", "service_type", "heard", "orders"), THINGS.values(), ids=THINGS)
def test_a_node_is_one_part_that_is_read_and_told(
    introduce: Introduce,
    node: str,
    kind: str,
    properties: dict[str, Any],
    service_type: str,
    heard: dict[str, object],
    orders: dict[tuple[str, PlainValue], str | None],
) -> None:
    (part,) = introduce({node: {"type": kind, "properties": properties}}).values()
    assert (part.part.service_type, part.part.guessed) == (service_type, not kind.startswith(CAP))
    for message, readings in heard.items():
        prop, payload = message.split()
        assert read(part, f"{node}/{prop}", payload) == readings
    for (capability, value), sent in orders.items():
        if sent is None:
            with pytest.raises(RefusedError):
                part.codec.write(capability, value)
        else:
            prop, payload = sent.split()
            assert told(part, capability, value) == [(f"{node}/{prop}/set", payload)]


def test_nodes_of_a_lamp_are_one_part(introduce: Introduce) -> None:
    parts = introduce({"switch": SWITCH, "level": LEVEL, "color": COLOR})
    assert list(parts) == ["switch"]
    lamp = parts["switch"]
    assert lamp.part.service_type == "light"
    assert not lamp.part.guessed
    assert told(lamp, "on_off", False) == [("switch/state/set", "false")]
    assert told(lamp, "level", 40.0) == [("level/value/set", "40"), ("switch/state/set", "true")]
    assert told(lamp, "level", 0.0) == [("switch/state/set", "false")]
    assert told(lamp, "color", (300.0, 50.0)) == [("color/color/set", "hsv,300,50,100"), ("switch/state/set", "true")]
    assert told(lamp, "color_temperature", 4000.0)[0] == ("color/color-temperature/set", "250")
    assert read(lamp, "level/value", "40") == {"level": 40.0}
    assert read(lamp, "color/color", "rgb,255,128,0") == {"color": (30.118, 100.0)}
    assert read(lamp, "color/color-temperature", "250") == {"color_temperature": 4000.0}
    with pytest.raises(RefusedError):
        lamp.codec.write("color_temperature", 1500.0)


def test_two_switches_and_two_levels_stay_apart(introduce: Introduce) -> None:
    parts = introduce({"switch-1": SWITCH, "switch-2": SWITCH, "level-1": LEVEL, "level-2": LEVEL})
    assert {name: part.part.service_type for name, part in parts.items()} == {
        "switch-1": "switch",
        "switch-2": "switch",
        "level-1": "light",
        "level-2": "light",
    }


def test_controls_come_first(introduce: Introduce) -> None:
    parts = introduce({"a": {"properties": {"t": {"datatype": "float", "unit": "°C"}}}, "b": SWITCH})
    assert list(parts) == ["b", "a/t"]


def test_a_declared_type_is_used(introduce: Introduce) -> None:
    assert introduce({"switch": SWITCH}, type="hc-smarthome/v2/dc/light")["switch"].part.service_type == "light"


def test_an_outlet_is_a_plug(introduce: Introduce) -> None:
    assert introduce({"switch": SWITCH}, type="hc-smarthome/v2/dc/outlet")["switch"].part.service_type == "plug"


def test_a_garage_door_that_takes_other_words_has_another_digest(introduce: Introduce) -> None:
    def door(words: str) -> DescribedPart:
        properties = {"action": order(*words.split(","))}
        return introduce({"garage-door": {"type": f"{CAP}garage-door", "properties": properties}})["garage-door"]

    first, other, again = door("up,down"), door("open,down"), door("up,down")
    assert told(first, "movement", "open") == [("garage-door/action/set", "up")]
    assert told(other, "movement", "open") == [("garage-door/action/set", "open")]
    assert first.part.tag == "garage"
    assert first.part.payloads == again.part.payloads != other.part.payloads


def test_a_switch_beside_an_alarm_stays_one(introduce: Introduce) -> None:
    parts = introduce({"panel": {"properties": {"on": FLAG, "mode": states("disarmed,armed", settable=True)}}})
    assert {name: one.part.service_type for name, one in parts.items()} == {
        "panel/$alarm": "x_alarm_panel",
        "panel": "switch",
    }


def test_a_thermostat_is_in_celsius_for_any_unit(introduce: Introduce) -> None:
    properties = {
        "set-temperature": {"datatype": "float", "format": "50:86", "unit": "°F", "settable": True},
        "mode": {"datatype": "enum", "format": "Off,Heat", "settable": True},
    }
    thermostat = introduce({"t": {"type": f"{CAP}thermostat", "properties": properties}})["t"]
    assert thermostat.part.service_type == "thermostat"
    assert told(thermostat, "heating_setpoint", 20.0) == [("t/set-temperature/set", "68")]
    assert told(thermostat, "thermostat_mode", "heat") == [("t/mode/set", "Heat")]
    assert read(thermostat, "t/set-temperature", "68") == {"heating_setpoint": 20.0}
    assert read(thermostat, "t/mode", "Off") == {"thermostat_mode": "off"}
    assert thermostat.part.capabilities[0].bounds == (10.0, 30.0)


@pytest.mark.parametrize(
    ("kind", "service_type", "capability"),
    [
        ("motion", "occupancy_sensor", "occupancy"),
        ("contact", "contact_sensor", "contact"),
        ("water", "water_leak_detector", "water_leak"),
        ("smoke", "smoke_co_alarm", "smoke"),
        ("co", "smoke_co_alarm", "carbon_monoxide_alarm"),
        ("vibration", "x_binary_sensor", "vibration"),
    ],
)
def test_a_sensor_of_a_known_kind(introduce: Introduce, kind: str, service_type: str, capability: str) -> None:
    sensor = introduce({"s": {"type": f"{CAP}{kind}", "properties": {"anything": WATCHED}}})["s/anything"]
    assert (sensor.part.service_type, sensor.part.guessed) == (service_type, False)
    assert read(sensor, "s/anything", "true") == {capability: True}


@pytest.mark.parametrize(
    ("name", "unit", "service_type", "payload", "expected"),
    [
        ("a", "°C", "temperature_sensor", "21.5", {"temperature": 21.5}),
        ("a", "°F", "temperature_sensor", "68", {"temperature": 20.0}),
        ("humidity", "%", "humidity_sensor", "45", {"humidity": 45.0}),
        ("battery", "%", "x_battery", "90", {"battery": 90.0}),
        ("a", "kPa", "pressure_sensor", "101", {"pressure": 1010.0}),
        ("co2", "ppm", "x_sensor", "400", {"measurement": 400.0}),
        ("a", "%", "x_sensor", "7", {"measurement": 7.0}),
        ("a", "bananas", "x_sensor", "7", {"measurement": 7.0}),
    ],
)
def test_a_number_is_known_by_its_unit(
    introduce: Introduce, name: str, unit: str, service_type: str, payload: str, expected: object
) -> None:
    sensor = introduce({"n": {"properties": {name: {"datatype": "float", "unit": unit}}}})[f"n/{name}"]
    assert sensor.part.service_type == service_type
    assert read(sensor, f"n/{name}", payload) == expected


def test_electrical_measurements_are_one_part(introduce: Introduce) -> None:
    properties = {"power": {"datatype": "float", "unit": "kW"}, "energy": {"datatype": "float", "unit": "Wh"}}
    meter = introduce({"m": {"type": f"{CAP}powermeter", "properties": properties}})["m/$meter"]
    assert meter.part.service_type == "electrical_meter"
    assert read(meter, "m/power", "0.5") == {"power": 500.0}
    assert read(meter, "m/energy", "1500") == {"energy": 1.5}


@pytest.mark.parametrize(
    ("device_type", "expected"),
    [
        ("energy.ebus.device.circuit", [{"power": 420.0}, {"energy_returned": 0.5}, {"energy": 12.345}]),
        ("energy.ebus.device.lugs", [{"power": -420.0}, {"energy": 0.5}, {"energy_returned": 12.345}]),
    ],
)
def test_a_circuit_of_a_panel_is_measured_the_other_way(
    introduce: Introduce, device_type: str, expected: list[object]
) -> None:
    """Source: eBus, as SPAN panels publish it: what a circuit consumes leaves the panel, and is negative there."""
    names = {"active-power": "W", "imported-energy": "Wh", "exported-energy": "Wh"}
    properties = {name: {"datatype": "float", "unit": unit} for name, unit in names.items()}
    meter = introduce({"meter": {"properties": properties}}, type=device_type)["meter/$meter"]
    payloads = zip(names, ("-420.0", "500", "12345"), strict=True)
    assert [read(meter, f"meter/{name}", payload) for name, payload in payloads] == expected


def test_the_facts_about_a_device_are_diagnostic(introduce: Introduce) -> None:
    properties = {"model": {"datatype": "string"}, "nominal-power": {"datatype": "float", "unit": "W"}}
    parts = introduce({"info": {"properties": properties}}, type="energy.ebus.device.pv")
    assert [(one.part.category, one.part.capabilities[0].name) for one in parts.values()] == [
        ("diagnostic", "value"),
        ("diagnostic", "measurement"),
    ]


def test_the_maintenance_of_a_device_is_diagnostic(introduce: Introduce) -> None:
    """When a device was last heard was shown beside the temperature, as what it measures."""
    properties = {"last-update": {"datatype": "datetime"}, "reachable": {"datatype": "boolean"}}
    parts = introduce({"m": {"type": f"{CAP}maintenance", "properties": properties}})
    assert {one.part.category for one in parts.values()} == {"diagnostic"}


def test_a_press_is_none_when_it_was_kept(introduce: Introduce) -> None:
    action = {"datatype": "enum", "format": "press,long-press", "retained": False}
    button = introduce({"b": {"type": f"{CAP}button", "properties": {"action": action}}})["b/action"]
    assert button.part.service_type == "generic_switch"
    assert read(button, "b/action", "long-press") == {"press": "long-press"}
    assert read(button, "b/action", "long-press", retained=True) == {}


def test_other_settable_values_are_settings(introduce: Introduce) -> None:
    properties = {
        "offset": {"datatype": "integer", "format": "-10:10:2", "settable": True},
        "mode": {"datatype": "enum", "format": "a,b", "settable": True},
        "text": {"datatype": "string", "settable": True},
        "toggle": order("toggle"),
    }
    parts = introduce({"n": {"properties": properties}})
    assert {name: part.part.category for name, part in parts.items()} == dict.fromkeys(
        ("n/offset", "n/mode", "n/text"), "config"
    )
    assert told(parts["n/offset"], "number", -4.0) == [("n/offset/set", "-4")]
    assert told(parts["n/mode"], "option", "b") == [("n/mode/set", "b")]
    assert told(parts["n/text"], "text", "hello") == [("n/text/set", "hello")]


def test_a_vacuum_cleaner_is_known_by_its_words(introduce: Introduce) -> None:
    nodes = {
        "status": {"properties": {"status": {"datatype": "enum", "format": "docked,cleaning,moving"}}},
        "basic": {"properties": {"operation": order("START", "STOP", "PAUSE", "HOME")}},
    }
    cleaner = introduce(nodes)["basic"]
    assert cleaner.part.service_type == "robotic_vacuum_cleaner"
    assert read(cleaner, "status/status", "moving") == {"vacuum": "cleaning"}
    assert told(cleaner, "vacuum", "returning") == [("basic/operation/set", "HOME")]


@pytest.mark.parametrize(
    ("kind", "prop", "service_type", "capability"),
    [
        ("switch", {"power": FLAG}, "switch", "on_off"),
        ("Light", {"on": FLAG}, "light", "on_off"),
        ("lock", {"bolt": FLAG}, "door_lock", "lock"),
        ("valve", {"state": FLAG}, "water_valve", "valve"),
        ("thermostat", {"target": {"datatype": "float", "settable": True}}, "thermostat", "heating_setpoint"),
        (
            "shutter",
            {"drive": {"datatype": "enum", "format": "OPEN,CLOSE", "settable": True}},
            "window_covering",
            "movement",
        ),
        ("garage-door", {"state": {"datatype": "enum", "format": "open,closed"}}, "closure", "movement"),
        ("", {"power": FLAG}, "switch", "on_off"),
        ("", {"ct": {"datatype": "integer", "unit": "K", "settable": True}}, "light", "color_temperature"),
        ("", {"bolt": states("lock,unlock", settable=True)}, "door_lock", "lock"),
    ],
)
def test_the_word_of_a_type_and_the_form_of_a_property_determine_the_kind(
    introduce: Introduce, kind: str, prop: object, service_type: str, capability: str
) -> None:
    (part,) = introduce({"thing": {"type": kind, "properties": prop}}).values()
    assert (part.part.service_type, part.part.guessed) == (service_type, True)
    assert capability in {one.name for one in part.part.capabilities}


def test_the_word_of_a_sensor_is_its_condition(introduce: Introduce) -> None:
    """Source: Homie4 0.4 (PyPI), Device_Contact."""
    (part,) = introduce({"door": {"type": "contact", "properties": {"contact": WATCHED}}}).values()
    assert (part.part.service_type, [one.name for one in part.part.capabilities]) == ("contact_sensor", ["contact"])


@pytest.mark.parametrize("name", ["light", "relay", "thermostat", "fan"])
def test_names_and_ids_determine_nothing(introduce: Introduce, name: str) -> None:
    parts = introduce({name: {"name": name, "properties": {name: FLAG, "power": FLAG}}})
    assert {one.part.service_type for one in parts.values()} == {"x_setting"}


@pytest.mark.parametrize("name", ["front-lock", "garage-door", "valve"])
def test_what_may_open_the_house_by_its_name_asks(introduce: Introduce, name: str) -> None:
    (part,) = introduce({name: {"name": name, "properties": {"state": FLAG}}}).values()
    own = DevicePart(id=part.part.id, part=part.part, routes=())
    assert always_asks(device("panel", own), own)


@pytest.mark.parametrize("kind", [f"{CAP}fan", "fan"])
@pytest.mark.parametrize(
    ("form", "unit", "spoken", "half"),
    [("0:100", "%", "50", "50"), ("0:4", "", "2", "2"), ("0:1:0.1", "", "0.5", "0.5")],
)
def test_a_fan_takes_its_speed_as_a_number(
    introduce: Introduce, kind: str, form: str, unit: str, spoken: str, half: str
) -> None:
    datatype = "float" if "." in form else "integer"
    speed = {"datatype": datatype, "format": form, "unit": unit, "settable": True}
    fan = introduce({"fan": {"type": kind, "properties": {"speed": speed}}})["fan"]
    assert fan.part.service_type == "fan"
    assert read(fan, "fan/speed", spoken) == {"fan_speed": 50.0, "on_off": True}
    assert read(fan, "fan/speed", "0") == {"fan_speed": 0.0, "on_off": False}
    assert told(fan, "fan_speed", 50.0) == [("fan/speed/set", half)]
    assert told(fan, "on_off", False) == [("fan/speed/set", "0")]


def test_a_fan_of_steps_from_one_has_a_speed(introduce: Introduce) -> None:
    """And no step at which it is off."""
    speed = {"datatype": "integer", "format": "1:5", "settable": True}
    fan = introduce({"fan": {"type": "fan", "properties": {"on": FLAG, "speed": speed}}})["fan"]
    assert read(fan, "fan/speed", "3") == {"fan_speed": 60.0}
    assert told(fan, "fan_speed", 60.0) == [("fan/speed/set", "3")]
    lone = introduce({"fan": {"type": "fan", "properties": {"speed": speed}}})["fan"]
    assert {one.name for one in lone.part.capabilities} == {"fan_speed"}


def test_the_relay_of_a_breaker_always_asks(introduce: Introduce) -> None:
    relay = {"datatype": "enum", "format": "UNKNOWN,OPEN,CLOSED", "settable": True}
    part = introduce({"switch": {"properties": {"relay": relay}}})["switch"].part
    assert is_declared(DevicePart(id=part.id, part=part, routes=()))
