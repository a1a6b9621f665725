"""Packets of BTHome v2 as the specification shows them, and as they come broken."""

import pytest

from homebot.conventions.bluetooth.bthome_objects import BTHOME_OBJECTS
from homebot.conventions.units import sensor_type
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.errors import WireError
from homebot.integrations.bthome.formats.packet import BTHomePacket, read_frame, read_objects


def read_packet(data: bytes) -> BTHomePacket:
    """Return the packet in the service *data* of a device that does not encrypt."""
    return read_objects(read_frame(data).body)


EXAMPLES = [
    ("0161", "battery", 97.0),
    ("02CA09", "temperature", 25.06),
    ("03BF13", "humidity", 50.55),
    ("04138A01", "pressure", 1008.83),
    ("05138A14", "illuminance", 13460.67),
    ("065E1F", "mass", 80.3),
    ("073E1D", "mass_lb", 74.86),
    ("08CA06", "dew_point", 17.38),
    ("0960", "count", 96.0),
    ("0A138A14", "energy", 1346.067),
    ("0B021B00", "power", 69.14),
    ("0C020C", "voltage", 3.074),
    ("0D120C", "pm25", 3090.0),
    ("0E021C", "pm10", 7170.0),
    ("0F01", "generic", True),
    ("1101", "opening", True),
    ("12E204", "co2", 1250.0),
    ("133301", "tvoc", 307.0),
    ("14020C", "moisture", 30.74),
    ("1501", "battery_low", True),
    ("1A01", "door", True),
    ("1F01", "lock", True),
    ("2100", "motion", False),
    ("2801", "safety", False),
    ("2D01", "window", True),
    ("2E23", "humidity", 35.0),
    ("2F23", "moisture", 35.0),
    ("3A00", "button", None),
    ("3A01", "button", "single"),
    ("3A04", "button", "long"),
    ("3A80", "button", "hold"),
    ("3B0002", "command", "toggle"),
    ("3C0103", "dimmer", "rotate_left 3"),
    ("3C020A", "dimmer", "rotate_right 10"),
    ("3C0000", "dimmer", None),
    ("3D0960", "count", 24585.0),
    ("3E2A2C0960", "count", 1611213866.0),
    ("3F020C", "rotation", 307.4),
    ("400C00", "distance_mm", 12.0),
    ("414E00", "distance", 7.8),
    ("424E3400", "duration", 13.39),
    ("434E34", "current", 13.39),
    ("444E34", "speed", 133.9),
    ("451101", "temperature", 27.3),
    ("4632", "uv_index", 5.0),
    ("478756", "volume", 2215.1),
    ("48DC87", "volume_ml", 34780.0),
    ("49DC87", "volume_flow_rate", 34.78),
    ("4A020C", "voltage", 307.4),
    ("4B138A14", "gas", 1346.067),
    ("4C41018A01", "gas", 25821.505),
    ("4D12138A14", "energy", 344593.17),
    ("4E87562A01", "volume", 19551.879),
    ("4F87562A01", "water", 19551.879),
    ("505D396164", "timestamp", "2023-05-14T19:41:17+00:00"),
    ("518756", "acceleration", 22.151),
    ("528756", "gyroscope", 22.151),
    ("530C48656C6C6F20576F726C6421", "text", "Hello World!"),
    ("540C48656C6C6F20576F726C6421", "raw", "48656c6c6f20576f726c6421"),
    ("5587562A01", "volume_storage", 19551.879),
    ("56E803", "conductivity", 1000.0),
    ("57EA", "temperature", -22.0),
    ("58EA", "temperature", -7.7),
    ("59EA", "count", -22.0),
    ("5AEAEA", "count", -5398.0),
    ("5C02FBFFFF", "power", -12.78),
    ("5D02EA", "current", -5.63),
    ("5E9F8C", "direction", 359.99),
    ("6001", "channel", 1.0),
    ("61AC0D", "rotational_speed", 3500.0),
]


@pytest.mark.parametrize(("objects", "part", "value"), EXAMPLES)
def test_each_object_reads_as_the_specification_shows(objects: str, part: str, value: object) -> None:
    (found,) = read_packet(b"\x40" + bytes.fromhex(objects)).values
    assert (found.part, found.value) == (part, value)


def test_a_packet_has_several_objects_and_a_number() -> None:
    packet = read_packet(bytes.fromhex("4400BE016402CA09"))
    assert packet.packet_id == 0xBE
    assert [(one.part, one.value) for one in packet.values] == [("battery", 100.0), ("temperature", 25.06)]
    assert read_frame(bytes.fromhex("4400BE")).is_trigger_based


def test_objects_of_one_name_are_parts_of_their_own() -> None:
    packet = read_packet(bytes.fromhex("4002CA09020A003A003A01"))
    assert [(one.part, one.value) for one in packet.values] == [
        ("temperature", 25.06),
        ("temperature_2", 0.1),
        ("button", None),
        ("button_2", "single"),
    ]


def test_a_dew_point_is_a_temperature_as_in_other_conventions() -> None:
    (found,) = read_packet(bytes.fromhex("4008CA06")).values
    assert (found.part, found.object.capability, found.value) == ("dew_point", "temperature", 17.38)


def test_the_firmware_and_the_model_are_read_backwards() -> None:
    packet = read_packet(bytes.fromhex("40F00100F100010204"))
    assert (packet.device_type, packet.firmware) == (1, "4.2.1.0")
    assert read_packet(bytes.fromhex("40F2000106")).firmware == "6.1.0"


def test_the_address_that_a_packet_carries_is_turned_round() -> None:
    frame = read_frame(bytes.fromhex("42A5808FE6485402CA09"))
    assert (frame.address.hex(), frame.body.hex()) == ("5448e68f80a5", "02ca09")


def test_reading_stops_at_an_object_that_is_not_known() -> None:
    packet = read_packet(bytes.fromhex("4002CA09FE010203"))
    assert [one.value for one in packet.values] == [25.06]
    assert packet.unread == 4


@pytest.mark.parametrize(
    ("data", "named"),
    [
        ("", "no data"),
        ("20", "version is 1"),
        ("42A580", "address is cut off"),
        ("4002CA", "0x02 is cut off"),
        ("4053", "has no length"),
        ("405305FF", "is cut off"),
        ("405301FF", "not UTF-8"),
    ],
)
def test_an_invalid_packet_is_refused_with_a_reason(data: str, named: str) -> None:
    with pytest.raises(WireError, match=named):
        read_packet(bytes.fromhex(data))


def test_every_object_has_a_place_in_the_vocabulary() -> None:
    for kind in BTHOME_OBJECTS.values():
        if kind.capability:
            assert kind.capability in CAPABILITIES
            assert sensor_type(kind.capability) in DEVICE_TYPES
