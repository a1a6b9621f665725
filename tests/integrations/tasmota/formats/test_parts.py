"""What a device has becomes parts that read and tell the right topics."""

import json
from typing import Any

import pytest
from tests.integrations.announced_parts import heard

from homebot.conventions.description import AutoExpiry, DescribedPart, Publication
from homebot.conventions.lamp import LightCommand
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.tasmota.formats.config import read_config
from homebot.integrations.tasmota.formats.light import LampState, speed_for
from homebot.integrations.tasmota.formats.reader import build_parts, count_shutters
from homebot.integrations.tasmota.formats.sensors import MAX_SENSORS, read_leaves

MAC = "2462AB000011"


def built(sensors: dict[str, Any] | None = None, *, fan: int = 0, **more: Any) -> dict[str, DescribedPart]:
    fields = {
        "ver": 1,
        "mac": MAC,
        "dn": "D",
        "ft": "%prefix%/",
        "tp": ["c", "s", "t"],
        "rl": [],
        "lk": 1,
        "if": fan,
        **more,
    }
    config = read_config(MAC, json.dumps(fields).encode())
    leaves = read_leaves({"ver": 1, "sn": sensors or {}}, {})
    return {one.part.id: one for one in build_parts(config, leaves) if one.part.id != "wifi"}


def only(**more: Any) -> DescribedPart:
    (part,) = built(**more).values()
    return part


def told(part: DescribedPart, capability: str, value: PlainValue, transition: float = 0.0) -> tuple[str, str]:
    (publication,) = part.codec.write(capability, value, transition=transition)
    return publication.topic, publication.payload.decode()


THINGS: dict[str, tuple[dict[str, Any], str, str, list[tuple[str, Any, object]]]] = {
    "the first relay may go without its number": (
        {"rl": [1, 1], "fn": ["D", "Heater"]}, "power_1", "switch", [("s/RESULT", {"POWER": "ON"}, {"on_off": True})],
    ),
    "other relays have numbers and names": (
        {"rl": [1, 1], "fn": ["D", "Heater"]}, "power_2", "switch Heater",
        [("s/RESULT", {"POWER": "ON"}, {}), ("t/STATE", {"POWER1": "ON", "POWER2": "OFF"}, {"on_off": False}),
         ("on_off", True, "c/Power2 ON")],
    ),
    "a device has words of its own": (
        {"rl": [1], "state": ["Aus", "An", "Um", "Halt"]}, "power_1", "switch",
        [("s/RESULT", {"POWER": "An"}, {"on_off": True}), ("s/RESULT", {"POWER": "ON"}, {}),
         ("on_off", False, "c/Power1 Aus")],
    ),
    "a dimmer is off at no level alone": (
        {"rl": [2], "lt_st": 1}, "light_1", "light",
        [("level", 0.1, "c/Backlog NoDelay;Dimmer 1"), ("level", 0.0, "c/Backlog NoDelay;Power1 OFF"),
         ("s/RESULT", {"POWER": "OFF", "Dimmer": 0}, {"on_off": False})],
    ),
    "whites are kelvin": (
        {"rl": [2], "lt_st": 2, "so": {"82": 1}}, "light_1", "light",
        [("t/STATE", {"CT": 250}, {"color_temperature": 4000.0}),
         ("color_temperature", 4_000.0, "c/Backlog NoDelay;Power1 ON;NoDelay;CT 250")],
    ),
    "colours and whites of one lamp alternate": (
        {"rl": [2], "lt_st": 5}, "light_1", "light",
        [("t/STATE", {"HSBColor": "240,100,40", "White": 0, "CT": 380},
          {"color": (240.0, 100.0), "color_temperature": None}),
         ("t/STATE", {"HSBColor": "240,100,40", "White": 40, "CT": 380}, {"color_temperature": 2631.0, "color": None}),
         ("color", (240.4, 50.0), "c/Backlog NoDelay;Power1 ON;NoDelay;HsbColor1 240;NoDelay;HsbColor2 50"),
         ("effect", "Random", "c/Backlog NoDelay;Power1 ON;NoDelay;Scheme 4"),
         ("t/STATE", {"Scheme": 2}, {"effect": "Cycle up"})],
    ),
    "a shutter that stopped nowhere known": (
        {"rl": [3, 3]}, "shutter_1", "window_covering",
        [("s/STATUS10", {"StatusSNS": {"Shutter1": {"Direction": 0}}}, {"movement": "stopped"})],
    ),
    "a shutter the wrong way round": (
        {"rl": [3, 3], "sho": [1], "sht": [[0, 0, 0]]}, "shutter_1", "window_covering",
        [("s/RESULT", {"Shutter1": {"Position": 30, "Direction": 1}}, {"position": 70.0, "movement": "closing"}),
         ("position", 70.0, "c/ShutterPosition1 30"), ("tilt", 50.0, None)],
    ),
    "a ceiling fan goes on at its last speed": (
        {"rl": [2, 0, 0], "if": 1}, "fan", "fan",
        [("on_off", True, "c/FanSpeed 2"), ("s/RESULT", {"FanSpeed": 3}, {"on_off": True, "fan_speed": 100.0}),
         ("t/STATE", {"FanSpeed": 0}, {"on_off": False, "fan_speed": 0.0}), ("on_off", True, "c/FanSpeed 3"),
         ("fan_speed", 34.0, "c/FanSpeed 2")],
    ),
    # Home Assistant shows them as switches: *all on* there would set the fan between two speeds.
    "a relay of a fan's speeds is read only": (
        {"rl": [1, 1, 1, 1], "if": 1}, "power_3", "x_binary_sensor diagnostic",
        [("t/STATE", {"POWER1": "OFF", "POWER3": "ON"}, {"state": True}), ("on_off", True, None),
         ("state", True, None)],
    ),
    "a switch that is followed is a state": (
        {"swc": [-1, 1], "swn": [None, "Door"]}, "switch_2", "x_binary_sensor Door",
        [("s/RESULT", {"Door": {"Action": "ON"}}, {"state": True}), ("t/SENSOR", {"Door": "OFF"}, {"state": False}),
         ("s/STATUS10", {"StatusSNS": {"Door": "ON"}}, {"state": True}),
         ("s/RESULT", {"Door": {"Action": "HOLD"}}, {})],
    ),
    "a push switch reports presses": (
        {"swc": [5]}, "switch_1_press", "generic_switch Switch1",
        [("s/RESULT", {"Switch1": {"Action": "TOGGLE"}}, {"press": "single"}),
         ("s/RESULT", {"Switch1": {"Action": "HOLD"}}, {"press": "hold"}),
         ("s/RESULT", {"Switch1": {"Action": "ON"}}, {})],
    ),
    "a meter may report fewer phases than announced": (
        {"sensors": {"ENERGY": {"Power": [1, 2]}}}, "ENERGY_Power_0", "electrical_meter ENERGY Power 0",
        [("t/SENSOR", {"ENERGY": {"Power": 5}}, {"power": 5.0}),
         ("t/SENSOR", {"ENERGY": {"Power": None}}, {"power": None})],
    ),
    "a phase that is not reported has no power": (
        {"sensors": {"ENERGY": {"Power": [1, 2]}}}, "ENERGY_Power_1", "electrical_meter ENERGY Power 1",
        [("t/SENSOR", {"ENERGY": {"Power": 5}}, {}), ("t/SENSOR", {"ENERGY": {"Power": [5]}}, {})],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("device", "part_id", "is_a", "said"), THINGS.values(), ids=THINGS)
def test_a_part_is_read_and_told(
    device: dict[str, Any], part_id: str, is_a: str, said: list[tuple[str, Any, object]]
) -> None:
    """What it reads, or the publication of a command, or none where it refuses."""
    part = built(**device)[part_id]
    assert " ".join(filter(None, (part.part.service_type, part.part.name, part.part.category))) == is_a
    for where, value, expected in said:
        if "/" in where:
            assert heard(part, where, value) == expected
        elif expected is None:
            with pytest.raises(RefusedError):
                part.codec.write(where, value)
        else:
            assert " ".join(told(part, where, value)) == expected


@pytest.mark.parametrize(
    ("device", "part", "topic", "message", "expected"),
    [
        ({"rl": [1]}, "power_1", "s/POWER", {"POWER": "ON"}, {"on_off": True}),
        ({"rl": [1, 1]}, "power_2", "s/POWER2", {"POWER2": "OFF"}, {"on_off": False}),
        ({"rl": [1]}, "power_1", "s/STATE", {"POWER": "ON"}, {"on_off": True}),
        ({"rl": [1]}, "power_1", "s/POWER", "ON", {}),
        ({"rl": [2], "lt_st": 1}, "light_1", "s/DIMMER", {"POWER": "ON", "Dimmer": 20}, {"on_off": True, "level": 20}),
        ({"rl": [3, 3]}, "shutter_1", "s/SHUTTER", {"Shutter1": {"Position": 30}}, {"position": 30}),
        ({"rl": [2], "fan": 1}, "fan", "s/FANSPEED", {"FanSpeed": 3}, {"on_off": True, "fan_speed": 100}),
        ({"swc": [1]}, "switch_1", "s/SWITCH1", {"Switch1": {"Action": "ON"}}, {"state": True}),
        ({"swc": [0]}, "switch_1_press", "s/SWITCH1", {"Switch1": {"Action": "TOGGLE"}}, {"press": "single"}),
        ({"btn": [1]}, "button_1", "s/BUTTON1", {"Button1": {"Action": "HOLD"}}, {"press": "hold"}),
    ],
)
def test_option_4_gives_each_answer_a_topic_of_its_own(
    device: dict[str, Any], part: str, topic: str, message: object, expected: dict[str, object]
) -> None:
    assert heard(built(**device, so={"4": 1, "73": 1})[part], topic, message) == expected


@pytest.mark.parametrize("color", [1, "a,b,c", "1,2", "361,1,1", "1," * 999, None])
def test_an_invalid_colour_is_ignored(color: object) -> None:
    assert heard(only(rl=[2], lt_st=3), "t/STATE", {"HSBColor": color, "Color": color}) == {}


def test_the_fade_speed_depends_on_the_state() -> None:
    lamp = only(rl=[2], lt_st=1)
    assert told(lamp, "level", 50.0, 2.0)[1] == "NoDelay;Fade2 1;NoDelay;Speed2 8;NoDelay;Dimmer 50"
    heard(lamp, "t/STATE", {"POWER": "ON", "Dimmer": 40})
    assert told(lamp, "level", 50.0, 2.0)[1] == "NoDelay;Fade2 1;NoDelay;Speed2 40;NoDelay;Dimmer 50"
    assert told(lamp, "on_off", value=False, transition=2.0)[1].startswith("NoDelay;Fade2 1;NoDelay;Speed2 10;")
    assert "Speed2 4;" in told(only(rl=[2], lt_st=1, so={"117": 1}), "level", 50.0, 2.0)[1]
    with pytest.raises(RefusedError, match="transition"):
        lamp.codec.write("level", 50.0, transition=float("inf"))


@pytest.mark.parametrize(
    ("color", "change", "share"),
    [
        ("FF0000", LightCommand(on=True, color=(0.0, 100.0)), 0.0),
        ("255,0,0", LightCommand(on=True, color=(120.0, 100.0)), 1.0),
        ("FF000", LightCommand(on=True, color=(120.0, 100.0)), 0.0),
        ("GG0000", LightCommand(on=True, level=40), 0.6),
    ],
)
def test_the_channel_that_changes_most_counts(color: str, change: LightCommand, share: float) -> None:
    shown = LampState()
    shown.update(is_on=True, level=100, color=color, mired=None)
    assert shown.distance(change, 3, (153, 500)) == pytest.approx(share)


def test_a_speed_is_never_out_of_bounds() -> None:
    assert [speed_for(2.0, 0.5), speed_for(0.1, 1.0), speed_for(1e9, 1.0), speed_for(2.0, 0.0)] == [8, 1, 40, 1]


@pytest.mark.parametrize(
    ("outputs", "count"),
    [((3, 3), 1), ((1, 3, 3, 3, 3), 2), ((3,), 0), ((3, 1, 3), 0), ((3, 3, 3), 0), ((), 0)],
)
def test_a_shutter_has_two_outputs(outputs: tuple[int, ...], count: int) -> None:
    assert count_shutters(outputs) == count


def test_parts_have_their_bounds_and_options_and_are_asked_for_their_state() -> None:
    assert only(rl=[2], lt_st=2, so={"82": 1}).part.capabilities[2].bounds == (2625.0, 5000.0)
    assert built(swc=[5])["switch_1_press"].part.capabilities[0].options == ("single", "hold")
    assert only(rl=[1]).state_requests == (Publication("c/STATE", b""),)
    assert only(rl=[3, 3]).state_requests == (Publication("c/STATUS", b"10"),)


def test_an_approval_of_a_shutter_is_none_of_one_the_wrong_way_round() -> None:
    assert only(rl=[3, 3], sho=[1]).part.payloads != only(rl=[3, 3]).part.payloads


def test_an_approval_of_a_relay_is_none_of_one_that_is_told_off_to_be_on() -> None:
    swapped = only(rl=[1], state=["ON", "OFF", "TOGGLE", "HOLD"])
    assert told(swapped, "on_off", value=False) == ("c/Power1", "ON")
    assert swapped.part.payloads != only(rl=[1]).part.payloads


def test_a_pulse_ends_by_itself_and_is_no_pulse_when_kept() -> None:
    switch = only(swc=[13])
    assert switch.expiries == (AutoExpiry("state", 1.0, value=False, only=True),)
    assert heard(switch, "s/RESULT", {"Switch1": {"Action": "ON"}}) == {"state": True}
    assert heard(switch, "s/RESULT", {"Switch1": {"Action": "ON"}}, retained=True) == {}


@pytest.mark.parametrize(
    ("options", "action", "expected"),
    [
        ({"73": 1}, "DOUBLE", {"press": "double"}),
        ({"73": 1, "11": 1}, "DOUBLE", {"press": "single"}),
        ({"73": 1, "13": 1}, "DOUBLE", {}),
        ({"73": 1}, "PENTA", {"press": "quintuple"}),
    ],
)
def test_buttons_report_presses(options: dict[str, int], action: str, expected: dict[str, str]) -> None:
    button = only(btn=[1, 0], so=options)
    assert button.part.id == "button_1"
    assert heard(button, "s/RESULT", {"Button1": {"Action": action}}) == expected


def test_buttons_that_switch_directly_report_nothing() -> None:
    assert built(btn=[1]) == {}


@pytest.mark.parametrize(
    ("sensors", "part_id", "service_type", "expected"),
    [
        ({"A": {"Temperature": 212}, "TempUnit": "F"}, "A_Temperature", "temperature_sensor", {"temperature": 100}),
        ({"A": {"Humidity": 45.5}}, "A_Humidity", "humidity_sensor", {"humidity": 45.5}),
        ({"A": {"Pressure": 750}, "PressureUnit": "mmHg"}, "A_Pressure", "pressure_sensor", {"pressure": 999.9}),
        ({"A": {"Pressure": 29.9}, "PressureUnit": "inHg"}, "A_Pressure", "pressure_sensor", {"pressure": 1012.5}),
        ({"ENERGY": {"Total": 1.5}}, "ENERGY_Total", "electrical_meter", {"energy": 1.5}),
        ({"ENERGY": {"ExportActive": 39.3}}, "ENERGY_ExportActive", "electrical_meter", {"energy_returned": 39.3}),
        ({"X": {"ExportActiveTotal": 9}}, "X_ExportActiveTotal", "electrical_meter", {"energy_returned": 9.0}),
        ({"SML": {"Total_in": 12345.6}}, "SML_Total_in", "electrical_meter", {"energy": 12345.6}),
        ({"SML": {"Total_out": 77.1}}, "SML_Total_out", "electrical_meter", {"energy_returned": 77.1}),
        ({"MT681": {"Power_curr": -321}}, "MT681_Power_curr", "electrical_meter", {"power": -321.0}),
        ({"SML": {"power_l2": -80}}, "SML_power_l2", "electrical_meter", {"power": -80.0}),
        ({"SML": {"voltage_l1": 231.4}}, "SML_voltage_l1", "electrical_meter", {"voltage": 231.4}),
        ({"SML": {"current_l3": 0.7}}, "SML_current_l3", "electrical_meter", {"current": 0.7}),
        ({"ENERGY": {"PowerTotal": 120}}, "ENERGY_PowerTotal", "electrical_meter", {"power": 120.0}),
        ({"ENERGY": {"Power": [1, 2]}}, "ENERGY_Power_1", "electrical_meter", {"power": 2.0}),
        ({"ENERGY": {"Factor": 0.5}}, "ENERGY_Factor", "x_sensor", {"measurement": 0.5}),
        ({"AS3935": {"Energy": 7}}, "AS3935_Energy", "x_sensor", {"measurement": 7.0}),
        ({"ANALOG": {"Humidity1": 20}}, "ANALOG_Humidity1", "humidity_sensor", {"humidity": 20.0}),
        ({"ANALOG": {"CT": {"Power": 5}}}, "ANALOG_CT_Power", "electrical_meter", {"power": 5.0}),
        ({"TX23": {"Dir": {"Card": "WSW"}}}, "TX23_Dir_Card", "x_sensor", {"value": "WSW"}),
        ({"A": {"CarbonDioxide": 800}}, "A_CarbonDioxide", "air_quality_sensor", {"carbon_dioxide": 800.0}),
        ({"A": {"Temperature": 20}}, "A_Temperature", "x_sensor", {"measurement": 20.0}),
    ],
)  # fmt: skip
def test_each_leaf_is_a_sensor(
    sensors: dict[str, Any], part_id: str, service_type: str, expected: dict[str, Any]
) -> None:
    sensor = built(sensors)[part_id]
    assert sensor.part.service_type == service_type
    wanted = {
        name: value if isinstance(value, str) else pytest.approx(value, abs=0.1) for name, value in expected.items()
    }
    assert heard(sensor, "t/SENSOR", sensors) == wanted
    assert heard(sensor, "s/STATUS10", {"StatusSNS": sensors}) == wanted


@pytest.mark.parametrize(
    ("sensors", "part_id", "category"),
    [
        ({"ESP32": {"Temperature": 53.3}}, "ESP32_Temperature", "diagnostic"),
        ({"BL0940": {"Temperature": 43.5}}, "BL0940_Temperature", "diagnostic"),
        ({"ANALOG": {"Temperature": 50.1}, "ENERGY": {"Power": 5}}, "ANALOG_Temperature", "diagnostic"),
        ({"ANALOG": {"Temperature": 21.5}}, "ANALOG_Temperature", ""),
        ({"ANALOG": {"Humidity": 40}, "ENERGY": {"Power": 5}}, "ANALOG_Humidity", ""),
        ({"DS18B20": {"Temperature": 21.5}, "ENERGY": {"Power": 5}}, "DS18B20_Temperature", ""),
    ],
)
def test_the_temperature_inside_a_device_is_no_temperature_of_its_room(
    sensors: dict[str, Any], part_id: str, category: str
) -> None:
    assert built({**sensors, "TempUnit": "C"})[part_id].part.category == category


PLUG = {"TotalStartTime": "2025-01-01T10:00:00", "Total": 1.5, "Yesterday": 1, "Today": 0.5, "Period": 0, "Power": 5}


def test_a_plug_begins_with_what_it_measures_now() -> None:
    """A list showed the time since which a plug counts, and three counters, but not its power."""
    shown = [one.part.id for one in built({"ENERGY": PLUG}).values() if one.part.category != "diagnostic"]
    assert shown == ["ENERGY_Power", "ENERGY_Total", "ENERGY_Yesterday", "ENERGY_Today", "ENERGY_Period"]


def test_a_plug_counts_its_energy_once() -> None:
    """The energy of a day was listed twice, as its total and the sum of today have the same steps."""
    parts = [one.part for one in built({"ENERGY": PLUG}).values()]
    assert [one.id for one in parts if "energy" in {it.name for it in one.capabilities}] == ["ENERGY_Total"]


def test_a_blind_begins_with_its_shutter_and_a_thermometer_with_its_temperature() -> None:
    """A list showed the position of a blind twice, its direction and its target, and the number of a thermometer."""
    parts = built(
        {"Shutter1": {"Position": 30, "Direction": 0}, "DS18B20": {"Id": "01191ED79190", "Temperature": 20.5}}
    )
    assert [one.part.id for one in parts.values() if one.part.category != "diagnostic"] == ["DS18B20_Temperature"]


def test_other_leaves_are_left_out() -> None:
    assert built({"Time": "now", "Switch1": "ON", "PN532": {"UID": "1"}, "TempUnit": "C"}) == {}
    assert read_leaves({"ver": 2, "sn": {"A": {"b": 1}}}, {}) == ()


def test_sensors_are_bounded() -> None:
    assert built({"A" * 101: {"b": 1}, "A": {"b" * 101: 1}}) == {}
    assert len(built({"A": {f"n{number}": number for number in range(10_000)}})) == MAX_SENSORS


def test_the_signal_strength_is_a_diagnostic_part() -> None:
    config = read_config(
        MAC, json.dumps({"ver": 1, "mac": MAC, "ft": "%prefix%/", "tp": ["c", "s", "t"], "rl": []}).encode()
    )
    (wifi,) = build_parts(config, ())
    assert (wifi.part.category, config.name) == ("diagnostic", MAC)
    assert heard(wifi, "t/STATE", {"Wifi": {"Signal": -65}}) == {"signal_strength": -65.0}
    assert heard(wifi, "t/STATE", {"Wifi": 1}) == {}
