"""Sensors are read through the libraries for their formats.

The advertisements are those of real devices, from the tests of the libraries: Bluetooth-Devices/xiaomi-ble, bthome-ble,
govee-ble and inkbird-ble ``tests/test_parser.py``, Home Assistant's ``tests/components/govee_ble``, and ruuvitag-ble
0.4.0 ``tests/test_v5.py``; the one of Qingping's door sensor follows qingping-ble 1.3.0.
"""

from importlib.util import find_spec

import pytest

from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, full_uuid
from homebot.conventions.description import AutoExpiry
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.sensor_libraries.formats import MOMENT, SensorLibraryParser

pytestmark = pytest.mark.skipif(not find_spec("xiaomi_ble"), reason="xiaomi_ble is not installed")

XIAOMI, RUUVI, GOVEE = full_uuid("fe95"), 0x0499, 0xEC88
ENCRYPTED = "5A:58:2D:34:12:5F"
KEYS = {ENCRYPTED: bytes.fromhex("814aac74c4f17b6c1581e1ab87816b99")}
THERMOMETER = Advertisement(
    "58:2D:34:35:93:21", -60, "Test", service_data={XIAOMI: bytes.fromhex("5020aa01da219335342d580d1004fe004802")}
)
SEALED = Advertisement(
    ENCRYPTED, -60, "Test", service_data={XIAOMI: bytes.fromhex("5858480b685f1234 2d585a0b1841e2aa000e00a4964fb5")}
)
TAG = Advertisement(
    "DE:AD:7B:3F:EF:AF",
    -60,
    manufacturer_data={RUUVI: bytes.fromhex("0505a060a0c89afd34028cff006376726976dead7b3fefaf")},
)
HYGROMETER = Advertisement(
    "A4:C1:38:DD:DB:F8",
    -63,
    "GVH5075_DBF8",
    manufacturer_data={GOVEE: bytes.fromhex("00034db26400")},
    service_uuids=(full_uuid("ec88"),),
)
FRIDGE = Advertisement(
    "AA:BB:CC:DD:EE:FF",
    -60,
    "sps",
    manufacturer_data={2044: bytes.fromhex("c71200c83d5606")},
    service_uuids=(full_uuid("fff0"),),
)
BUTTON = Advertisement(
    "C1:37:37:32:0F:45",
    -36,
    "GV51225634",
    manufacturer_data={
        GOVEE: bytes.fromhex("0108f30ad232393756340105"),
        0xEF88: bytes.fromhex("f30a0000648248e860206225 88c02fd258cb3f1b8544d930"),
    },
)

MOTION = Advertisement(
    "C1:37:37:32:0F:45",
    -36,
    "GV5121195A",
    manufacturer_data={0xEF88: bytes.fromhex("59940000f0b91937ae50b6372c866ac2f3d061e717c02cef")},
)
VIBRATION = Advertisement(
    "D3:32:39:37:2F:68",
    -67,
    "GV51242F68",
    manufacturer_data={0xEF88: bytes.fromhex("08a2000125c25957fd7a750ef234a218bb15467c5b737b04")},
)
NIGHT_LIGHT = Advertisement(
    "DE:70:E8:B2:39:0C", -60, "Test", service_data={XIAOMI: bytes.fromhex("4030dd032403000101")}
)
DOOR = Advertisement(
    "58:2D:34:10:20:30", -60, service_data={full_uuid("fdcd"): bytes.fromhex("0804302010342d58040102")}
)
BTHOME_V1_DEW = Advertisement(
    "A4:C1:38:8D:18:B3", -60, "ATC_8D18B3", service_data={full_uuid("181c"): bytes.fromhex("2308ca06")}
)
BTHOME_V1 = Advertisement(
    "A4:C1:38:8D:18:B2", -60, "ATC_8D18B2", service_data={full_uuid("181c"): bytes.fromhex("2302ca090303bf13")}
)
LOCK = Advertisement(
    "D7:1F:44:EB:8A:91",
    -60,
    "Test",
    service_data={XIAOMI: bytes.fromhex("50449e0643918aeb441fd70b000920020001807c442f61")},
)


def read(parser: SensorLibraryParser, advertisement: Advertisement) -> Broadcast:
    assert parser.concerns(advertisement)
    found = parser.read(advertisement, 0.0)
    assert found is not None
    return found


def values(found: Broadcast) -> dict[tuple[str, str], PlainValue]:
    return {(one.part, one.capability): one.value for one in found.values}


@pytest.mark.newest("ble-sensors")
@pytest.mark.parametrize(
    ("advertisement", "expected"),
    [
        (THERMOMETER, {("temperature", "temperature"): 25.4, ("humidity", "humidity"): 58.4}),
        (SEALED, {("humidity", "humidity"): 59.6}),
        (
            HYGROMETER,
            {("temperature", "temperature"): 21.6, ("humidity", "humidity"): 49.8, ("battery", "battery"): 100.0},
        ),
        (
            FRIDGE,
            {("temperature", "temperature"): 20.44, ("humidity", "humidity"): 48.07, ("battery", "battery"): 86.0},
        ),
        (BUTTON, {("battery", "battery"): 100.0, ("button_0", "press"): "single"}),
        (MOTION, {("battery", "battery"): 100.0, ("motion", "occupancy"): True}),
        (VIBRATION, {("battery", "battery"): 100.0, ("vibration", "vibration"): True}),
        (NIGHT_LIGHT, {("motion", "occupancy"): True}),
        (DOOR, {("door", "contact"): True, ("door_left_open", "problem"): True}),
        (BTHOME_V1, {("temperature", "temperature"): 25.06, ("humidity", "humidity"): 50.55}),
        (BTHOME_V1_DEW, {("dew_point", "temperature"): 17.38}),
        (
            LOCK,
            {("key_id", "value"): "Fingerprint key id 2", ("lock_method", "value"): "biometrics"}
            | {("lock", "unlocked"): True, ("lock_event", "press"): "unlock_outside_the_door"},
        ),
    ],
    ids=[
        "xiaomi",
        "xiaomi with a key",
        "govee",
        "inkbird",
        "button",
        "motion",
        "vibration",
        "night light",
        "door",
        "BTHome v1",
        "dew point",
        "lock",
    ],
)
def test_values_have_capabilities_and_units_of_the_vocabulary(
    advertisement: Advertisement, expected: dict[tuple[str, str], PlainValue]
) -> None:
    found = read(SensorLibraryParser(KEYS), advertisement)
    assert values(found) == expected
    assert {one.part for one in found.values} <= {one.id for one in found.parts}


def test_units_are_converted_or_stay_the_devices_own() -> None:
    """A RuuviTag says millivolts, and what it moved."""
    found = read(SensorLibraryParser({}), TAG)
    measured = values(found)
    assert measured["pressure", "pressure"] == 1013.54
    assert measured["voltage", "voltage"] == 2.395
    assert measured["acceleration_z", "measurement"] == -2.51
    units = {one.id: one.capabilities[0].unit for one in found.parts}
    assert (units["voltage"], units["acceleration_z"], units["movement_counter"]) == ("V", "m/s²", "")
    assert {one.id: one.category for one in found.parts}["voltage"] == "diagnostic"


def test_an_error_is_an_unknown_value_and_ends() -> None:
    """A Govee H5075 that measures beyond its range, then within it: govee-ble, tests/test_parser.py."""
    parser, address = SensorLibraryParser({}), "A4:C1:38:DD:27:62"
    for data, celsius in ("00bc00043e27", None), ("000341c26400", 21.3), ("00bc00043e27", None):
        sent = {GOVEE: bytes.fromhex(data)}
        found = read(parser, Advertisement(address, -63, "GVH5075_2762", manufacturer_data=sent))
        assert values(found)["temperature", "temperature"] == celsius
        assert {one.id: one.service_type for one in found.parts}["temperature"] == "temperature_sensor"


def test_the_limit_of_an_alarm_is_no_measurement() -> None:
    """A Govee H5055, whose alarm is to ring at 177 °C: govee-ble, tests/test_parser.py."""
    sent = {0xAF2F: bytes.fromhex("5500644c201a00ffffffff 20190014 00b1000000")}
    meat = Advertisement("A4:C1:38:2F:AF:55", -63, manufacturer_data=sent, service_uuids=(full_uuid("5550"),))
    found = read(SensorLibraryParser({}), meat)
    assert values(found)["temperature_alarm_probe_4", "temperature"] == 177.0
    assert [one.id for one in found.parts if not one.category] == ["temperature_probe_3", "temperature_probe_4"]


def test_an_index_is_no_concentration() -> None:
    """Ruuvi Air, format E1 (docs.ruuvi.com, Bluetooth advertisements)."""
    data = bytes.fromhex("e1170c5668c79e0065007004bd11ca00c90a0213e0ac000000decdee110000000000cbb8334c884f")
    found = read(SensorLibraryParser({}), Advertisement("CB:B8:33:4C:88:4F", -60, manufacturer_data={RUUVI: data}))
    (index,) = [one for one in found.parts if one.id == "voc_index"]
    assert (index.service_type, index.capabilities[0].name, index.capabilities[0].unit) == (
        "air_quality_sensor",
        "measurement",
        "",
    )
    assert values(found)["voc_index", "measurement"] == 20.0
    assert values(found)["pm25", "pm25"] == 11.2


def test_maker_and_model_are_facts_of_the_device() -> None:
    found = read(SensorLibraryParser({}), THERMOMETER)
    assert found.metadata["manufacturer"] == "Xiaomi"
    assert found.metadata["model"] == "LYWSDCGQ"
    assert "LYWSDCGQ" in found.name


@pytest.mark.parametrize(
    ("advertisement", "name"), [(TAG, "RuuviTag EFAF"), (FRIDGE, "IBS-TH EEFF"), (DOOR, "Door/Window Sensor 2030")]
)
def test_a_device_has_the_name_that_its_library_gives_it(advertisement: Advertisement, name: str) -> None:
    """A RuuviTag advertises none, and a thermometer of Inkbird calls itself ``sps``."""
    assert read(SensorLibraryParser({}), advertisement).name == name


def test_an_advertisement_that_is_repeated_reports_nothing_new() -> None:
    parser = SensorLibraryParser({})
    assert values(read(parser, BUTTON))["button_0", "press"] == "single"
    again = read(parser, BUTTON)
    assert again.values == ()
    assert [one.id for one in again.parts] == ["battery", "button_0"]
    parser.forget(BUTTON.address)
    assert values(read(parser, BUTTON))["button_0", "press"] == "single"


def test_a_packet_reports_what_it_holds_and_no_earlier_values() -> None:
    """A motion sensor of Qingping sees somebody, and later says its battery: qingping-ble, tests/test_parser.py."""
    parser = SensorLibraryParser({})
    motion, battery = "4812cdd560342d580804012d01000f01b7", "0812cdd560342d580201640f019809043c010000"
    found = []
    for data in motion, motion, battery:
        sent = {full_uuid("fdcd"): bytes.fromhex(data)}
        found.append(values(read(parser, Advertisement("58:2D:34:60:D5:CD", -60, service_data=sent))))
    assert found == [
        {("motion", "occupancy"): True},
        {},
        {("battery", "battery"): 100.0, ("illuminance", "illuminance"): 316.0},
    ]


def test_the_value_of_an_event_is_unknown_after_a_moment() -> None:
    """The sensor never says that the motion is over."""
    assert read(SensorLibraryParser({}), MOTION).expiries == {"motion": (AutoExpiry("occupancy", MOMENT),)}
    assert not read(SensorLibraryParser({}), BUTTON).expiries


def test_a_device_that_encrypts_needs_its_key() -> None:
    without = read(SensorLibraryParser({}), SEALED)
    assert (without.values, without.problem) == ((), "it is encrypted, and no bind key is configured for it")
    wrong = read(SensorLibraryParser({ENCRYPTED: bytes(16)}), SEALED)
    assert (wrong.values, wrong.problem) == ((), "it is encrypted with another bind key")


def test_a_phone_is_no_sensor() -> None:
    phone = Advertisement("D0:00:00:00:00:01", -60, "Phone", manufacturer_data={0x004C: b"\x10\x05\x01\x18"})
    assert SensorLibraryParser({}).read(phone, 0.0) is None


def test_without_data_no_library_is_asked() -> None:
    assert not SensorLibraryParser({}).concerns(Advertisement("D0:00:00:00:00:01", -60, "Phone"))


def test_a_failure_of_a_library_is_a_wire_error() -> None:
    """Its exception says nothing to a user, and must not end the gateway."""
    with pytest.raises(WireError, match="ruuvitag_ble cannot read it"):
        SensorLibraryParser({}).read(Advertisement("DE:AD:7B:3F:EF:AF", -60, manufacturer_data={RUUVI: b""}), 0.0)


def test_a_button_that_a_library_calls_occupancy_says_nothing_of_people() -> None:
    """As thermobeacon-ble 1.0.0 and mopeka-iot-ble 1.0.0 do."""
    from bluetooth_sensor_state_data import BluetoothData  # noqa: PLC0415 - an extra
    from sensor_state_data import BinarySensorDeviceClass  # noqa: PLC0415 - an extra

    class Reader(BluetoothData):
        __module__ = "thermobeacon_ble.parser"

        def _start_update(self, service_info: object) -> None:
            del service_info
            self.set_device_type("Hygrometer")
            self.update_predefined_binary_sensor(BinarySensorDeviceClass.OCCUPANCY, native_value=False)

    found = read(SensorLibraryParser({}, [Reader]), BTHOME_V1)
    assert values(found) == {("button", "state"): False}
    assert [one.service_type for one in found.parts] == ["x_binary_sensor"]
