"""Packets mean here what they mean to ``bthome-ble``, the parser of Home Assistant."""

import logging
from importlib.metadata import version

import pytest
from bthome_ble import BTHomeBluetoothDeviceData
from bthome_ble.const import MEAS_TYPES
from habluetooth import BluetoothServiceInfoBleak
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.bluetooth.bthome_objects import (
    BTHOME_OBJECTS,
    COMMAND,
    DEVICE_TYPE,
    FIRMWARE_3,
    FIRMWARE_4,
    PACKET_ID,
    RAW,
    TEXT,
    TIMESTAMP,
)
from homebot.integrations.bthome.formats.encryption import BindKey, seal
from homebot.integrations.bthome.formats.packet import BTHOME_UUID, read_frame, read_objects

ADDRESS = "5448E68F80A5"
KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
PRESSES = {
    "press": "single",
    "double_press": "double",
    "triple_press": "triple",
    "long_press": "long",
    "long_double_press": "long_double",
    "long_triple_press": "long_triple",
    "hold_press": "hold",
    "hold_release": "release",
}
SIMPLE = sorted(set(BTHOME_OBJECTS) - {PACKET_ID, COMMAND, TEXT, RAW, TIMESTAMP, DEVICE_TYPE, FIRMWARE_3, FIRMWARE_4})
COMPARED = [one for one in SIMPLE if one != 0x58]
"""All but the temperature in steps of 0.35 °C, which bthome-ble rounds to one digit."""


NEW_TO_ORACLE = set() if version("bthome-ble") >= "3.24" else {DEVICE_TYPE, FIRMWARE_3, FIRMWARE_4}


def oracle(data: bytes, key: bytes | None = None) -> list[object]:
    """The values of a packet as bthome-ble reads them, sorted by text."""
    logging.getLogger("bthome_ble").setLevel(logging.CRITICAL)
    address = ":".join(ADDRESS[at : at + 2] for at in range(0, 12, 2))
    info = BluetoothServiceInfoBleak(
        name="x",
        address=address,
        rssi=-60,
        manufacturer_data={},
        service_data={BTHOME_UUID: data},
        service_uuids=[BTHOME_UUID],
        source="",
        device=None,  # type: ignore[arg-type] # it is not asked
        advertisement=None,
        connectable=False,
        time=0.0,
        tx_power=-127,
    )
    parser = BTHomeBluetoothDeviceData(bindkey=key)
    update = parser.update(info)
    found: list[object] = [
        one.native_value
        for key_, one in update.entity_values.items()
        if key_.key not in {"signal_strength", "packet_id"}
    ]
    found += [one.native_value for one in update.binary_entity_values.values()]
    for event in update.events.values():
        steps = (event.event_properties or {}).get("steps")
        found.append(PRESSES.get(event.event_type, f"{event.event_type} {steps}"))
    return sorted(found, key=str)


def ours(data: bytes) -> list[object]:
    """Likewise as they are read here; safety is told the other way round, as the specification has it."""
    return sorted(
        (
            (not one.value) if one.object.is_inverted else one.value
            for one in read_objects(read_frame(data).body).values
            if one.value is not None
        ),
        key=str,
    )


def test_both_know_the_same_objects() -> None:
    assert set(BTHOME_OBJECTS) - NEW_TO_ORACLE == set(MEAS_TYPES)
    for object_id in SIMPLE:
        assert BTHOME_OBJECTS[object_id].size == MEAS_TYPES[object_id].data_length, hex(object_id)


def kind_of(object_id: int) -> str:
    """Its class at bthome-ble, of which that keeps one value, unless the very same object comes again."""
    known = MEAS_TYPES[object_id].meas_format
    return str(getattr(known, "device_class", known))


@st.composite
def objects(draw: st.DrawFn) -> bytes:
    """The objects of a packet, some of them twice or three times."""
    ids = draw(st.lists(st.sampled_from(COMPARED), min_size=1, max_size=5, unique_by=kind_of))
    found = b""
    for one in sorted(ids):
        size = BTHOME_OBJECTS[one].size
        for data in draw(st.lists(st.binary(min_size=size, max_size=size), min_size=1, max_size=3)):
            found += bytes([one]) + data
    return found


@given(objects())
def test_random_packets_have_the_same_values(body: bytes) -> None:
    expected, found = oracle(b"\x40" + body), ours(b"\x40" + body)
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        assert one == (pytest.approx(other) if isinstance(one, float) else other)


@given(objects(), st.integers(0, 2**32 - 1))
def test_random_packets_that_are_encrypted_are_opened_by_both(body: bytes, counter: int) -> None:
    sealed = seal(KEY, bytes.fromhex(ADDRESS), 0x41, counter, body)
    opened = BindKey(KEY, bytes.fromhex(ADDRESS)).open(read_frame(sealed), 0.0)
    assert opened is not None
    assert opened == body
    assert len(read_objects(opened).values) >= len(oracle(sealed, KEY)) > -1
    assert oracle(sealed, KEY) == oracle(b"\x40" + body)
