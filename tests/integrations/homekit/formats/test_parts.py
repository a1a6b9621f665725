"""Each service is a part with the capabilities of the vocabulary, read and written as the specification has them."""

from collections.abc import Mapping

import pytest
from tests.gateways.checked_command import checked_command
from tests.integrations.homekit.gateway.fake_accessories import accessory, characteristic, service

from homebot.conventions.capability_row import writer_of
from homebot.devices.part import Capability
from homebot.devices.query.terms import OPENING_TAGS
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import fits
from homebot.errors import RefusedError, WireError
from homebot.integrations.homekit.formats.accessory import parse_accessories, short_type
from homebot.integrations.homekit.formats.parts import HomekitPart, parts_of

READ = ["pr", "ev"]
ECOBEE, ECOBEE_HOLD = "B7DDB9A3-54BB-4572-91D2-F1F5B0510F8C", "1B300BC2-CFFC-47FF-89F9-BD6CCF5F2853"
NETATMO_NOISE, VOCOLINC_SPRAY = "B3BBFABC-D78C-5B8D-948C-5DAC1EE2CDE5", "69D52519-0A4E-4898-8335-4739F9116D0A"
AQARA_VOLUME = "EE56B186-B0D3-488E-8C79-C21FC9BCF437"
EVE, SENSE, KOOGEEK = "-079E-48FF-8F27-9C2605A29F52", "-0000-1000-8000-001D4B474349", "-0DEC-11E5-B939-0800200C9A66"


def part(kind: str, values: Mapping[str, object], read_only: str = "", **limits: dict[str, object]) -> HomekitPart:
    """The part that a service is, whose characteristics have these values."""
    listed = [
        characteristic(20 + at, name, value, READ if name in read_only.split() else None, **limits.get(f"c{name}", {}))
        for at, (name, value) in enumerate(values.items())
    ]
    found = parse_accessories([accessory(1, "Thing", service(10, kind, *listed))])
    (only,) = parts_of(found[1])
    return only


def values(found: HomekitPart) -> dict[str, PlainValue]:
    return {name: row.read(found.service) for name, row in found.rows.items() if row.read is not None}


def written(found: HomekitPart, capability: str, value: PlainValue) -> Mapping[str, float]:
    return writer_of(found.rows.values(), capability)(found.service, checked_command(found.part, capability, value))


def described(found: HomekitPart, capability: str) -> Capability:
    return next(one for one in found.part.capabilities if one.name == capability)


@pytest.mark.parametrize(
    ("kind", "raw", "service_type", "expected"),
    [
        ("43", {"25": 1, "8": 40}, "light", {"on_off": True, "level": 40.0}),
        ("43", {"25": True, "13": 120.0, "2F": 80.0}, "light", {"on_off": True, "color": (120.0, 80.0)}),
        ("43", {"25": True, "CE": 370}, "light", {"on_off": True, "color_temperature": 2703.0}),
        ("47", {"25": False, "26": True}, "plug", {"on_off": False, "plugged_in": True}),
        ("49", {"25": True}, "switch", {"on_off": True}),
        ("40", {"25": True, "29": 60.0, "28": 1}, "fan", {"on_off": True, "fan_speed": 60.0, "direction": "reverse"}),
        ("B7", {"B0": 0, "29": 60.0, "BF": 1, "B6": 1}, "fan",
         {"on_off": False, "fan_speed": 0.0, "fan_mode": "auto", "oscillation": True}),
        ("BB", {"B0": 1, "A8": 0}, "fan", {"on_off": True, "fan_mode": "manual"}),
        ("BC", {"B0": 0, "29": 60.0}, "thermostat", {"fan_speed": 60.0}),
        ("BA", {"AC": 1, "AB": 12.0}, "x_sensor", {"problem": True, "measurement": 12.0}),
        ("47", {"25": True, f"0000000A{SENSE}": 0.8, f"0000000C{SENSE}": 379.7}, "plug",
         {"on_off": True, "power": 0.8, "energy": 379.7}),
        (f"4AAAF930{KOOGEEK}", {f"4AAAF931{KOOGEEK}": 5.0}, "electrical_meter", {"power": 5.0}),
        ("6237CEFC-9F4D-54B2-8033-2EDA0053B811", {NETATMO_NOISE: 45}, "x_sensor", {"measurement": 45.0}),
        ("9715BF53-AB63-4449-8DC7-2785D617390A", {AQARA_VOLUME: 40}, "x_setting", {"volume": 40.0}),
        ("4A", {"11": 20.5, f"E863F12E{EVE}": 35}, "thermostat", {"local_temperature": 20.5, "measurement": 35.0}),
        (f"E863F00A{EVE}", {f"E863F10F{EVE}": 1005.7}, "pressure_sensor", {"pressure": 1005.7}),
        ("113", {"11A": False, "119": 30}, "speaker", {"volume": 30.0, "muted": False}),
        ("D8", {"B0": 1}, "video_player", {"on_off": True}),
        ("D8", {"B0": 1, "E0": 1, "137": 1}, "video_player", {"on_off": True, "playback": "paused"}),
        ("45", {"1D": 1, "1E": 1}, "door_lock", {"lock": "locked"}),
        ("45", {"1D": 1, "1E": 0}, "door_lock", {"lock": "unlocking"}),
        ("45", {"1D": 2, "1E": 1}, "door_lock", {"lock": "jammed"}),
        ("45", {"1D": 3, "1E": 1}, "door_lock", {"lock": None}),
        ("41", {"E": 3, "32": 1, "24": True}, "closure", {"movement": "closing", "problem": True}),
        ("41", {"E": 1, "32": 0}, "closure", {"movement": "opening"}),
        ("41", {"E": 4, "32": 0}, "closure", {"movement": "stopped"}),
        ("8C", {"6D": 100, "7C": 0, "72": 0}, "window_covering", {"position": 100.0, "movement": "closing"}),
        ("8C", {"6D": 0, "7C": 0, "72": 2}, "window_covering", {"position": 0.0, "movement": "closed"}),
        ("8C", {"6D": 5, "7C": 5, "72": 2, "6C": -45, "7B": -45}, "window_covering",
         {"position": 5.0, "movement": "open", "tilt": 50.0}),
        ("8B", {"6D": 5, "7C": 100, "72": 1}, "closure", {"position": 5.0, "movement": "opening"}),
        # Apple's Home compares both positions, so that many programs leave the state of HAP-NodeJS as it begins.
        ("8C", {"6D": 100, "7C": 100, "72": 0}, "window_covering", {"position": 100.0, "movement": "open"}),
        ("D0", {"B0": 1, "D2": 1, "D5": 0}, "water_valve", {"valve": "open"}),
        ("D0", {"B0": 1, "D2": 0, "D5": 0}, "water_valve", {"valve": "opening"}),
        ("D0", {"B0": 0, "D2": 0, "D3": 1200}, "water_valve", {"valve": "closed", "number": 1200.0}),
        ("D7", {"B0": 0}, "water_valve", {"valve": "closed"}),
        ("CF", {"B0": 1, "D1": 1, "D2": 0}, "water_valve", {"on_off": True, "running": False}),
        ("7E", {"66": 3, "67": 1}, "x_alarm_panel", {"alarm": "arming"}),
        ("7E", {"66": 4, "67": 1}, "x_alarm_panel", {"alarm": "triggered"}),
        ("7E", {"66": 3, "77": 0, "7A": 1}, "x_alarm_panel", {"alarm": "disarmed", "tamper": True, "problem": False}),
        ("7E", {"66": 2, "67": 2}, "x_alarm_panel", {"alarm": "armed_night"}),
        ("4A", {"F": 1, "33": 1, "11": 20.5, "35": 21.0, "10": 45.0, "BF": 1}, "thermostat",
         {"fan_mode": "auto", "thermostat_action": "heating", "thermostat_mode": "heat", "local_temperature": 20.5,
          "heating_setpoint": 21.0, "cooling_setpoint": None, "humidity": 45.0}),
        ("4A", {"F": 0, "33": 3, "11": 20.5, "35": 21.0, "12": 19.0, "D": 25.0}, "thermostat",
         {"thermostat_action": "idle", "thermostat_mode": "auto", "local_temperature": 20.5,
          "heating_setpoint": 19.0, "cooling_setpoint": 25.0}),
        ("BC", {"B0": 1, "B1": 3, "B2": 2, "11": 26.0, "D": 22.0}, "room_air_conditioner",
         {"thermostat_mode": "cool", "thermostat_action": "cooling", "local_temperature": 26.0,
          "cooling_setpoint": 22.0}),
        ("BC", {"B0": 0, "B1": 0, "B2": 1, "11": 26.0, "12": 22.0}, "thermostat",
         {"thermostat_mode": "off", "thermostat_action": "off", "local_temperature": 26.0, "heating_setpoint": 22.0}),
        ("BD", {"B0": 1, "B3": 2, "B4": 1, "10": 40.0, "CA": 50.0, "B5": 75.0}, "x_humidifier",
         {"on_off": True, "humidifier_mode": "humidify", "humidity": 40.0, "humidity_setpoint": 50.0,
          "measurement": 75.0}),
        ("BD", {"B0": 1, "B4": 2, "10": 70.0, "CA": 30.0, "C9": 50.0}, "x_humidifier",
         {"on_off": True, "humidifier_mode": "dehumidify", "humidity": 70.0, "humidity_setpoint": 50.0}),
        ("85", {"22": True, "79": 1}, "occupancy_sensor", {"occupancy": True, "battery_low": True}),
        ("86", {"71": 0}, "occupancy_sensor", {"occupancy": False}),
        ("80", {"6A": 1, "7A": 0}, "contact_sensor", {"contact": True, "tamper": False}),
        ("83", {"70": 1}, "water_leak_detector", {"water_leak": True}),
        ("87", {"76": 1}, "smoke_co_alarm", {"smoke": True}),
        ("7F", {"69": 0, "90": 3.5}, "smoke_co_alarm", {"carbon_monoxide_alarm": False, "carbon_monoxide": 3.5}),
        ("97", {"92": 1, "93": 1400.0}, "air_quality_sensor", {"safety": True, "carbon_dioxide": 1400.0}),
        ("8D", {"95": 2, "C6": 7.0, "C8": 90.0}, "air_quality_sensor",
         {"air_quality_index": 2.0, "pm25": 7.0, "volatile_organic_compounds": 90.0}),
        ("8A", {"11": -3.5}, "temperature_sensor", {"temperature": -3.5}),
        ("8D", {"95": 0}, "air_quality_sensor", {"air_quality_index": None}),  # it has not measured yet
        ("112", {"11A": False}, "x_setting", {"muted": False}),  # the microphone of a doorbell
        ("8D", {"95": 1, "11": 21.0, "10": 40.0}, "air_quality_sensor",
         {"air_quality_index": 1.0, "temperature": 21.0, "humidity": 40.0}),
        ("82", {"10": 55.0}, "humidity_sensor", {"humidity": 55.0}),
        ("84", {"6B": 120.0}, "light_sensor", {"illuminance": 120.0}),
        ("96", {"68": 80, "8F": 2, "79": 0}, "x_battery",
         {"battery": 80.0, "battery_charging": False, "battery_low": False}),
        ("89", {"73": None}, "generic_switch", {"press": None}),
    ],
)  # fmt: skip
def test_a_service_is_a_part_with_its_readings(
    kind: str, raw: Mapping[str, object], service_type: str, expected: Mapping[str, PlainValue]
) -> None:
    found = part(kind, raw)
    assert (found.part.id, found.part.service_type) == ("10", service_type)
    assert values(found) == expected


@pytest.mark.parametrize(
    ("kind", "raw", "capability", "value", "expected"),
    [
        ("43", {"25": False}, "on_off", True, {"25": 1.0}),
        ("43", {"25": False, "8": 50}, "level", 40.0, {"8": 40.0, "25": 1}),
        ("43", {"25": True, "8": 50}, "level", 0.0, {"25": 0}),
        # What is on is not turned on.
        ("43", {"25": True, "8": 50}, "level", 40.0, {"8": 40.0}),
        ("43", {"25": True, "13": 0.0, "2F": 0.0}, "color", (120.0, 80.0), {"13": 120.0, "2F": 80.0}),
        ("43", {"25": True, "CE": 300}, "color_temperature", 4000.0, {"CE": 250.0}),
        ("B7", {"B0": 1, "29": 0.0}, "fan_speed", 60.0, {"29": 60.0}),
        ("43", {"25": False, "13": 0.0, "2F": 0.0}, "color", (120.0, 80.0), {"13": 120.0, "2F": 80.0, "25": 1}),
        ("43", {"25": False, "CE": 300}, "color_temperature", 4000.0, {"CE": 250.0, "25": 1}),
        ("B7", {"B0": 0, "29": 0.0}, "fan_speed", 60.0, {"29": 60.0, "B0": 1}),
        ("40", {"25": True, "29": 50.0}, "fan_speed", 0.0, {"25": 0}),
        ("45", {"1D": 0, "1E": 0}, "lock", "locked", {"1E": 1}),
        ("41", {"E": 1, "32": 1}, "movement", "open", {"32": 0}),
        ("8C", {"6D": 0, "7C": 0, "72": 2}, "position", 30.0, {"7C": 30.0}),
        ("8C", {"6D": 0, "7C": 0, "72": 2}, "movement", "open", {"7C": 100}),
        ("8C", {"6D": 0, "7C": 0, "72": 2, "6F": False}, "movement", "stopped", {"6F": 1}),
        ("8C", {"6D": 0, "7C": 0, "72": 2, "6C": -45, "7B": -45}, "tilt", 0.0, {"7B": -90.0}),
        ("8C", {"6D": 0, "7C": 0, "72": 2, "6E": 45, "7D": 45}, "tilt", 50.0, {"7D": 45.0}),
        ("D0", {"B0": 0, "D2": 0}, "valve", "open", {"B0": 1.0}),
        ("D0", {"B0": 0, "D2": 0, "D3": 1200}, "number", 600.0, {"D3": 600.0}),
        ("BD", {"B0": 1, "B4": 1, VOCOLINC_SPRAY: 5}, "number", 2.0, {VOCOLINC_SPRAY: 2.0}),
        ("7E", {"66": 3, "67": 3}, "alarm", "armed_away", {"67": 1}),
        ("4A", {"F": 0, "33": 1, "11": 20.0, "35": 20.0}, "heating_setpoint", 22.0, {"35": 22.0}),
        ("4A", {"F": 0, "33": 2, "11": 20.0, "35": 20.0}, "cooling_setpoint", 22.0, {"35": 22.0}),
        ("4A", {"F": 0, "33": 3, "11": 20.0, "35": 20.0, "12": 18.0}, "heating_setpoint", 19.0, {"12": 19.0}),
        (
            "4A",
            {"F": 0, "33": 3, "11": 20.0, "35": 20.0, "12": 18.0, "D": 24.0},
            "heating_setpoint",
            24.0,
            {"12": 24.0},
        ),
        # Apart from the mode auto, the other threshold does not count.
        (
            "4A",
            {"F": 0, "33": 2, "11": 20.0, "35": 20.0, "12": 18.0, "D": 24.0},
            "heating_setpoint",
            25.0,
            {"12": 25.0},
        ),
        ("BC", {"B0": 1, "B1": 1, "B2": 1, "11": 20.0, "12": 18.0, "D": 24.0}, "heating_setpoint", 25.0, {"12": 25.0}),
        ("4A", {"F": 0, "33": 0, "11": 20.0, "35": 20.0}, "thermostat_mode", "auto", {"33": 3}),
        ("BC", {"B0": 1, "B1": 1, "B2": 0, "11": 20.0}, "thermostat_mode", "off", {"B0": 0}),
        ("BC", {"B0": 0, "B1": 0, "B2": 0, "11": 20.0}, "thermostat_mode", "cool", {"B2": 2, "B0": 1}),
        ("BD", {"B0": 1, "B3": 0, "B4": 0, "10": 40.0, "C9": 50.0}, "humidity_setpoint", 45.0, {"C9": 45.0}),
        ("BD", {"B0": 1, "B4": 2, "10": 70.0, "CA": 30.0, "C9": 50.0}, "humidity_setpoint", 45.0, {"C9": 45.0}),
        ("BC", {"B0": 0, "29": 60.0}, "fan_speed", 40.0, {"29": 40.0}),
        ("4A", {"35": 20.0, ECOBEE: 0, ECOBEE_HOLD: 0}, "preset_mode", "away", {ECOBEE_HOLD: 2}),
        ("113", {"11A": False, "119": 30}, "volume", 10.0, {"119": 10.0}),
        ("113", {"11A": False, "119": 30}, "muted", True, {"11A": 1}),
        ("D8", {"B0": 1, "E0": 0, "137": 0}, "playback", "paused", {"137": 1}),
    ],
)
def test_a_command_is_the_values_of_characteristics(
    kind: str, raw: Mapping[str, object], capability: str, value: PlainValue, expected: Mapping[str, float]
) -> None:
    assert written(part(kind, raw), capability, value) == expected


@pytest.mark.parametrize(
    ("kind", "raw", "capability", "value"),
    [
        ("43", {"25": False}, "on_off", "on"),
        ("43", {"25": False, "CE": 300}, "color_temperature", 100.0),
        ("45", {"1D": 0, "1E": 0}, "lock", "jammed"),
        ("8C", {"6D": 0, "7C": 0, "72": 2}, "movement", "stopped"),
        ("4A", {"F": 0, "33": 2, "11": 20.0, "35": 20.0}, "heating_setpoint", 22.0),
        ("4A", {"F": 0, "33": 3, "11": 20.0, "35": 20.0, "12": 18.0, "D": 24.0}, "heating_setpoint", 24.5),
        ("4A", {"F": 0, "33": 3, "11": 20.0, "35": 20.0, "12": 18.0, "D": 24.0}, "cooling_setpoint", 17.5),
        ("BC", {"B0": 1, "B1": 1, "B2": 0, "11": 20.0, "12": 18.0, "D": 24.0}, "heating_setpoint", 24.5),
        ("7E", {"66": 3, "67": 3}, "alarm", "triggered"),
    ],
)
def test_a_value_that_a_service_cannot_have_is_refused(
    kind: str, raw: Mapping[str, object], capability: str, value: PlainValue
) -> None:
    with pytest.raises(RefusedError):
        written(part(kind, raw), capability, value)


@pytest.mark.parametrize(
    ("kind", "raw", "limits", "capability", "options", "bounds"),
    [
        ("4A", {"33": 1, "35": 20.0}, {"c33": {"valid-values": [0, 1]}}, "thermostat_mode", ("off", "heat"), ()),
        ("4A", {"33": 1, "35": 20.0}, {"c35": {"minValue": 5, "maxValue": 30}}, "heating_setpoint", (), (5.0, 30.0)),
        # The ranges of HAP-NodeJS, of every thermostat of Homebridge that sets none: auto goes lower than heat.
        (
            "4A",
            {"33": 1, "35": 20.0, "12": 20.0},
            {"c35": {"minValue": 10, "maxValue": 38}, "c12": {"minValue": 0, "maxValue": 25}},
            "heating_setpoint",
            (),
            (0.0, 38.0),
        ),
        ("4A", {"33": 0, "34": 30.0}, {"c34": {"minValue": 20, "maxValue": 50}}, "humidity_setpoint", (), (20.0, 50.0)),
        # SwitchBot's humidifier, as Home Assistant bridges it.
        ("BD", {"B4": 1, "CA": 45.0}, {"cCA": {"minValue": 20, "maxValue": 80}}, "humidity_setpoint", (), (20.0, 80.0)),
        # Humidifiers that cannot dry bound their mode by 1 and 1.
        ("BD", {"B4": 1}, {"cB4": {"minValue": 1, "maxValue": 1}}, "humidifier_mode", ("humidify",), ()),
    ],
)
def test_options_and_bounds_are_those_that_the_accessory_has(
    kind: str,
    raw: Mapping[str, object],
    limits: dict[str, dict[str, object]],
    capability: str,
    options: tuple[str, ...],
    bounds: tuple[float, ...],
) -> None:
    found = described(part(kind, raw, "", **limits), capability)
    assert (found.options, found.bounds) == (options, bounds)


@pytest.mark.parametrize(
    ("limits", "percent", "speed", "reported"),
    [
        ({"minValue": 0, "maxValue": 100, "minStep": 25}, 1.0, 25.0, 25.0),
        ({"minValue": 0, "maxValue": 100, "minStep": 25}, 33.0, 50.0, 50.0),
        ({"minValue": 0, "maxValue": 100, "minStep": 25}, 75.0, 75.0, 75.0),
        ({"minValue": 0, "maxValue": 100, "minStep": 1}, 33.0, 33.0, 33.0),
        ({"minValue": 0, "maxValue": 3, "minStep": 1}, 1.0, 1.0, 33.3333),
        ({"minValue": 0, "maxValue": 3, "minStep": 1}, 33.0, 1.0, 33.3333),
        ({"minValue": 0, "maxValue": 3, "minStep": 1}, 67.0, 2.0, 66.6667),
        ({"minValue": 0, "maxValue": 100, "minStep": 33.3333}, 67.0, 66.6666, 66.6666),
    ],
)
@pytest.mark.parametrize(("kind", "switch"), [("40", "25"), ("BC", "B0")])
def test_a_fan_with_few_speeds_takes_the_next_one_which_confirms_the_command(
    kind: str, switch: str, limits: dict[str, object], percent: float, speed: float, reported: float
) -> None:
    fan = part(kind, {switch: 1, "29": 0.0}, c29={"format": "float", **limits})
    known = fan.service.characteristics["29"]
    known.value = known.encode(written(fan, "fan_speed", percent)["29"])
    assert known.value == pytest.approx(speed)
    assert values(fan)["fan_speed"] == pytest.approx(reported)
    assert fits("fan_speed", percent, reported)


@pytest.mark.parametrize(
    ("kind", "raw", "words"),
    [
        ("41", {"E": 0, "32": 0}, {"garage door", "door"}),
        ("81", {"6D": 0, "7C": 0}, {"door"}),
        ("8B", {"6D": 0, "7C": 0}, {"window"}),  # of Velux, which opens
    ],
)
def test_a_garage_door_is_no_window(kind: str, raw: Mapping[str, object], words: set[str]) -> None:
    found = part(kind, raw).part
    assert {one for one, tags in OPENING_TAGS.items() if found.tag in tags} == words


def test_the_motion_and_the_presence_that_a_thermostat_senses_are_told_apart() -> None:
    """Those of ecobee have the name of the thermostat, both."""
    assert [part(kind, raw).part.tag for kind, raw in (("85", {"22": True}), ("86", {"71": 1}))] == [
        "motion",
        "occupancy",
    ]


def test_a_child_lock_is_a_setting_beside_what_it_locks() -> None:
    """Of Eve's plugs and Airversa's purifiers."""
    eve = service(28, "47", characteristic(30, "25", True), characteristic(36, "A7", 0))
    plug, lock = parts_of(parse_accessories([accessory(1, "Eve", eve)])[1])
    assert (plug.part.id, values(plug)) == ("28", {"on_off": True})
    assert (lock.part.id, lock.part.name, lock.part.category, values(lock)) == (
        "28-lock", "Child lock", "config", {"on_off": False},
    )  # fmt: skip
    assert written(lock, "on_off", True) == {"A7": 1.0}


def test_a_thermostat_that_only_heats_is_not_set_to_cool() -> None:
    assert "cooling_setpoint" not in part("4A", {"33": 1, "35": 20.0}, c33={"valid-values": [0, 1]}).rows


def test_a_bridge_that_can_identify_itself_has_no_parts() -> None:
    information = service(1, "3E", characteristic(2, "14", None, ["pw"], format="bool"))
    (bridge,) = parse_accessories([{"aid": 1, "services": [information]}]).values()
    assert not list(parts_of(bridge))


def test_the_sources_of_a_television_are_the_services_beside_it() -> None:
    television = service(48, "D8", characteristic(49, "B0", 1), characteristic(50, "E7", 2))
    inputs = (
        service(250 + at, "D9", characteristic(260 + at, "E6", number), characteristic(270 + at, "E3", name, READ))
        for at, (number, name) in enumerate({2: "HDMI", 3: "HDMI", 70_000: "Live TV"}.items())
    )
    (found,) = parts_of(parse_accessories([accessory(1, "TV", television, *inputs)])[1])
    assert described(found, "option").options == ("HDMI", "HDMI 3", "Live TV")
    assert (values(found)["option"], written(found, "option", "Live TV")) == ("HDMI", {"E7": 70_000})


@pytest.mark.parametrize(
    ("percent", "most", "step", "speed"), [(66.0, 3, 1, 2.0), (10.0, 100, 25, 25.0), (5.0, 3, 1, 1.0)]
)
def test_a_fan_counts_its_speeds_as_it_likes(percent: float, most: float, step: float, speed: float) -> None:
    found = part("40", {"25": False, "29": 0.0}, c29={"minValue": 0, "maxValue": most, "minStep": step})
    wanted = written(found, "fan_speed", percent)["29"]
    assert found.service.characteristics["29"].encode(wanted) == speed
    found.service.characteristics["25"].value, found.service.characteristics["29"].value = True, speed
    assert values(found)["fan_speed"] == pytest.approx(speed / most * 100, abs=0.001)


@pytest.mark.parametrize("limits", [{"minValue": -5, "maxValue": 0}, {"minStep": 5e-324}, {"minStep": -1}])
def test_limits_without_sense_are_none(limits: dict[str, object]) -> None:
    found = part("40", {"25": True, "29": 40.0}, c29=limits)
    assert values(found)["fan_speed"] == 40.0
    assert found.service.characteristics["29"].encode(30.0) in {30.0, 0}


def test_what_cannot_be_written_cannot_be_set() -> None:
    found = part("49", {"25": True}, read_only="25")
    assert not described(found, "on_off").settable


def test_values_are_written_in_the_format_and_the_bounds_of_their_characteristic() -> None:
    found = part("43", {"25": True, "8": 50, "13": 1.0}, c8={"minValue": 10, "maxValue": 90}).service.characteristics
    assert [found["25"].encode(1.0), found["8"].encode(3.7), found["13"].encode(1.5)] == [1, 10, 1.5]
    assert [type(found[kind].encode(1.0)) for kind in ("8", "25")] == [int, int]  # a switch of ecobee takes no true
    target = part("4A", {"35": 20.0, "33": 1}, c35={"minValue": 4.5, "maxValue": 37, "minStep": 0.5}).service
    assert [target.characteristics["35"].encode(one) for one in (21.3, 21.1, 40.0)] == [21.5, 21.0, 37.0]


@pytest.mark.parametrize(
    ("uuid", "short"),
    [
        ("00000043-0000-1000-8000-0026BB765291", "43"),
        ("43", "43"),
        ("0000006d-0000-1000-8000-0026bb765291", "6D"),
        ("E863F10D-079E-48FF-8F27-9C2605A29F52", "E863F10D-079E-48FF-8F27-9C2605A29F52"),
        (7, ""),
    ],
)
def test_a_type_is_as_short_as_it_can_be(uuid: object, short: str) -> None:
    assert short_type(uuid) == short


@pytest.mark.parametrize("listed", [None, [], {"accessories": []}, [{"aid": 0, "services": []}]])
def test_what_lists_no_accessories_is_refused(listed: object) -> None:
    with pytest.raises(WireError):
        parse_accessories(listed)


def test_services_and_characteristics_that_are_none_are_left_out() -> None:
    good = characteristic(9, "25", True)
    broken: list[object] = [1, {"iid": 3}, {"iid": "x", "type": "43", "characteristics": []}]
    lamp = {"iid": 8, "type": "43", "characteristics": [good, 1, {"iid": 10}, {**good, "perms": "pr"}]}
    (found,) = parts_of(parse_accessories([{"aid": 1, "services": [*broken, lamp]}])[1])
    assert values(found) == {"on_off": True}
