"""What DNS-SD tells of real devices becomes facts and identifiers; TXT records are read as RFC 6763 says."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.dns_sd import (
    MAX_KEYS,
    base_type,
    facts_of,
    full_type,
    identifiers_of,
    instance_label,
    is_service_type,
    name_of,
    read_txt,
    usable_addresses,
)
from homebot.gateways.drivers import FoundService


def strings(*texts: bytes) -> bytes:
    return b"".join(bytes([len(one)]) + one for one in texts)


@pytest.mark.parametrize(
    ("data", "properties"),
    [
        (b"", {}),
        (b"\0", {}),
        (strings(b"papersize=A4"), {"papersize": "A4"}),
        (strings(b"PaperSize=A4", b"papersize=A3"), {"papersize": "A4"}),
        (strings(b"flag", b"empty="), {"flag": "", "empty": ""}),
        (strings(b"a=b=c"), {"a": "b=c"}),
        (strings(b"=nothing", b"x=1"), {"x": "1"}),
        (strings("name=Küche".encode()), {"name": "Küche"}),
        (strings(b"raw=\xff\x00"), {"raw": "\\xff\x00"}),
        (strings(b"k\x80=1", b"x\n=1", b"ok=1"), {"ok": "1"}),
    ],
)
def test_a_record_is_read(data: bytes, properties: dict[str, str]) -> None:
    record = read_txt(data)
    assert (dict(record.properties), record.problem) == (properties, "")


def test_a_record_that_ends_within_a_string_is_read_up_to_its_end_with_the_problem() -> None:
    record = read_txt(strings(b"a=1") + b"\x09b=2")
    assert dict(record.properties) == {"a": "1", "b": "2"}
    assert record.problem == "its TXT record ends within a string of 9 bytes"


def test_a_record_with_too_many_keys_is_cut() -> None:
    record = read_txt(strings(*(f"k{number}=1".encode() for number in range(500))))
    assert len(record.properties) == MAX_KEYS
    assert record.problem


@given(st.binary(max_size=9000))
def test_any_bytes_are_read(data: bytes) -> None:
    record = read_txt(data)
    assert len(record.properties) <= MAX_KEYS
    assert all(
        key.isascii() and key == key.lower() and value.encode() is not None for key, value in record.properties.items()
    )


@given(st.dictionaries(st.text("abcdefgh-_ 0123", min_size=1, max_size=20), st.text(max_size=40), max_size=20))
def test_written_values_are_read(properties: dict[str, str]) -> None:
    record = read_txt(strings(*(f"{key}={value}".encode() for key, value in properties.items())))
    assert (dict(record.properties), record.problem) == (properties, "")


def found(name: str, service_type: str, host: str, **properties: str) -> FoundService:
    full = f"{service_type}.local."
    return FoundService(f"{name}.{full}", name, full, host, 80, ("192.168.1.20",), properties)


SHELLY = found(
    "shellyplus1-a8032abe54dc", "_shelly._tcp", "ShellyPlus1-A8032ABE54DC.local.", gen="2", app="Plus1", ver="1.4.4"
)
ESPHOME = found(
    "kitchen-light",
    "_esphomelib._tcp",
    "kitchen-light.local.",
    mac="a8032abe54dc",
    board="esp32dev",
    version="2026.10.0",
)
WLED = found("wled-desk", "_wled._tcp", "wled-desk.local.", mac="a8032abe54dc")
AIRPLAY = found("A8032ABE54DC@Kitchen", "_raop._tcp", "Kitchen.local.", am="AudioAccessory5,1")


@pytest.mark.parametrize("service", [SHELLY, ESPHOME, WLED, AIRPLAY], ids=["Shelly", "ESPHome", "WLED", "AirPlay"])
def test_a_hardware_address_is_found_where_devices_have_it(service: FoundService) -> None:
    assert "mac:a8032abe54dc" in identifiers_of(service)


def test_what_an_ecosystem_says_is_declared_takes_the_place_of_the_usual() -> None:
    lamp = found("Lamp", "_lamp._tcp", "lamp.local.", id="A8:03:2A:BE:54:DC")
    assert identifiers_of(lamp) == ("mac:a8032abe54dc",)
    assert identifiers_of(lamp, ["lamp number 7"]) == ("id:lamp number 7",)


@pytest.mark.parametrize(
    ("name", "service_type", "properties", "expected"),
    [
        ("Chromecast-0123456789abcdef", "_googlecast._tcp", {"fn": "Living room"}, "Living room"),
        ("A8032ABE54DC@Kitchen", "_raop._tcp", {}, "Kitchen"),
        ("RINCON_A8032ABE54DC01400@Bath", "_sonos._tcp", {}, "Bath"),
        ("me@home", "_http._tcp", {}, "me@home"),
        ("office [a8:03:2a:be:54:dc]", "_workstation._tcp", {}, "office"),
        ("Bosch SHC [a8-03-2a-be-54-dc]", "_http._tcp", {}, "Bosch SHC"),
        ("amzn.dmgr:0BAECE33521E1296:IWtzu2uork:904801", "_amzn-wplay._tcp", {"n": "Bedroom TV"}, "Bedroom TV"),
        ("Lamp", "_http._tcp", {"n": "x"}, "Lamp"),
        ("Lamp", "_http._tcp", {"dn": "x", "fn": ""}, "Lamp"),
    ],
)
def test_a_name_is_one_for_people(name: str, service_type: str, properties: dict[str, str], expected: str) -> None:
    assert name_of(found(name, service_type, "x.local.", **properties)) == expected


@pytest.mark.parametrize(
    ("name", "properties", "expected"),
    [
        ("nas", {"mac_address": "00:11:32:AA:BB:59|00:11:32:AA:BB:5A"}, ("mac:001132aabb59", "mac:001132aabb5a")),
        ("office [a8:03:2a:be:54:dc]", {}, ("mac:a8032abe54dc",)),
        ("Bosch SHC [a8-03-2a-be-54-dc]", {}, ("mac:a8032abe54dc",)),
        ("Lutron Status 01", {"macaddr": "A8:03:2A:BE:54:DC"}, ("mac:a8032abe54dc",)),
        ("Hue", {"bridgeid": "001788fffe1a2b3c"}, ("eui64:001788fffe1a2b3c",)),
        ("plug", {"bssid": "a8:03:2a:be:54:dc"}, ()),
    ],
)
def test_hardware_addresses_are_those_of_the_device(
    name: str, properties: dict[str, str], expected: tuple[str, ...]
) -> None:
    assert identifiers_of(found(name, "_http._tcp", "x.local.", **properties)) == expected


def test_random_text_contains_no_address() -> None:
    random, timed = "8d1f5f7f-2c7b-4a6f-9d1f-5f7f2c7b4a6f", "d3b8c0d0-1dd2-11b2-ac7c-f430b9ab12cd"
    assert identifiers_of(found("Cast", "_googlecast._tcp", f"{random}.local.", id=random)) == (f"id:{random}",)
    assert "mac:f430b9ab12cd" in identifiers_of(found("Printer", "_ipp._tcp", "x.local.", uuid=timed))


@pytest.mark.parametrize("properties", [{"id": "1"}, {"serial": ""}, {"uuid": "lamp"}])
def test_common_names_identify_no_device(properties: dict[str, str]) -> None:
    assert identifiers_of(found("Lamp", "_http._tcp", "raspberrypi.local.", **properties)) == ()


def test_a_serial_number_is_an_identifier() -> None:
    assert identifiers_of(found("Lamp", "_http._tcp", "lamp.local.", serial="GW-2026-1")) == ("id:GW-2026-1",)


def test_facts_have_the_names_of_the_directory_and_nothing_that_does_not_show() -> None:
    facts = facts_of(ESPHOME)
    assert (facts["model"], facts["sw_version"], facts["host"]) == ("esp32dev", "2026.10.0", "kitchen-light.local")
    assert facts["txt_mac"] == "a8032abe54dc"
    assert facts_of(found("x", "_http._tcp", "x.local.", md="a\x1b[2J"))["model"] == "a\N{REPLACEMENT CHARACTER}[2J"


@pytest.mark.parametrize(
    ("properties", "expected"),
    [
        ({"brand": "Siemens", "type": "Oven", "vib": "HB678GBS6", "vers": "5.4"}, ("Siemens", "HB678GBS6", None)),
        ({"vendor": "AirGradient", "fw_ver": "3.1.1", "model": "I-9PSL"}, ("AirGradient", "I-9PSL", "3.1.1")),
        ({"model": "AudioAccessory5,1", "srcvers": "760.20.1", "osvers": "17.4"}, (None, "AudioAccessory5,1", "17.4")),
        ({"version": "v0", "firmwareversion": "8.90.4", "mt": "2600"}, (None, None, "8.90.4")),
    ],
    ids=["Home Connect", "AirGradient", "HomePod", "devolo"],
)
def test_maker_model_and_firmware_are_found_where_devices_have_them(
    properties: dict[str, str], expected: tuple[str | None, ...]
) -> None:
    facts = facts_of(found("x", "_x._tcp", "x.local.", **properties))
    assert tuple(map(facts.get, ("manufacturer", "model", "sw_version"))) == expected


def test_addresses_are_sorted_best_first() -> None:
    heard = ["fe80::1%3", "fd00::7", "192.168.1.20", "fe80::2", "224.0.0.1", "0.0.0.0", "no address", "169.254.3.4"]  # noqa: S104
    assert usable_addresses(heard, with_loopback=False) == ("192.168.1.20", "fd00::7", "169.254.3.4", "fe80::1%3")


def test_a_loopback_address_is_used_only_where_the_network_is_loopback() -> None:
    assert usable_addresses(["127.0.0.1", "::1"], with_loopback=False) == ()
    assert usable_addresses(["127.0.0.1"], with_loopback=True) == ("127.0.0.1",)


@pytest.mark.parametrize(
    ("text", "full"),
    [
        ("_shelly._tcp", "_shelly._tcp.local."),
        (" _HTTP._TCP.local ", "_http._tcp.local."),
        ("_directory._sub._wot._tcp", "_directory._sub._wot._tcp.local."),
    ],
)
def test_a_service_type_is_written_in_full(text: str, full: str) -> None:
    assert full_type(text) == full
    assert is_service_type(full)


def test_a_subtype_belongs_to_its_type() -> None:
    assert base_type("_directory._sub._wot._tcp.local.") == "_wot._tcp.local."
    assert instance_label("My dir._x._wot._tcp.local.", "_directory._sub._wot._tcp.local.") == "My dir._x"
