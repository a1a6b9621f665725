"""What nodes of a Matter server become: devices with parts, and readings in the units of the vocabulary."""

from collections.abc import Mapping

import pytest
from tests.gateways.checked_command import checked_command

from homebot.conventions.capability_row import writer_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError, WrongCodeError
from homebot.gateways.announced.gateway_device import can_report
from homebot.integrations.matter.formats.endpoint import AttributeWrite, MatterOrders
from homebot.integrations.matter.gateway.node import MatterNode, NodeDevice

LAMP = {
    "1/29/0": [{"0": 0x010D, "1": 1}],
    "1/6/0": True,
    "1/8/0": 127,
    "1/8/2": 1,
    "1/8/3": 254,
    "1/768/0": 127,
    "1/768/1": 254,
    "1/768/3": 24939,
    "1/768/4": 24701,
    "1/768/7": 250,
    "1/768/8": 2,
    "1/768/16385": 2,
    "1/768/16395": 153,
    "1/768/16396": 500,
    "1/768/65532": 25,
}
LOCK = {"1/29/0": [{"0": 0x000A, "1": 1}], "1/257/0": 1, "1/257/51": False, "1/257/65532": 0}
COVER = {"1/29/0": [{"0": 0x0202, "1": 1}], "1/258/10": 0, "1/258/14": 2500, "1/258/65532": 5}
THERMOSTAT = {
    "1/29/0": [{"0": 0x0301, "1": 1}],
    "1/513/0": 2150,
    "1/513/18": 2000,
    "1/513/21": 700,
    "1/513/22": 3000,
    "1/513/28": 4,
    "1/513/41": 0,
    "1/513/65532": 1,
}


def node(attributes: Mapping[str, object], **more: object) -> MatterNode:
    root = {"0/29/0": [{"0": 22, "1": 1}], "0/40/1": "Acme", "0/40/3": "Thing 3000", "0/40/15": "SN-7700"}
    return MatterNode.parse(
        {"node_id": 5, "available": True, "is_bridge": False, "attributes": {**root, **attributes}, **more}
    )


def only_device(attributes: Mapping[str, object]) -> NodeDevice:
    (device,) = node(attributes).devices()
    return device


def readings(device: NodeDevice, part: str = "1") -> dict[str, PlainValue]:
    described = next(one for one in device.device.parts if one.id == part)
    endpoint, rows = device.rows[part]
    found = {row.capability: row.read(endpoint) for row in rows if row.read is not None}
    assert all(can_report(described, name, value) for name, value in found.items())
    return found


def orders(attributes: Mapping[str, object], name: str, value: PlainValue, code: str = "") -> list[dict[str, object]]:
    return [dict(one.server_call(5, 1)[1]) for one in encoded(only_device(attributes), name, value, code=code)]


def encoded(device: NodeDevice, name: str, value: PlainValue, part: str = "1", code: str = "") -> MatterOrders:
    endpoint, rows = device.rows[part]
    described = next(one for one in device.device.parts if one.id == part)
    return writer_of(rows, name)(endpoint, checked_command(described, name, value, code=code))


@pytest.mark.parametrize(
    ("attributes", "service_type", "values"),
    [
        (LAMP, "light", {"on_off": True, "level": 50.0, "color_temperature": 4000.0, "color": None}),
        ({**LAMP, "1/768/8": 0, "1/768/16385": 0}, "light", {"color": (180.0, 100.0), "color_temperature": None}),
        ({**LAMP, "1/8/0": None}, "light", {"level": None}),
        (LOCK, "door_lock", {"lock": "locked"}),
        ({**LOCK, "1/257/0": None}, "door_lock", {"lock": None}),
        (COVER, "window_covering", {"position": 75.0, "movement": "open"}),
        ({**COVER, "1/258/14": 10_000}, "window_covering", {"position": 0.0, "movement": "closed"}),
        ({**COVER, "1/258/10": 10}, "window_covering", {"movement": "closing"}),
        (
            THERMOSTAT,
            "thermostat",
            {
                "local_temperature": 21.5,
                "heating_setpoint": 20.0,
                "thermostat_mode": "heat",
                "thermostat_action": "idle",
            },
        ),
        ({"1/29/0": [{"0": 0x0302, "1": 1}], "1/1026/0": -1250}, "temperature_sensor", {"temperature": -12.5}),
        ({"1/29/0": [{"0": 0x0307, "1": 1}], "1/1029/0": 4650}, "humidity_sensor", {"humidity": 46.5}),
        ({"1/29/0": [{"0": 0x0106, "1": 1}], "1/1024/0": 20_001}, "light_sensor", {"illuminance": 100.0}),
        ({"1/29/0": [{"0": 0x0305, "1": 1}], "1/1027/0": 1013}, "pressure_sensor", {"pressure": 1013.0}),
        ({"1/29/0": [{"0": 0x0015, "1": 1}], "1/69/0": True}, "contact_sensor", {"contact": False}),
        ({"1/29/0": [{"0": 0x0043, "1": 1}], "1/69/0": True}, "water_leak_detector", {"water_leak": True}),
        ({"1/29/0": [{"0": 0x0107, "1": 1}], "1/1030/0": 1}, "occupancy_sensor", {"occupancy": True}),
        ({"1/29/0": [{"0": 0x0076, "1": 1}], "1/92/1": 2, "1/92/2": 0}, "smoke_co_alarm", {"smoke": True}),
        ({"1/29/0": [{"0": 0x0076, "1": 1}], "1/92/6": False, "1/92/7": 1}, "smoke_co_alarm", {"problem": True}),
        (
            {"1/29/0": [{"0": 0x0510, "1": 1}, {"0": 0x010A, "1": 1}], "1/6/0": False, "1/144/8": 70_500},
            "plug",
            {"on_off": False, "power": 70.5},
        ),
        (
            {"1/29/0": [{"0": 0x010A, "1": 1}], "1/6/0": True, "1/319486977/319422474": 12.5},
            "plug",
            {"power": 12.5},
        ),
        ({"1/29/0": [{"0": 0x0510, "1": 1}], "1/145/1": {"0": 2_500_000}}, "electrical_meter", {"energy": 2.5}),
        ({"1/29/0": [{"0": 0x002C, "1": 1}], "1/1066/0": 7.5, "1/1066/8": 4}, "air_quality_sensor", {"pm25": 7.5}),
        (
            {"1/29/0": [{"0": 0x002C, "1": 1}], "1/1070/0": 120.0, "1/1070/8": 1},
            "air_quality_sensor",
            {"measurement": 120.0},
        ),
        (
            {"1/29/0": [{"0": 0x002B, "1": 1}], "1/514/0": 2, "1/514/1": 2, "1/514/2": 50, "1/514/3": 50},
            "fan",
            {"on_off": True, "fan_speed": 50.0, "fan_mode": "medium"},
        ),
        (
            {"1/29/0": [{"0": 0x0042, "1": 1}], "1/129/4": 1, "1/129/9": 4, "1/129/65532": 0},
            "water_valve",
            {"valve": "open", "problem": True},
        ),
    ],
)
def test_attributes_become_readings(
    attributes: dict[str, object], service_type: str, values: dict[str, PlainValue]
) -> None:
    device = only_device(attributes)
    (part,) = device.device.parts
    assert (part.id, part.service_type) == ("1", service_type)
    assert readings(device).items() >= values.items()


@pytest.mark.parametrize(
    ("attributes", "capability", "value", "command", "payload"),
    [
        (LAMP, "on_off", False, "Off", {}),
        (LAMP, "level", 50.0, "MoveToLevelWithOnOff", {"level": 127}),
        ({**LAMP, "1/29/0": [{"0": 0x0303}]}, "level", 50.0, "MoveToLevelWithOnOff", {"level": 100}),
        (LAMP, "level", 0.1, "MoveToLevelWithOnOff", {"level": 1}),
        (LAMP, "color_temperature", 4000.0, "MoveToColorTemperature", {"colorTemperatureMireds": 250}),
        (LAMP, "color", (180.0, 100.0), "MoveToHueAndSaturation", {"hue": 127, "saturation": 254}),
        (COVER, "position", 75.0, "GoToLiftPercentage", {"liftPercent100thsValue": 2500}),
        (COVER, "movement", "stopped", "StopMotion", {}),
        (LOCK, "lock", "unlocked", "UnlockDoor", {}),
        ({**LOCK, "1/257/65532": 4096}, "lock", "unlocked", "UnboltDoor", {}),
        ({**LOCK, "1/257/65532": 4096}, "lock", "open", "UnlockDoor", {}),
    ],
)
def test_commands_become_those_of_the_cluster(
    attributes: dict[str, object], capability: str, value: PlainValue, command: str, payload: dict[str, object]
) -> None:
    args, *_ = orders(attributes, capability, value)
    assert (args["node_id"], args["endpoint_id"], args["command_name"]) == (5, 1, command)
    sent = args["payload"]
    assert isinstance(sent, dict)
    assert sent.items() >= payload.items()


@pytest.mark.parametrize(("capability", "value"), [("color_temperature", 4000.0), ("color", (180.0, 100.0))])
def test_a_colour_turns_a_lamp_on_after_it_was_set(capability: str, value: PlainValue) -> None:
    """A colour by itself is only remembered by a lamp that is off."""
    color, on = orders(LAMP, capability, value)
    assert color["payload"].items() >= {"optionsMask": 1, "optionsOverride": 1}.items()  # type: ignore[attr-defined]
    assert on["command_name"] == "On"
    assert len(orders({key: one for key, one in LAMP.items() if "/6/" not in key}, capability, value)) == 1


def test_gases_without_a_word_of_their_own_are_measurements_beside_the_quality_of_the_air() -> None:
    device = only_device(
        {
            "1/29/0": [{"0": 0x002C, "1": 1}],
            "1/91/0": 2,
            "1/1043/0": 14.5,
            "1/1043/8": 1,
            "1/1045/0": 31.0,
            "1/1045/8": 4,
            "1/1067/0": None,
            "1/1067/8": 3,
            "1/1071/0": 88.0,
            "1/1071/8": 7,
        }
    )
    assert [(one.id, one.name, one.service_type) for one in device.device.parts] == [
        ("1", "", "air_quality_sensor"),
        ("1-nitrogen_dioxide", "Nitrogen dioxide", "air_quality_sensor"),
        ("1-ozone", "Ozone", "air_quality_sensor"),
        ("1-formaldehyde", "Formaldehyde", "air_quality_sensor"),
        ("1-radon", "Radon", "air_quality_sensor"),
    ]
    found = [(readings(device, one.id)["measurement"], one.capabilities[0].unit) for one in device.device.parts[1:]]
    assert found == [(14.5, "ppb"), (31.0, "µg/m³"), (None, "mg/m³"), (88.0, "Bq/m³")]


def test_a_setpoint_is_written_in_hundredths_and_within_its_limits() -> None:
    assert orders(THERMOSTAT, "heating_setpoint", 21.5) == [{"node_id": 5, "attribute_path": "1/513/18", "value": 2150}]
    with pytest.raises(RefusedError, match="7"):
        orders(THERMOSTAT, "heating_setpoint", 5.0)


def test_an_air_conditioner_dries_and_blows_although_no_feature_says_that_it_can() -> None:
    """As Panasonic's, which Home Assistant knows by their numbers."""
    cooler = {**THERMOSTAT, "1/29/0": [{"0": 0x0072}], "1/513/28": 7, "1/513/65532": 2}
    assert readings(only_device(cooler))["thermostat_mode"] == "fan_only"
    assert encoded(only_device(cooler), "thermostat_mode", "dry") == (AttributeWrite(513, 28, 8),)
    with pytest.raises(RefusedError):
        encoded(only_device({**cooler, "1/29/0": [{"0": 0x0301}]}), "thermostat_mode", "dry")


def test_a_lock_that_requires_a_code_gets_it_in_a_timed_command_and_no_text_shows_it() -> None:
    coded = {**LOCK, "1/257/51": True}
    with pytest.raises(WrongCodeError, match="needs a code"):
        orders(coded, "lock", "unlocked")
    (args,) = orders(coded, "lock", "unlocked", "1234")
    assert args["payload"] == {"PINCode": "MTIzNA=="}
    assert args["timed_request_timeout_ms"] == 1000
    (order,) = encoded(only_device(coded), "lock", "unlocked", code="1234")
    assert only_device(coded).device.parts[0].capabilities[0].code == "digits"
    assert order.is_secret
    assert "MTIzNA" not in repr(order)


def test_a_device_is_known_by_its_serial_number_and_hardware_addresses() -> None:
    interfaces = [{"0": "eth0", "4": "/mQDt/2Q", "7": 2}, {"0": "lo", "4": "AAAAAAAA"}, {"4": "?"}, 7]
    device = only_device({**LAMP, "0/51/0": interfaces}).device
    assert device.identifiers == ("mac:fe6403b7fd90", "id:SN-7700")
    assert dict(device.metadata) == {"manufacturer": "Acme", "model": "Thing 3000"}
    assert device.name == "Thing 3000"


@pytest.mark.parametrize("serial", ["TEST_SN", "1234567890", "00000001", "0123456789ABCDEF", "FFFFFFFF", "Thing 3000"])
def test_a_serial_number_that_many_have_identifies_nothing(serial: str) -> None:
    assert only_device({**LAMP, "0/40/15": serial}).device.identifiers == ()


def test_bridged_endpoints_are_devices_of_their_own_with_the_endpoints_they_are_composed_of() -> None:
    bridge = node(
        {
            "0/29/3": [40, 41, 42, 43],
            "42/29/0": [{"0": 19, "1": 2}],
            "42/29/3": [40, 41],
            "42/57/5": "Heater plug",
            "42/57/17": False,
            "40/29/0": [{"0": 266, "1": 2}],
            "40/6/0": False,
            "41/29/0": [{"0": 770, "1": 2}],
            "41/1026/0": 2000,
            "43/29/0": [{"0": 19, "1": 2}, {"0": 256, "1": 2}],
            "43/57/15": "L1-4711",
            "43/6/0": True,
        }
    )
    itself, plug, lamp = bridge.devices()
    assert (itself.device.key, itself.device.parts) == ("node-5", ())
    assert (plug.device.key, plug.device.name) == ("node-5-42", "Heater plug")
    assert [(one.id, one.service_type) for one in plug.device.parts] == [
        ("40", "plug"),
        ("41", "temperature_sensor"),
    ]
    assert plug.device.metadata["via_device"] == "node-5"
    assert lamp.device.identifiers == ("id:L1-4711",)
    assert [bridge.is_reachable(one) for one in (itself, plug, lamp)] == [True, False, True]


def test_the_battery_is_a_part_of_its_own() -> None:
    device = only_device({**LOCK, "0/47/12": 150, "0/47/14": 1, "0/47/26": 0, "0/47/65532": 2})
    (battery,) = (one for one in device.device.parts if one.category == "diagnostic")
    assert (battery.id, battery.service_type) == ("0-battery", "x_battery")
    assert readings(device, "0-battery") == {"battery": 75.0, "battery_low": True, "battery_charging": None}


@pytest.mark.parametrize("data", [7, {}, {"node_id": 0}, {"node_id": True}, {"node_id": 3, "attributes": []}])
def test_an_invalid_node_is_refused(data: object) -> None:
    with pytest.raises(WireError):
        MatterNode.parse(data)


def test_attributes_with_an_invalid_path_are_left_out() -> None:
    found = node({"1/6": True, "x/y/z": 1, "70000/6/0": True, **LOCK})
    assert set(found.endpoints) == {0, 1}
