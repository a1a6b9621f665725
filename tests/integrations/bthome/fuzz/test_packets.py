"""Damaged packets of BTHome, and packets that were recorded: refused in our words, or understood."""

from tests.fuzz.conftest import Fuzz

from homebot.conventions.bluetooth.broadcast import Advertisement, full_uuid
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
