"""Appliances, closures and meters of a Matter server, in payloads that hold what those of products hold."""

import pytest
from tests.guide import guide, section_in
from tests.integrations.matter.gateway.test_node import LOCK, encoded, only_device, orders, readings

from homebot.devices.always_ask import is_declared
from homebot.devices.device import DevicePart
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.matter.formats.endpoint import AttributeWrite, ClusterInvocation
from homebot.integrations.matter.gateway.server_link import OLDEST_SCHEMA, SCHEMA, check_result

MODES = [
    {"0": "Rest", "1": 5, "2": [{"1": 16384}]},
    {"0": "Clean", "1": 6, "2": [{"0": None, "1": 16385}, {"1": 0}]},
    {"0": "Clean again", "1": 7, "2": [{"1": 16385}]},
]
VACUUM = {
    "1/29/0": [{"0": 0x0074, "1": 1}],
    "1/84/0": MODES,
    "1/84/1": 5,
    "1/85/0": [{"0": "Quiet", "1": 0, "2": []}, {"0": "Max", "1": 1, "2": []}],
    "1/85/1": 1,
    "1/97/4": 0,
    "1/97/65529": [0, 3, 128],
}
CLOSURE = {
    "1/29/0": [{"0": 0x0230, "1": 1}],
    "1/260/1": 0,
    "1/260/3": {"0": 1, "1": False},
    "1/260/4": {"0": None},
    "1/260/65529": [0, 1],
    "1/260/65532": 1,
}
PANEL = {"1/29/0": [{"0": 0x0231, "1": 1}], "1/261/0": {"0": 2500}, "1/261/65532": 3}
WASHER = {
    "1/29/0": [{"0": 0x0073, "1": 1}],
    "1/6/0": True,
    "1/81/0": [{"0": "Cotton", "1": 3, "2": [{"1": 0}]}, {"0": "Wool", "1": 4}],
    "1/81/1": 4,
    "1/96/4": 1,
}
COLD = {"1/86/0": -1800, "1/86/1": -2000, "1/86/2": -1500, "1/86/65532": 1}
WARM = {"1/86/4": 1, "1/86/5": ["Low", "High"], "1/86/65532": 2}
HOB = {"1/29/0": [{"0": 0x0078, "1": 1}], "1/6/0": True, "1/6/65529": [0], "1/6/65532": 4}
PRESETS = {
    "1/29/0": [{"0": 0x0301, "1": 1}],
    "1/513/78": "AQ==",
    "1/513/80": [
        {"0": "AQ==", "1": 1, "2": "Home"},
        {"0": "Ag==", "1": 2, "2": None},
        {"0": None, "1": 3},
        {"0": "Aw=="},
    ],
    "1/513/65532": 257,
}
CHARGER = {
    "1/29/0": [{"0": 0x050C, "1": 1}, {"0": 0x0510, "1": 1}],
    "1/144/8": 7_200_000,
    "1/153/1": 1,
    "1/153/5": 32_000,
    "1/153/6": 6000,
    "1/157/0": [{"0": "Manual", "1": 0}, {"0": "Solar", "1": 2}],
    "1/157/1": 2,
}
CHIME = {
    "1/29/0": [{"0": 0x0146, "1": 2}],
    "1/1366/0": [{"0": 1, "1": "Ding Dong"}, {"0": 3, "1": "Alert"}, {"0": None, "1": "Broken"}],
    "1/1366/1": 3,
    "1/1366/65529": [0],
}
PUMP = {"1/29/0": [{"0": 0x0303, "1": 1}], "1/6/0": True, "1/8/0": 200, "1/512/16": 32}
PLUG = {"1/29/0": [{"0": 266, "1": 2}], "1/6/0": True}
PLAYER = {"1/29/0": [{"0": 0x28, "1": 1}], "1/6/0": True, "1/1286/0": 0, "1/1286/65529": [0, 1]}
SPEAKER = {"1/29/0": [{"0": 0x22, "1": 1}], "1/6/0": False, "1/8/0": 127, "1/8/2": 1, "1/8/3": 254, "1/6/65529": [0, 1]}
METER = {"1/2820/1285": 2301, "1/2820/1536": 1, "1/2820/1537": 10, "1/2820/1288": 250, "1/2820/1539": 1000}


@pytest.mark.parametrize(
    ("attributes", "service_type", "values"),
    [
        (VACUUM, "robotic_vacuum_cleaner", {"vacuum": "idle", "option": "Max"}),
        ({**VACUUM, "1/84/1": 7, "1/97/4": 1}, "robotic_vacuum_cleaner", {"vacuum": "cleaning"}),
        (PLAYER, "video_player", {"on_off": True, "playback": "playing"}),
        (SPEAKER, "speaker", {"muted": True, "volume": 50.0}),
        # As Home Assistant takes lamps with the device type of a dimmer switch, or with none.
        ({"1/29/0": [{"0": 0x0104}], "1/6/0": True, "1/8/0": 127}, "light", {"on_off": True, "level": 50.0}),
        ({"1/6/0": True, "1/768/7": 250, "1/768/65532": 16}, "light", {"on_off": True, "color_temperature": 4000.0}),
        ({**VACUUM, "1/97/4": 64}, "robotic_vacuum_cleaner", {"vacuum": "returning"}),
        ({**VACUUM, "1/97/4": 65}, "robotic_vacuum_cleaner", {"vacuum": "docked"}),
        ({**VACUUM, "1/97/4": 3}, "robotic_vacuum_cleaner", {"vacuum": "error"}),
        (CLOSURE, "closure", {"movement": "open"}),
        ({**CLOSURE, "1/260/3": {"0": 0}}, "closure", {"movement": "closed"}),
        ({**CLOSURE, "1/260/1": 1, "1/260/4": {"0": 0}}, "closure", {"movement": "closing"}),
        ({**CLOSURE, "1/260/3": None}, "closure", {"movement": None}),
        (PANEL, "closure", {"position": 75.0}),
        ({**PANEL, "1/29/4": [{"0": None, "1": 0x45, "2": 1}]}, "closure", {"tilt": 75.0}),
        (WASHER, "x_setting", {"running": True, "problem": False, "option": "Wool", "on_off": True}),
        ({**PLUG, **METER}, "plug", {"voltage": 230.1, "current": 0.25, "on_off": True}),
        (
            {"1/144/8": 850, "1/144/11": 120_000, "1/144/12": 7},
            "electrical_meter",
            {"voltage": 120.0, "current": 0.007},
        ),
        ({"1/144/4": 230_000, "1/144/11": 0}, "x_sensor", {"voltage": 230.0}),
        ({"1/2820/1291": -400, "1/2820/1541": 8}, "electrical_meter", {"power": -50.0}),
        (
            {"1/29/0": [{"0": 43}], "1/514/0": 0, "1/514/2": 60, "1/514/3": 60},
            "fan",
            {"fan_speed": 0.0, "on_off": False},
        ),
        ({"1/153/0": 3, "1/153/48": 70}, "x_sensor", {"plugged_in": True, "running": True, "battery": 70.0}),
        ({"1/87/2": 1, **COLD}, "x_setting", {"problem": True}),
        ({**PLUG, "1/319683586/0": 2_500_000, "1/319683586/1024": 4200}, "plug", {"energy": 2.5, "power": 4.2}),
        (
            {
                **PLUG,
                "1/308149265/308084769": 1500,
                "1/308149265/308084770": 250,
                "1/308149265/308084771": 575,
                "1/308149265/308084772": 2301,
            },
            "plug",
            {"energy": 1.5, "current": 0.25, "power": 57.5, "voltage": 230.1},
        ),
        (
            {"1/29/0": [{"0": 0x0301}], "1/513/0": 1620, "1/319486977/319422488": 40},
            "thermostat",
            {"measurement": 40.0},
        ),
        (
            {"1/29/0": [{"0": 0x0302}], "1/1026/0": 1620, "1/319486977/319422484": 1008.5},
            "temperature_sensor",
            {"pressure": 1008.5},
        ),
        (COLD, "x_setting", {"number": -18.0}),
        (PRESETS, "thermostat", {"preset_mode": "Home"}),
        ({**PRESETS, "1/513/78": None}, "thermostat", {"preset_mode": None}),
        (WARM, "x_setting", {"option": "High"}),
        ({**WARM, "1/86/4": 7}, "x_setting", {"option": None}),
        ({"1/153/0": 6}, "x_sensor", {"plugged_in": None, "running": False, "problem": True}),
        (CHARGER, "x_setting", {"on_off": True, "option": "Solar"}),
        ({**CHARGER, "1/153/1": 3}, "x_setting", {"on_off": False}),
        (PUMP, "pump", {"level": 100.0, "running": True, "problem": False}),
        ({**PUMP, "1/8/0": 50, "1/512/16": 2}, "pump", {"level": 25.0, "running": False, "problem": True}),
        ({"1/29/0": [{"0": 0x050F}], "1/148/4": 40}, "water_heater", {"measurement": 40.0}),
    ],
)
def test_attributes_become_readings(
    attributes: dict[str, object], service_type: str, values: dict[str, PlainValue]
) -> None:
    device = only_device(attributes)
    (part,) = device.device.parts
    assert part.service_type == service_type
    assert readings(device).items() >= values.items()


@pytest.mark.parametrize(
    ("types", "name"),
    [
        ((0x0075, 0x0011), "dishwasher"),
        ((0x0078,), "cooktop"),
        ((0x0078, 0xFFF10001), "0xFFF10001, cooktop"),  # as a policy reads the last word
        ((0x010A, 0x0011), ""),  # a plug, as its type says
        ((0xFFF10001,), "0xFFF10001"),
    ],
)
def test_a_device_of_a_type_without_a_word_has_the_name_that_people_use(types: tuple[int, ...], name: str) -> None:
    device = only_device({"1/29/0": [{"0": one, "1": 1} for one in types], "1/6/0": True})
    assert [one.advertised for one in device.device.parts] == [name]


def test_a_filter_is_a_part_beside_its_purifier() -> None:
    device = only_device({"1/29/0": [{"0": 0x002D}], "1/514/0": 0, "1/113/0": 12, "1/113/2": 1, "1/114/2": 0})
    assert [(one.id, one.name, one.service_type) for one in device.device.parts] == [
        ("1", "", "fan"),
        ("1-dust_filter", "Dust filter", "x_sensor"),
        ("1-carbon_filter", "Carbon filter", "x_sensor"),
    ]
    assert readings(device, "1-dust_filter") == {"measurement": 12.0, "problem": True}
    assert readings(device, "1-carbon_filter") == {"problem": False}


def test_a_chime_has_sounds_and_a_button_that_plays_the_selected_one() -> None:
    chime = only_device(CHIME)
    assert [(one.id, one.name, one.service_type) for one in chime.device.parts] == [
        ("1", "", "siren"),
        ("1-play", "Play", "x_setting"),
    ]
    assert readings(chime) == {"siren_tone": "Alert"}
    assert encoded(chime, "siren_tone", "Ding Dong") == (AttributeWrite(0x0556, 1, 1),)
    assert encoded(chime, "push", True, "1-play") == (ClusterInvocation(0x0556, "PlayChimeSound"),)


def test_an_alarm_of_a_dishwasher_is_a_part_beside_its_operation() -> None:
    washer = only_device({"1/29/0": [{"0": 0x0075}], "1/93/2": 4, "1/96/4": 3})
    assert [one.name for one in washer.device.parts] == ["", "Alarm"]
    assert readings(washer, "1-alarm") == {"problem": True}


def test_a_thermostat_tells_how_much_it_heats_and_how_cold_it_is_outside() -> None:
    """As Eberle's UTE 3000 and Longan-link's thermostat; the temperature outside is none of the room."""
    thermostat = only_device({"1/29/0": [{"0": 0x0301}], "1/513/0": 2250, "1/513/1": 1250, "1/513/8": 100})
    assert readings(thermostat).items() >= {"local_temperature": 22.5, "measurement": 100.0}.items()
    assert readings(thermostat, "1-outdoor_temperature") == {"measurement": 12.5}


def test_the_offset_of_a_thermometer_and_the_hold_time_of_a_motion_sensor_are_settings() -> None:
    """As of Aqara's W600 and Heiman's M1."""
    thermostat = only_device({"1/29/0": [{"0": 0x0301}], "1/513/0": 1900, "1/513/16": -15})
    assert readings(thermostat, "1-temperature_offset") == {"number": -1.5}
    assert encoded(thermostat, "number", 0.5, "1-temperature_offset") == (AttributeWrite(513, 16, 5),)
    motion = {"1/29/0": [{"0": 0x0107}], "1/1030/0": 0, "1/1030/3": 70, "1/1030/4": {"0": 6, "1": 3600, "2": 60}}
    _, held = only_device(motion).device.parts
    assert (held.name, held.service_type, held.capabilities[0].bounds) == ("Hold time", "x_setting", (6.0, 3600.0))
    assert encoded(only_device(motion), "number", 30.0, "1-hold_time") == (AttributeWrite(1030, 3, 30),)
    _, held = only_device({**motion, "1/1030/4": None}).device.parts
    assert held.capabilities[0].bounds == (0.0, 65_535.0)


@pytest.mark.parametrize(
    ("attributes", "capability", "value", "cluster", "command", "payload"),
    [
        (VACUUM, "vacuum", "cleaning", 84, "ChangeToMode", {"newMode": 6}),
        ({**VACUUM, "1/97/4": 2}, "vacuum", "cleaning", 97, "Resume", {}),
        (PLAYER, "playback", "paused", 0x0506, "Pause", {}),
        (VACUUM, "vacuum", "idle", 84, "ChangeToMode", {"newMode": 5}),
        (VACUUM, "vacuum", "returning", 97, "GoHome", {}),
        (VACUUM, "vacuum", "paused", 97, "Pause", {}),
        (VACUUM, "option", "Quiet", 85, "ChangeToMode", {"newMode": 0}),
        (WASHER, "option", "Cotton", 81, "ChangeToMode", {"newMode": 3}),
        (PRESETS, "preset_mode", "unoccupied", 513, "SetActivePresetRequest", {"presetHandle": "Ag=="}),
        (COLD, "number", -16.5, 86, "SetTemperature", {"targetTemperature": -1650}),
        (WARM, "option", "Low", 86, "SetTemperature", {"targetTemperatureLevel": 0}),
        (CHARGER, "on_off", False, 153, "Disable", {}),
        (
            CHARGER,
            "on_off",
            True,
            153,
            "EnableCharging",
            {"chargingEnabledUntil": None, "minimumChargeCurrent": 6000, "maximumChargeCurrent": 32_000},
        ),
        (HOB, "on_off", False, 6, "Off", {}),
        ({**HOB, "1/6/65532": 0}, "on_off", True, 6, "On", {}),  # some list Off alone, and take both
        (SPEAKER, "muted", False, 6, "On", {}),
        (SPEAKER, "muted", True, 6, "Off", {}),
        (CLOSURE, "movement", "closed", 260, "MoveTo", {"position": 0}),
        ({**CLOSURE, "1/260/65532": 3}, "movement", "open", 260, "MoveTo", {"position": 1, "latch": False}),
        ({**CLOSURE, "1/260/5": 2, "1/260/65532": 3}, "movement", "closed", 260, "MoveTo", {"position": 0}),
        ({**CLOSURE, "1/260/5": 1, "1/260/65532": 3}, "movement", "open", 260, "MoveTo", {"position": 1}),
        (CLOSURE, "movement", "stopped", 260, "Stop", {}),
        (PANEL, "position", 25.0, 261, "SetTarget", {"position": 7500, "latch": False}),
    ],
)
def test_commands_become_those_of_the_cluster(
    attributes: dict[str, object],
    capability: str,
    value: PlainValue,
    cluster: int,
    command: str,
    payload: dict[str, object],
) -> None:
    (args,) = orders(attributes, capability, value)
    assert (args["cluster_id"], args["command_name"], args["payload"]) == (cluster, command, payload)


CABINET = {**COLD, "1/29/0": [{"0": 0x0071, "1": 1}]}


@pytest.mark.parametrize(
    ("attributes", "asks"),
    [
        (HOB, True),
        ({**WARM, "1/29/0": [{"0": 0x0077, "1": 1}]}, True),
        ({**WASHER, "1/29/0": [{"0": 0x0079, "1": 1}]}, True),
        ({**WASHER, "1/29/0": [{"0": 0x007B, "1": 1}]}, True),
        ({**CABINET, "1/72/4": 0}, True),
        ({**CABINET, "1/73/0": [{"0": "Bake", "1": 1}], "1/73/1": 1}, True),
        (CABINET, False),
        (WASHER, False),
    ],
)
def test_a_cooking_appliance_always_asks(attributes: dict[str, object], *, asks: bool) -> None:
    (part,) = only_device(attributes).device.parts
    assert is_declared(DevicePart(id="1", part=part, routes=())) is asks


def test_a_further_setting_of_an_appliance_is_a_part_beside_it_that_asks_as_it_does() -> None:
    washer = only_device({**WARM, **WASHER, "1/83/0": ["Off", "1200"], "1/83/1": 1})
    assert [(one.id, one.name, one.service_type) for one in washer.device.parts] == [
        ("1", "", "x_setting"),
        ("1-temperature", "Temperature", "x_setting"),
        ("1-spin_speed", "Spin speed", "x_setting"),
    ]
    assert [readings(washer, f"1{end}")["option"] for end in ("", "-temperature", "-spin_speed")] == [
        "Wool",
        "High",
        "1200",
    ]
    assert encoded(washer, "option", "Off", "1-spin_speed") == (AttributeWrite(83, 1, 0),)
    oven = only_device({**WARM, "1/29/0": [{"0": 0x0071}], "1/73/0": [{"0": "Bake", "1": 1}], "1/73/1": 1})
    assert [is_declared(DevicePart(id=one.id, part=one, routes=())) for one in oven.device.parts] == [True, True]


@pytest.mark.parametrize(
    ("attributes", "name", "capability", "reading", "value", "order"),
    [
        # As python-matter-server's mock washer, Home Assistant's microwave oven, Eve's thermostats and Aqara's P2.
        ({**WASHER, "1/83/2": 1, "1/83/3": [1, 2]}, "rinses", "option", "normal", "extra", AttributeWrite(83, 2, 2)),
        (
            {"1/29/0": [{"0": 0x0079}], "1/95/0": 30, "1/95/1": 86_400},
            "cook_time",
            "number",
            30.0,
            90.0,
            ClusterInvocation(95, "SetCookingParameters", {"cookTime": 90}),
        ),
        ({"1/516/1": 0, **PRESETS}, "child_lock", "on_off", False, True, AttributeWrite(516, 1, 1)),
        ({"1/69/0": True, "1/128/0": 2, "1/128/1": 3}, "sensitivity", "option", "3", "1", AttributeWrite(128, 0, 0)),
    ],
)
def test_a_setting_beside_the_function_of_a_device_is_a_part(
    attributes: dict[str, object],
    name: str,
    capability: str,
    reading: PlainValue,
    value: PlainValue,
    order: AttributeWrite | ClusterInvocation,
) -> None:
    device = only_device(attributes)
    assert device.device.parts[-1].service_type == "x_setting"
    assert readings(device, f"1-{name}") == {capability: reading}
    assert encoded(device, capability, value, f"1-{name}") == (order,)


@pytest.mark.parametrize(("tag", "service_type"), [(0, "window_covering"), (5, "closure")])
def test_a_closure_that_covers_a_window_is_a_blind_with_its_panels(tag: int, service_type: str) -> None:
    """Gates and garage doors always ask, and blinds do not."""
    tags = [{"0": None, "1": 0x44, "2": tag}, {"0": None, "1": 0x46, "2": 3}]
    panel = {path.replace("1/", "2/", 1): value for path, value in PANEL.items()}
    device = only_device({**CLOSURE, **panel, "1/29/3": [2], "1/29/4": tags})
    assert [one.service_type for one in device.device.parts] == [service_type, service_type]
    assert [row.capability for part in "12" for row in device.rows[part][1]] == ["movement", "position"]


def test_an_operation_has_a_button_for_each_command_that_it_accepts() -> None:
    """As the Dishwasher of Matterbridge's example, which is paused, stopped, started and resumed."""
    washer = only_device({**WASHER, "1/96/65529": [0, 1, 2, 3]})
    assert [one.name for one in washer.device.parts] == ["", "Pause", "Stop", "Start", "Resume"]
    assert encoded(washer, "push", True, "1-start") == (ClusterInvocation(96, "Start"),)
    assert [one.name for one in only_device({**WASHER, "1/96/65529": [1]}).device.parts] == ["", "Stop"]


def area(number: int, name: str | None) -> dict[str, object]:
    return {"0": number, "1": 4, "2": {"0": None if name is None else {"0": name, "1": 0, "2": 20}, "1": None}}


AREAS = {"1/336/0": [area(7, "Kitchen"), area(8, "Room"), area(9, "Room"), area(10, None)], "1/336/2": [8]}


def test_a_vacuum_cleaner_cleans_the_area_that_is_selected_or_everywhere() -> None:
    """As those of Ecovacs, Eufy and Roborock list the rooms of their map."""
    vacuum = only_device({**VACUUM, **AREAS, "1/336/65529": [0]})
    assert [(one.id, one.name) for one in vacuum.device.parts] == [("1", ""), ("1-area", "Area")]
    (option,) = vacuum.device.parts[1].capabilities
    assert option.options == ("everywhere", "Kitchen", "Room", "Room 9", "Area 10")
    assert readings(vacuum, "1-area") == {"option": "Room"}
    assert readings(only_device({**VACUUM, **AREAS, "1/336/2": []}), "1-area") == {"option": "everywhere"}
    assert readings(only_device({**VACUUM, **AREAS, "1/336/2": [7, 8]}), "1-area") == {"option": None}
    for name, areas in (("Room 9", [9]), ("everywhere", [])):
        assert encoded(vacuum, "option", name, "1-area") == (
            ClusterInvocation(336, "SelectAreas", {"newAreas": areas}),
        )


def test_an_oven_tells_whether_it_runs() -> None:
    assert readings(only_device({**CABINET, "1/72/4": 1})) == {"number": -18.0, "running": True, "problem": False}


def test_an_impossible_command_to_a_vacuum_cleaner_is_refused() -> None:
    with pytest.raises(RefusedError, match="cleaning"):
        orders({**VACUUM, "1/97/65529": [0]}, "vacuum", "returning")


@pytest.mark.parametrize(("types", "is_dimmed"), [((256,), False), ((266, 1296), False), ((266, 267), True)])
def test_a_light_or_plug_that_is_only_switched_has_no_level(types: tuple[int, ...], *, is_dimmed: bool) -> None:
    switched = {"1/29/0": [{"0": one} for one in types], "1/6/0": True, "1/8/0": 254}
    assert ("level" in readings(only_device(switched))) is is_dimmed


def test_an_appliance_that_can_only_be_turned_off_is_not_turned_on() -> None:
    with pytest.raises(RefusedError, match="only be turned off"):
        orders(HOB, "on_off", True)


def test_a_temperature_is_kept_within_its_limits() -> None:
    with pytest.raises(RefusedError, match="-15"):
        orders(COLD, "number", 4.0)


def test_a_mode_that_cannot_be_changed_is_only_reported() -> None:
    (part,) = only_device({**WASHER, "1/81/65529": []}).device.parts
    assert not next(one for one in part.capabilities if one.name == "option").settable


@pytest.mark.parametrize(
    "result", [{"status": 1, "statusText": "no"}, {"commandResponseState": {"errorStateID": 3}}, [{"Status": 135}]]
)
def test_a_command_that_an_appliance_answers_with_an_error_is_refused(result: object) -> None:
    with pytest.raises(RefusedError):
        check_result("vacuum", result)


@pytest.mark.parametrize("result", [None, {}, {"status": 0}, {"commandResponseState": {"errorStateID": 0}}])
def test_a_command_that_succeeds_is_not(result: object) -> None:
    check_result("vacuum", result)


def test_a_lock_is_only_moved_as_a_lock() -> None:
    assert "on_off" not in readings(only_device({**LOCK, "1/6/0": True}))


@pytest.mark.parametrize(
    ("attributes", "name"),
    [
        ({"1/65/0": [{"0": "room", "1": "hall"}, {"0": "name", "1": "Left lamp"}]}, "Left lamp"),
        ({"1/64/0": [{"0": "Button", "1": "Up"}]}, "Up"),
        ({"1/64/0": [{"0": "id", "1": "2"}, {"0": "orientation", "1": "bottom"}]}, "bottom"),
        ({"1/64/0": [{"0": "room", "1": "hall"}, {"0": "orientation", "1": "North"}]}, ""),
        ({"1/29/4": [{"0": None, "1": 7, "2": 2}, {"0": None, "1": 8, "2": 2}]}, "2 top"),
        (
            {"1/29/4": [{"1": 8, "2": 6, "3": "1"}, {"1": 0x43, "2": 3}, {"1": 0x43, "2": 8, "3": "wheel"}]},
            "column 1 up wheel",
        ),
        ({"1/29/4": [{"0": None, "1": 0x41, "2": 1}]}, "freezer"),
        ({"1/29/4": [{"1": 8, "2": 99}, {"1": 99, "2": 1}, 7, {"1": None}]}, ""),
    ],
)
def test_a_part_is_named_by_its_labels_or_tags(attributes: dict[str, object], name: str) -> None:
    (part,) = only_device({"1/59/0": 2, "1/59/65532": 2, **attributes}).device.parts
    assert part.name == name


@pytest.mark.parametrize(
    ("attributes", "names"),
    [
        ({"1/29/0": [{"0": 0x0101}], "1/6/0": True}, ["", "Dimming Edge"]),
        ({"1/59/0": 2, "1/64/0": [{"0": "Button", "1": "Up"}]}, ["Up", "Dimming Edge"]),
        ({"1/29/0": [{"0": 0x0104}]}, ["Dimming Edge"]),
    ],
)
def test_a_plain_mode_is_a_setting_of_its_own(attributes: dict[str, object], names: list[str]) -> None:
    """As those of Inovelli's VTM31, at its light, at its buttons, and at endpoints with nothing else."""
    mode = {"1/80/0": "Dimming Edge", "1/80/2": [{"0": "Leading", "1": 0}, {"0": "Trailing", "1": 1}], "1/80/3": 1}
    device = only_device({**attributes, **mode})
    assert [one.name for one in device.device.parts] == names
    assert device.device.parts[-1].service_type == "x_setting"
    assert readings(device, "1-mode") == {"option": "Trailing"}
    assert encoded(device, "option", "Leading", "1-mode") == (ClusterInvocation(80, "ChangeToMode", {"newMode": 0}),)


def test_an_endpoint_of_no_bridge_is_of_its_node() -> None:
    device = only_device({**PLUG, "1/57/17": True})
    assert [one.id for one in device.device.parts] == ["1"]


def test_the_guide_names_the_versions_of_the_schema() -> None:
    assert f"Schema versions {OLDEST_SCHEMA} to {SCHEMA}" in section_in(guide("protocols"), "Matter")
