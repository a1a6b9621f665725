"""Damaged beacons and notified values of Bluetooth: refused in our words, or understood."""

from tests.fuzz.conftest import Fuzz
from tests.simulated.ble_family import LIGHT_PROFILE

from homebot.conventions.bluetooth.beacons import APPLE, EDDYSTONE, BeaconParser
from homebot.conventions.bluetooth.broadcast import Advertisement
from homebot.conventions.bluetooth.gatt_profile import GattProfile
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.gateways.announced.gateway_device import can_report

OPEN = "A4:C1:38:00:00:01"
IBEACON = bytes.fromhex("0215f7826da64fa24e988024bc5b71e0893e00010002c5")
UID = bytes.fromhex("00ee00112233445566778899aabbccddeeff0000")


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


def test_damaged_reports_and_values_of_a_profile_are_refused_or_read(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("gatt"):
        profile = GattProfile.model_validate(LIGHT_PROFILE)
        state = profile.unknown_state()
        try:
            values: dict[str, PlainValue] = profile.read(damage.damaged_bytes(b"\x01\x7f"), state)
        except WireError:
            continue
        for name, value in values.items():
            assert can_report(profile.part(), name, value), (name, value)
        assert len(profile.write("level", rng.uniform(0, 100), state)) == 2
