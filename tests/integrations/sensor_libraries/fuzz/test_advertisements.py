"""Damaged advertisements of the sensors that libraries read: refused in our words, or understood."""

import pytest
from tests.fuzz.conftest import Fuzz

from homebot.conventions.bluetooth.broadcast import Advertisement, full_uuid
from homebot.devices.capabilities import CAPABILITIES
from homebot.errors import WireError

KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
OPEN, SEALED = "A4:C1:38:00:00:01", "A4:C1:38:00:00:02"
OTHER_SENSORS: tuple[tuple[str | int, bytes, str], ...] = (
    (full_uuid("fe95"), bytes.fromhex("5020aa01da219335342d580d1004fe004802"), "Test"),
    (full_uuid("fe95"), bytes.fromhex("5858480b685f12342d585a0b1841e2aa000e00a4964fb5"), "Test"),
    (0x0499, bytes.fromhex("0505a060a0c89afd34028cff006376726976dead7b3fefaf"), "Ruuvi"),
    (0xEC88, bytes.fromhex("00034db26400"), "GVH5075_DBF8"),
    (2044, bytes.fromhex("c71200c83d5606"), "sps"),
)


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
