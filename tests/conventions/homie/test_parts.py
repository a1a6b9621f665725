from collections.abc import Callable

import pytest

from homebot.conventions.description import DescribedPart
from homebot.devices.always_ask import is_declared
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
    "type": f"{CAP}shutter",
    "properties": {
        "position": PERCENT,
        "action": {"datatype": "enum", "format": "up,down,stop", "settable": True, "retained": False},
    },
}


def order(*words: str) -> dict[str, object]:
    return {"datatype": "enum", "format": ",".join(words), "settable": True, "retained": False}


def told(part: DescribedPart, capability: str, value: PlainValue) -> list[tuple[str, str]]:
    publications = part.codec.write(capability, value)
    assert not any(one.retain for one in publications)
    return [(one.topic.removeprefix("homie/5/thing/"), one.payload.decode()) for one in publications]


def read(part: DescribedPart, topic: str, payload: str, *, retained: bool = False) -> object:
    return dict(part.codec.read(f"homie/5/thing/{topic}", payload.encode(), retained=retained))


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


def test_a_lamp_without_switch_is_off_at_zero(introduce: Introduce) -> None:
    lamp = introduce({"level": {"properties": {"dim": {"datatype": "float", "format": "0:1:0.01", "settable": True}}}})
    part = lamp["level"]
    assert part.part.guessed
    assert told(part, "on_off", True) == [("level/dim/set", "1")]
    assert told(part, "level", 50.0) == [("level/dim/set", "0.5")]
    assert read(part, "level/dim", "0.5") == {"level": 50.0, "on_off": True}
    assert read(part, "level/dim", "0") == {"level": 0.0, "on_off": False}


def test_controls_come_first(introduce: Introduce) -> None:
    parts = introduce({"a": {"properties": {"t": {"datatype": "float", "unit": "°C"}}}, "b": SWITCH})
    assert list(parts) == ["b", "a/t"]


def test_a_declared_type_is_used(introduce: Introduce) -> None:
    assert introduce({"switch": SWITCH}, type="hc-smarthome/v2/dc/light")["switch"].part.service_type == "light"


def test_an_outlet_is_a_plug(introduce: Introduce) -> None:
    assert introduce({"switch": SWITCH}, type="hc-smarthome/v2/dc/outlet")["switch"].part.service_type == "plug"


def test_a_shutter_takes_movements_and_positions(introduce: Introduce) -> None:
    shutter = introduce({"shutter": SHUTTER})["shutter"]
    assert shutter.part.service_type == "window_covering"
    assert told(shutter, "movement", "open") == [("shutter/action/set", "up")]
    assert told(shutter, "movement", "closed") == [("shutter/action/set", "down")]
    assert told(shutter, "movement", "stopped") == [("shutter/action/set", "stop")]
    assert told(shutter, "position", 30.0) == [("shutter/position/set", "30")]
    assert read(shutter, "shutter/position", "30") == {"position": 30.0}
    assert read(shutter, "shutter/position", "130") == {}


def test_a_shutter_without_words_is_moved_by_its_position(introduce: Introduce) -> None:
    shutter = introduce({"blind": {"properties": {"position": PERCENT}}})["blind"]
    assert shutter.part.guessed
    assert told(shutter, "movement", "open") == [("blind/position/set", "100")]
    with pytest.raises(RefusedError):
        shutter.codec.write("movement", "stopped")


def test_a_garage_door_is_a_closure(introduce: Introduce) -> None:
    properties = {
        "state": {"datatype": "enum", "format": "open,closed,opening,closing,stopped"},
        "action": order("open", "close", "trigger", "stop"),
    }
    door = introduce({"garage-door": {"type": f"{CAP}garage-door", "properties": properties}})["garage-door"]
    assert (door.part.service_type, door.part.tag) == ("closure", "garage")
    assert read(door, "garage-door/state", "opening") == {"movement": "opening"}
    assert told(door, "movement", "closed") == [("garage-door/action/set", "close")]


def test_a_garage_door_that_takes_other_words_has_another_digest(introduce: Introduce) -> None:
    def door(words: str) -> DescribedPart:
        properties = {"action": order(*words.split(","))}
        return introduce({"garage-door": {"type": f"{CAP}garage-door", "properties": properties}})["garage-door"]

    first, other, again = door("up,down"), door("open,down"), door("up,down")
    assert told(first, "movement", "open") == [("garage-door/action/set", "up")]
    assert told(other, "movement", "open") == [("garage-door/action/set", "open")]
    assert first.part.payloads == again.part.payloads != other.part.payloads


def test_a_lock_is_locked_where_it_is_true(introduce: Introduce) -> None:
    lock = introduce({"lock": {"type": f"{CAP}lock", "properties": {"state": FLAG}}})["lock"]
    assert lock.part.service_type == "door_lock"
    assert read(lock, "lock/state", "true") == {"lock": "locked"}
    assert told(lock, "lock", "unlocked") == [("lock/state/set", "false")]
    with pytest.raises(RefusedError):
        lock.codec.write("lock", "open")


def test_a_lock_with_orders_draws_its_latch(introduce: Introduce) -> None:
    properties = {"state": WATCHED, "action": order("lock", "unlock", "open")}
    lock = introduce({"lock": {"type": f"{CAP}lock", "properties": properties}})["lock"]
    assert told(lock, "lock", "locked") == [("lock/action/set", "lock")]
    assert told(lock, "lock", "open") == [("lock/action/set", "open")]


def states(*words: str, settable: bool = False) -> dict[str, object]:
    return {"datatype": "enum", "format": ",".join(words), "settable": settable}


@pytest.mark.parametrize(
    ("properties", "locked", "command"),
    [
        ({"state": states("locked", "unlocked", settable=True)}, "locked", ("state/set", "unlocked")),
        ({"state": states("LOCKED", "UNLOCKED", settable=True)}, "LOCKED", ("state/set", "UNLOCKED")),
        (
            {"state": states("locked", "unlocked", "jammed"), "action": order("lock", "unlock")},
            "locked",
            ("action/set", "unlock"),
        ),
    ],
)
def test_a_lock_of_words_is_a_lock_and_no_setting(
    introduce: Introduce, properties: dict[str, object], locked: str, command: tuple[str, str]
) -> None:
    parts = introduce({"bolt": {"type": "lock", "properties": properties}})
    assert {name: one.part.service_type for name, one in parts.items()} == {"bolt": "door_lock"}
    assert read(parts["bolt"], "bolt/state", locked) == {"lock": "locked"}
    assert told(parts["bolt"], "lock", "unlocked") == [(f"bolt/{command[0]}", command[1])]


def test_an_alarm_is_an_alarm_panel_and_no_setting(introduce: Introduce) -> None:
    properties = {"state": states("disarmed", "armed_home", "armed_away", settable=True)}
    (part,) = introduce({"panel": {"type": "alarm", "name": "Alarm panel", "properties": properties}}).values()
    assert part.part.service_type == "x_alarm_panel"
    assert read(part, "panel/state", "armed_away") == {"alarm": "armed_away"}
    assert told(part, "alarm", "disarmed") == [("panel/state/set", "disarmed")]
    with pytest.raises(RefusedError):
        part.codec.write("alarm", "triggered")


def test_a_switch_beside_an_alarm_stays_one(introduce: Introduce) -> None:
    parts = introduce({"panel": {"properties": {"on": FLAG, "mode": states("disarmed", "armed", settable=True)}}})
    assert {name: one.part.service_type for name, one in parts.items()} == {
        "panel/$alarm": "x_alarm_panel",
        "panel": "switch",
    }


def test_the_state_of_an_alarm_is_not_what_it_was_told(introduce: Introduce) -> None:
    properties = {
        "target": states("disarmed", "armed_away", settable=True),
        "state": states("disarmed", "armed_away", "triggered"),
    }
    (part,) = introduce({"panel": {"type": "alarm", "properties": properties}}).values()
    assert part.part.reads == ("homie/5/thing/panel/state",)
    assert read(part, "panel/state", "triggered") == {"alarm": "triggered"}
    assert told(part, "alarm", "armed_away") == [("panel/target/set", "armed_away")]


def test_a_valve_is_open_where_it_is_true(introduce: Introduce) -> None:
    valve = introduce({"valve": {"type": f"{CAP}valve", "properties": {"state": FLAG}}})["valve"]
    assert valve.part.service_type == "water_valve"
    assert read(valve, "valve/state", "true") == {"valve": "open"}
    assert told(valve, "valve", "closed") == [("valve/state/set", "false")]


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
        ("batterystate", "%", "x_battery", "90", {"battery": 90.0}),
        ("a", "kPa", "pressure_sensor", "101", {"pressure": 1010.0}),
        ("co2", "ppm", "air_quality_sensor", "400", {"carbon_dioxide": 400.0}),
        ("a", "%", "x_sensor", "7", {"measurement": 7.0}),
        ("a", "bananas", "x_sensor", "7", {"measurement": 7.0}),
    ],
)
def test_a_number_is_known_by_its_unit_and_name(
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


def test_a_fan_takes_its_speed_as_an_option(introduce: Introduce) -> None:
    speed = {"datatype": "enum", "format": "OFF,LOW,HIGH", "settable": True}
    fan = introduce({"speed": {"properties": {"speed": speed}}}, name="Ceiling fan")["speed"]
    assert (fan.part.service_type, fan.part.guessed) == ("fan", True)
    assert told(fan, "fan_mode", "low") == [("speed/speed/set", "LOW")]


@pytest.mark.parametrize(
    ("node", "prop", "service_type", "capability"),
    [
        ("relay", {"power": FLAG}, "switch", "on_off"),
        ("socket", {"power": FLAG}, "plug", "on_off"),
        ("lamp", {"on": FLAG}, "light", "on_off"),
        ("front-lock", {"state": FLAG}, "door_lock", "lock"),
        ("garden-valve", {"state": FLAG}, "water_valve", "valve"),
        ("heater", {"target-temperature": {"datatype": "float", "settable": True}}, "thermostat", "heating_setpoint"),
        ("blind", {"tilt": PERCENT}, "window_covering", "tilt"),
        ("garage", {"state": {"datatype": "enum", "format": "open,closed"}}, "closure", "movement"),
        ("front-gate", {"move": {"datatype": "enum", "format": "OPEN,CLOSE", "settable": True}}, "closure", "movement"),
        ("bell", {"button": WATCHED}, "generic_switch", "press"),
        ("hall", {"motion": WATCHED}, "occupancy_sensor", "occupancy"),
        ("hall", {"ct": {"datatype": "integer", "unit": "K", "settable": True}}, "light", "color_temperature"),
    ],
)
def test_without_a_type_words_and_forms_determine_the_kind(
    introduce: Introduce, node: str, prop: object, service_type: str, capability: str
) -> None:
    (part,) = introduce({node: {"properties": prop}}).values()
    assert (part.part.service_type, part.part.guessed) == (service_type, True)
    assert capability in {one.name for one in part.part.capabilities}


@pytest.mark.parametrize("kind", [f"{CAP}fan", ""])
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


def test_a_fan_with_a_switch_is_switched_by_that(introduce: Introduce) -> None:
    fan = introduce({"fan": {"type": f"{CAP}fan", "properties": {"state": FLAG, "speed": PERCENT}}})["fan"]
    assert told(fan, "on_off", False) == [("fan/state/set", "false")]
    assert read(fan, "fan/speed", "30") == {"fan_speed": 30.0}


@pytest.mark.parametrize(
    ("node", "name", "options", "capability", "topic_value", "expected", "sent"),
    [
        ("relay", "state", "ON,OFF", "on_off", "ON", True, "OFF"),
        ("circuit", "relay", "UNKNOWN,OPEN,CLOSED", "on_off", "CLOSED", True, "OPEN"),
        ("lawn", "valve", "OPEN,CLOSED", "valve", "CLOSED", "closed", "OPEN"),
    ],
)
def test_an_enum_of_two_opposites_is_a_boolean(
    introduce: Introduce,
    node: str,
    name: str,
    options: str,
    capability: str,
    topic_value: str,
    expected: object,
    sent: str,
) -> None:
    part = introduce({node: {"properties": {name: {"datatype": "enum", "format": options, "settable": True}}}})[node]
    assert read(part, f"{node}/{name}", topic_value) == {capability: expected}
    assert told(part, capability, "open" if capability == "valve" else False) == [(f"{node}/{name}/set", sent)]
    assert read(part, f"{node}/{name}", "UNKNOWN") == {}


def test_the_relay_of_a_breaker_always_asks(introduce: Introduce) -> None:
    relay = {"datatype": "enum", "format": "UNKNOWN,OPEN,CLOSED", "settable": True}
    part = introduce({"switch": {"properties": {"relay": relay}}})["switch"].part
    assert is_declared(DevicePart(id=part.id, part=part, routes=()))
