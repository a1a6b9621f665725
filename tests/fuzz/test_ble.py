"""Damaged Bluetooth advertisements and notified values: refused in our words, or understood."""

import pytest
from tests.fuzz.conftest import Fuzz

from homebot.conventions.bluetooth.beacons import APPLE, EDDYSTONE, BeaconParser
from homebot.conventions.bluetooth.broadcast import Advertisement, full_uuid
from homebot.conventions.bluetooth.gatt_profile import BUILT_IN
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.integrations.bthome.formats.encryption import seal
from homebot.integrations.bthome.formats.parser import BTHomeParser

BTHOME = full_uuid("fcd2")
KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
OPEN, SEALED = "A4:C1:38:00:00:01", "A4:C1:38:00:00:02"
BODIES = tuple(
    bytes.fromhex(one)
    for one in (
        "00BE016402CA0903BF13",
        "3A013A003C0103",
        "530C48656C6C6F20576F726C6421",
        "5402FFFE505D396164",
        "3B0002F1000102043E2A2C0960",
        "2801150158EA5BEAEA0215",
    )
)
OTHER_SENSORS: tuple[tuple[str | int, bytes, str], ...] = (
    (full_uuid("fe95"), bytes.fromhex("5020aa01da219335342d580d1004fe004802"), "Test"),
    (full_uuid("fe95"), bytes.fromhex("5858480b685f12342d585a0b1841e2aa000e00a4964fb5"), "Test"),
    (0x0499, bytes.fromhex("0505a060a0c89afd34028cff006376726976dead7b3fefaf"), "Ruuvi"),
    (0xEC88, bytes.fromhex("00034db26400"), "GVH5075_DBF8"),
    (2044, bytes.fromhex("c71200c83d5606"), "sps"),
)
IBEACON = bytes.fromhex("0215f7826da64fa24e988024bc5b71e0893e00010002c5")
UID = bytes.fromhex("00ee00112233445566778899aabbccddeeff0000")


def test_damaged_bthome_packets_are_refused_or_read(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("bthome"):
        parser = BTHomeParser({SEALED: KEY})
        now = 0.0
        for _ in range(rng.randrange(1, 6)):
            body = rng.choice(BODIES)
            body = damage.damaged_bytes(body) if rng.random() < 0.7 else body
            address = rng.choice((OPEN, SEALED))
            data = bytes([rng.choice((0x40, 0x44, 0x42, 0x41, 0x20))]) + body
            if address == SEALED and rng.random() < 0.8:
                data = seal(KEY, bytes.fromhex(SEALED.replace(":", "")), 0x41, rng.randrange(2**32), body)
            data = damage.damaged_bytes(data) if rng.random() < 0.3 else data
            now += rng.choice((0.1, 1.0, 10.0))
            check_bthome(parser, Advertisement(address, -60, service_data={BTHOME: data}), now)


def check_bthome(parser: BTHomeParser, advertisement: Advertisement, now: float) -> None:
    assert parser.concerns(advertisement)
    try:
        found = parser.read(advertisement, now)
    except WireError:
        return
    assert found is not None
    parts = {one.id: one for one in found.parts}
    for one in found.values:
        assert can_report(parts[one.part], one.capability, one.value), one
        assert one.capability in CAPABILITIES


def test_a_recorded_encrypted_packet_is_never_reported_again(fuzz: Fuzz) -> None:
    """Somebody sends packets of a device again, some of them damaged, at any time, also after a new battery."""
    for damage, rng in fuzz("bthome-replay"):
        parser = BTHomeParser({SEALED: KEY})
        now, counter = 0.0, rng.choice((0, 90, 2**31 - 3, 2**32 - 3, rng.randrange(2**32)))
        sent: list[bytes] = []
        reported: set[PlainValue] = set()
        for _ in range(rng.randrange(2, 20)):
            now += rng.choice((0.1, 5.0, 60.0))
            if sent and rng.random() < 0.5:
                data = rng.choice(sent)
                data = damage.damaged_bytes(data) if rng.random() < 0.3 else data
            else:
                counter = rng.randrange(100) if rng.random() < 0.1 else (counter + rng.randrange(1, 300)) % 2**32
                body = len(sent).to_bytes(2, "little")
                data = seal(KEY, bytes.fromhex(SEALED.replace(":", "")), 0x41, counter, b"\x3d" + body + b"\x3a\x01")
                sent.append(data)
            try:
                found = parser.read(Advertisement(SEALED, -60, service_data={BTHOME: data}), now)
            except WireError:
                continue
            assert found is not None
            numbers = [one.value for one in found.values if one.part == "count"]
            assert not (set(numbers) & reported), (numbers, now)
            reported.update(numbers)


def test_damaged_beacons_are_refused_or_read(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("beacons"):
        parser = BeaconParser({})
        advertisement = Advertisement(
            OPEN,
            -60,
            damage.word(),
            manufacturer_data={APPLE: damage.damaged_bytes(IBEACON)} if rng.random() < 0.5 else {},
            service_data={EDDYSTONE: damage.damaged_bytes(UID)} if rng.random() < 0.8 else {},
        )
        if not parser.concerns(advertisement):
            continue
        try:
            found = parser.read(advertisement, 0.0)
        except WireError:
            continue
        assert found is not None
        assert found.key.startswith(("ibeacon:", "eddystone:"))


def test_damaged_advertisements_of_other_sensors_are_refused_or_read(fuzz: Fuzz) -> None:
    """The libraries that read them raise whatever they like."""
    pytest.importorskip("ruuvitag_ble")
    from homebot.integrations.sensor_libraries.formats import SensorLibraryParser  # noqa: PLC0415 - an extra

    for damage, rng in fuzz("sensor-libraries"):
        parser = SensorLibraryParser({SEALED: KEY})
        for _ in range(rng.randrange(1, 4)):
            company, data, name = rng.choice(OTHER_SENSORS)
            data = damage.damaged_bytes(data) if rng.random() < 0.8 else data
            is_service = isinstance(company, str)
            advertisement = Advertisement(
                rng.choice((OPEN, SEALED)),
                -60,
                name,
                service_data={str(company): data} if is_service else {},
                manufacturer_data={} if is_service else {int(company): data},
                service_uuids=(full_uuid("ec88"),) if rng.random() < 0.5 else (),
            )
            try:
                found = parser.read(advertisement, 0.0)
            except WireError:
                continue
            parts = {} if found is None else {one.id: one for one in found.parts}
            for one in () if found is None else found.values:
                assert one.part in parts
                assert one.capability in CAPABILITIES


def test_damaged_reports_and_values_of_a_profile_are_refused_or_read(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("gatt"):
        profile = BUILT_IN["gatt_light"]
        state = profile.unknown_state()
        try:
            values: dict[str, PlainValue] = profile.read(damage.damaged_bytes(b"\x01\x7f"), state)
        except WireError:
            continue
        for name, value in values.items():
            assert can_report(profile.part(), name, value), (name, value)
        assert len(profile.write("level", rng.uniform(0, 100), state)) == 2
