"""The parsers of broadcasts."""

import pytest

from homebot.conventions.bluetooth.beacons import EDDYSTONE, BeaconParser
from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, full_uuid
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.bthome.formats.encryption import seal
from homebot.integrations.bthome.formats.parser import TRIGGER_BASED, BTHomeParser

ADDRESS = "54:48:E6:8F:80:A5"
KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
BTHOME = full_uuid("fcd2")


def read(parser: BTHomeParser, data: str, now: float = 0.0, name: str = "") -> Broadcast:
    found = parser.read(Advertisement(ADDRESS, -60, name, service_data={BTHOME: bytes.fromhex(data)}), now)
    assert found is not None
    return found


def values(found: Broadcast) -> list[tuple[str, PlainValue]]:
    return [(one.part, one.value) for one in found.values]


def test_a_packet_that_comes_again_is_read_once() -> None:
    parser = BTHomeParser({})
    assert values(read(parser, "400001" + "3A01")) == [("button", "single")]
    for now in (0.1, 3.0, 600.0):
        assert values(read(parser, "400001" + "3A01", now)) == []
    assert values(read(parser, "400002" + "3A01", 600.1)) == [("button", "single")]


def test_a_packet_that_is_older_than_the_last_is_left_out() -> None:
    parser = BTHomeParser({})
    read(parser, "4000FF" + "0161")
    assert values(read(parser, "400001" + "0162", 0.1)) == [("battery", 98.0)]
    assert values(read(parser, "4000FE" + "0163", 0.2)) == []
    assert values(read(parser, "400000" + "0163", 0.3)) == []
    assert values(read(parser, "400000" + "0160", 9.0)) == [("battery", 96.0)]


def test_without_packet_ids_the_same_bytes_are_one_packet_until_there_is_a_pause() -> None:
    parser = BTHomeParser({})
    assert values(read(parser, "403A01", 0.0)) == [("button", "single")]
    assert values(read(parser, "403A01", 3.0)) == []
    assert values(read(parser, "403A01", 6.0)) == []
    assert values(read(parser, "403A01", 10.1)) == [("button", "single")]


def test_parts_of_all_packets_are_kept() -> None:
    """A Shelly BLU says its battery at times, and its button when it is pressed."""
    parser = BTHomeParser({})
    read(parser, "440001" + "0164", name="SBBT-002C")
    found = read(parser, "440002" + "3A04", 10.0)
    assert [(one.id, one.service_type) for one in found.parts] == [
        ("battery", "x_battery"),
        ("button", "generic_switch"),
    ]
    assert values(found) == [("button", "long")]
    assert found.silence == TRIGGER_BASED


def test_a_shelly_blu_has_the_name_of_its_model() -> None:
    parser = BTHomeParser({})
    found = read(parser, "440001" + "2d01", name="SBDW-002C")
    assert (found.name, found.metadata["manufacturer"]) == ("BLU Door/Window 80A5", "Shelly")
    assert read(parser, "440002" + "2d00").name == found.name
    assert read(parser, "440003" + "2d00", name="Shed").name == "Shed"


@pytest.mark.parametrize(
    ("name", "packet", "expected"),
    [
        (
            "SBTR-001AEU",
            "45b200" + "45b900",
            {("target_temperature", "heating_setpoint"): 17.8, ("temperature", "temperature"): 18.5},
        ),
        ("SBWS-90CM", "2001" + "44c800", {("rain", "state"): True, ("speed", "measurement"): 2.0}),
        ("Cellar", "2001" + "44c800", {("water_leak", "water_leak"): True, ("speed", "measurement"): 2.0}),
    ],
)
def test_objects_mean_what_they_mean_in_a_model(
    name: str, packet: str, expected: dict[tuple[str, str], object]
) -> None:
    """The target of a valve is not the temperature of its room, and rain is no leak."""
    found = read(BTHomeParser({}), "440001" + packet, name=name)
    assert {(one.part, one.capability): one.value for one in found.values} == expected


def test_a_button_that_is_not_pressed_is_no_event() -> None:
    found = read(BTHomeParser({}), "400001" + "3A003A01")
    assert values(found) == [("button_2", "single")]
    assert [one.id for one in found.parts] == ["button", "button_2"]


def test_the_example_of_the_specification_is_decrypted() -> None:
    parser = BTHomeParser({ADDRESS: KEY})
    assert values(read(parser, "41a47266c95f730011223378237214")) == [("temperature", 25.06), ("humidity", 50.55)]


def test_a_device_with_a_bind_key_must_encrypt() -> None:
    with pytest.raises(WireError, match="not encrypted"):
        read(BTHomeParser({ADDRESS: KEY}), "400161")


def test_an_encrypted_press_that_is_sent_again_is_one_press() -> None:
    """Without a packet id, only the counter tells a press from a copy of it; a recorded copy may come days later."""
    parser = BTHomeParser({ADDRESS: KEY})
    pressed = seal(KEY, bytes.fromhex(ADDRESS.replace(":", "")), 0x41, 7, b"\x3a\x01").hex()
    assert values(read(parser, pressed)) == [("button", "single")]
    for now in (1.0, 60.0, 86_400.0):
        assert values(read(parser, pressed, now)) == []


def test_a_forgotten_device_refuses_a_replay() -> None:
    parser = BTHomeParser({ADDRESS: KEY})
    old, new = (
        seal(KEY, bytes.fromhex(ADDRESS.replace(":", "")), 0x41, counter, b"\x3a\x01").hex() for counter in (7, 200)
    )
    read(parser, old)
    read(parser, new)
    parser.forget(ADDRESS)
    with pytest.raises(WireError, match="replay"):
        read(parser, old, 3600.0)


def test_without_its_bind_key_a_device_is_known_and_not_read() -> None:
    found = read(BTHomeParser({}), "41a47266c95f730011223378237214", name="Attic")
    assert (found.name, found.parts, values(found)) == ("Attic", (), [])
    assert "bind key" in found.problem


def test_a_device_is_forgotten() -> None:
    parser = BTHomeParser({})
    read(parser, "400001" + "0164")
    parser.forget(ADDRESS)
    assert values(read(parser, "400001" + "0164", 0.1)) == [("battery", 100.0)]


def test_an_ibeacon_has_an_identity_and_a_strength() -> None:
    data = bytes.fromhex("0215" + "f7826da64fa24e988024bc5b71e0893e" + "00010203" + "c5")
    advertisement = Advertisement(ADDRESS, -60, manufacturer_data={0x004C: data})
    parser = BeaconParser({})
    assert parser.concerns(advertisement)
    found = parser.read(advertisement, 0.0)
    assert found is not None
    assert found.key == "ibeacon:f7826da6-4fa2-4e98-8024-bc5b71e0893e/1/515"
    assert found.rssi_at_1m == -59


def test_an_eddystone_has_its_power_at_no_distance() -> None:
    data = bytes.fromhex("00" + "ee" + "00112233445566778899" + "aabbccddeeff" + "0000")
    found = BeaconParser({}).read(Advertisement(ADDRESS, -60, service_data={EDDYSTONE: data}), 0.0)
    assert found is not None
    assert found.key == "eddystone:00112233445566778899/aabbccddeeff"
    assert found.rssi_at_1m == -18 - 41


@pytest.mark.parametrize("data", ["0215f7826d", "021500"])
def test_a_beacon_that_is_cut_off_is_refused(data: str) -> None:
    advertisement = Advertisement(ADDRESS, -60, manufacturer_data={0x004C: bytes.fromhex(data)})
    with pytest.raises(WireError, match="cut off"):
        BeaconParser({}).read(advertisement, 0.0)


def test_other_advertisements_of_apple_are_no_beacons() -> None:
    assert not BeaconParser({}).concerns(Advertisement(ADDRESS, -60, manufacturer_data={0x004C: b"\x10\x05\x01\x18"}))
