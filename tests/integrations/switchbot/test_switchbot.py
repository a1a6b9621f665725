"""SwitchBot's broadcasts, in the bytes that pySwitchbot 3.1 describes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, full_uuid
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.switchbot.formats import MAKER, SwitchbotParser

ADDRESS = "AA:BB:CC:DD:EE:FF"
MAC = "aabbccddeeff"


def heard(service: bytes, maker: str = "", uuid: str = "fd3d") -> Advertisement:
    data = {MAKER: bytes.fromhex(MAC + maker)} if maker else {}
    return Advertisement(ADDRESS, -60, "WoHand", service_data={full_uuid(uuid): service}, manufacturer_data=data)


def read(advertisement: Advertisement) -> Broadcast:
    parser = SwitchbotParser({})
    assert parser.concerns(advertisement)
    found = parser.read(advertisement, 0.0)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("advertisement", "expected"),
    [
        (heard(b"T\x00\x64", "7503 0096ac"), {"temperature": 22.0, "humidity": 44.0, "battery": 100.0}),
        (heard(b"w\x00\x4b", "0103 05035d"), {"temperature": -3.5, "humidity": 93.0, "battery": 75.0}),
        (heard(b"T\x00\x64\x02\x97\x2d", uuid="0d00"), {"temperature": 23.2, "humidity": 45.0, "battery": 100.0}),
        (heard(b"i\x00\x64", "0103 000000"), {"temperature": None, "humidity": None, "battery": 100.0}),
        (heard(b"v\x00", "00ff66541af1 82 079a3200"), {"temperature": 26.7, "humidity": 50.0}),
        (
            heard(b"5\x00\x64", "0103 009c2d 0000 02aa"),
            {"temperature": 28.0, "humidity": 45.0, "carbon_dioxide": 682.0, "battery": 100.0},
        ),
        (
            heard(b"d\x00\x58", "0190 00"),
            {"contact": True, "occupancy": True, "light_detected": False, "battery": 88.0},
        ),
        (
            heard(b"d\x00\x58", "0160 00"),  # open for too long
            {"contact": True, "occupancy": False, "light_detected": True, "battery": 88.0},
        ),
        (heard(b"s\x00\x5a", "0160"), {"occupancy": True, "light_detected": True, "battery": 90.0}),
        (heard(b"&\x00\x56", "0156 01"), {"water_leak": True, "tamper": False, "battery": 86.0}),
        (heard(b"c\xd0\x59\x00\x11\x04"), {"position": 100.0, "battery": 89.0}),
        (heard(b"{\x00\x32", "0100 d01104 0032"), {"position": 20.0, "battery": 50.0}),
        (heard(b"g\x00\x00", "0180 0030 04d2"), {"on_off": True, "power": 123.4}),
        (heard(b"o\x80\x64", "da83 0020"), {"lock": "locked", "contact": False, "battery": 100.0}),
        (heard(b"o\x80\x64", "da94 0020"), {"lock": "unlocked", "contact": True, "battery": 100.0}),
        (heard(b"$\x80\x64", "da88 1020 0000"), {"lock": "unlocked", "contact": True, "battery": 32.0}),
        (heard(b">\x00\x00", "0880 00"), {"contact": True}),
        (heard(b">\x00\x00", "08a0 00"), {"contact": False}),
        (heard(b"\x00\x80d\x00\x11\x9f\xb8", "0780 1064 0020"), {"lock": "locked", "contact": True, "battery": 100.0}),
        (heard(b"\x00\x80d\x00\x11\x69\x08", "0793 0820"), {"lock": "unlocked", "battery": 100.0}),
        # The following are of real devices, from the tests of pySwitchbot.
        (
            heard(b"\x00\x00d\x00\x10\xb9@", "00ff6826d6648303993480"),
            {"temperature": 25.3, "humidity": 52.0, "occupancy": True},
        ),
        (heard(b"%\x00", "000000000000 14019835 00"), {"temperature": 24.1, "humidity": 53.0}),
        (heard(b",\x00'\x9f\x11\x04", "2c089f11042700"), {"position": 69.0, "battery": 39.0}),
        (heard(b"x\x00H", "0b2700a184"), {"tilt": 0.0, "battery": 72.0}),
        (heard(b"x\x00H", "0b273ca184"), {"tilt": 80.0, "battery": 72.0}),
        (heard(b"?\x00\x00\x00", "3fa1000004e600000000"), {"on_off": True, "power": 1254.0}),
        (heard(b"<\x00\x00\x00", "4781000000310000"), {"on_off": True, "power": 49.0}),
        (heard(b"-\x80d", "1793 0820"), {"lock": "unlocked", "battery": 100.0}),
        (heard(b"\x00\x804\x00\x10\xa5\xb8", "258230340004"), {"lock": "locked", "contact": True, "battery": 52.0}),
        (
            heard(b"\x00 _\x00\x10\xf3\xd8@", "061405992d00000000d4000c0400"),
            {"temperature": 25.5, "humidity": 45.0, "occupancy": True, "battery": 20.0},
        ),
        (heard(b"\x00 d\x00\x10\xcc\xc8", "06cc0456008c"), {"occupancy": True, "battery": 100.0}),
        (heard(b"H\x90\x0f"), {"on_off": True, "battery": 15.0}),
        (heard(b"H\xd0\x0f"), {"on_off": False, "battery": 15.0}),
    ],
)
def test_a_broadcast_becomes_values(advertisement: Advertisement, expected: dict[str, PlainValue]) -> None:
    found = read(advertisement)
    assert {one.capability: one.value for one in found.values} == expected
    assert [one.id for one in found.parts] == list(expected)
    assert not any(capability.settable for one in found.parts for capability in one.capabilities)


def test_a_device_is_what_its_letter_says() -> None:
    lock = read(heard(b"o\x80\x64", "da83 0020"))
    assert (lock.name, dict(lock.metadata)) == ("Lock EEFF", {"manufacturer": "SwitchBot", "model": "Lock"})
    assert [(one.service_type, one.category) for one in lock.parts] == [
        ("door_lock", ""),
        ("contact_sensor", ""),
        ("x_battery", "diagnostic"),
    ]


def test_the_same_bytes_are_no_news() -> None:
    parser = SwitchbotParser({})
    bot = heard(b"H\x90\x0f")
    found = [parser.read(bot, now) for now in (0.0, 1.0)]
    assert [one is not None and bool(one.values) for one in found] == [True, False]
    parser.forget(ADDRESS)
    assert (again := parser.read(bot, 2.0)) is not None
    assert again.values


@pytest.mark.parametrize(
    "advertisement",
    [heard(b"T\x00\x64"), heard(b"d\x00\x58"), heard(b"o\x00\x64"), heard(b"\x00\x00\x64\x00\x10\x53\xb0")],
)
def test_a_device_is_none_before_the_data_of_the_maker_came(advertisement: Advertisement) -> None:
    """They come in another packet, which an active scan asks for."""
    assert SwitchbotParser({}).read(advertisement, 0.0) is None


@pytest.mark.parametrize(
    "advertisement", [heard(b"T\x00", "01"), heard(b"d\x00\x58", "01"), heard(b"o\x00", "da83 0020")]
)
def test_a_frame_that_is_cut_off_is_refused(advertisement: Advertisement) -> None:
    with pytest.raises(WireError, match="cut off"):
        SwitchbotParser({}).read(advertisement, 0.0)


@pytest.mark.parametrize("service", [b"", b"!\x00\x00"])
def test_other_models_are_not_read(service: bytes) -> None:
    assert not SwitchbotParser({}).concerns(heard(service))


@given(st.binary(max_size=12), st.binary(max_size=20))
def test_any_bytes_are_read_or_refused(service: bytes, maker: bytes) -> None:
    parser, advertisement = SwitchbotParser({}), heard(service, maker.hex())
    try:
        found = parser.read(advertisement, 0.0) if parser.concerns(advertisement) else None
    except WireError:
        return
    assert found is None or found.values
