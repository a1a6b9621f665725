"""Encrypted packets, by the example of https://bthome.io/encryption."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.bthome.encryption import BindKey, seal
from homebot.conventions.bthome.packet import read_frame
from homebot.errors import WireError

KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
ADDRESS = bytes.fromhex("5448E68F80A5")
EXAMPLE = bytes.fromhex("41a47266c95f730011223378237214")


def test_the_example_of_the_specification_is_opened() -> None:
    assert BindKey(KEY, ADDRESS).open(read_frame(EXAMPLE)).hex() == "02ca0903bf13"


def test_the_example_of_the_specification_is_sealed() -> None:
    assert seal(KEY, ADDRESS, 0x41, 0x33221100, bytes.fromhex("02ca0903bf13")) == EXAMPLE


def test_a_packet_that_was_sent_before_is_refused_and_the_last_one_is_read_again() -> None:
    key = BindKey(KEY, ADDRESS)
    old, new = (read_frame(seal(KEY, ADDRESS, 0x41, counter, b"\x01\x61")) for counter in (500, 501))
    assert key.open(old) == key.open(new) == key.open(new) == b"\x01\x61"
    with pytest.raises(WireError, match="500 is below 501"):
        key.open(old)


def test_a_counter_begins_again_with_a_new_battery() -> None:
    key = BindKey(KEY, ADDRESS)
    for counter in (500, 0, 1):
        assert key.open(read_frame(seal(KEY, ADDRESS, 0x41, counter, b"\x01\x61"))) == b"\x01\x61"


def test_a_packet_that_cannot_be_opened_does_not_move_the_counter() -> None:
    key = BindKey(KEY, ADDRESS)
    forged = read_frame(seal(bytes(16), ADDRESS, 0x41, 2**32 - 1, b"\x01\x61"))
    with pytest.raises(WireError, match="bind key"):
        key.open(forged)
    assert key.open(read_frame(seal(KEY, ADDRESS, 0x41, 500, b"\x01\x61"))) == b"\x01\x61"


def test_one_that_is_too_short_is_refused() -> None:
    with pytest.raises(WireError, match="too short"):
        BindKey(KEY, ADDRESS).open(read_frame(EXAMPLE[:9]))


def test_a_key_is_not_shown() -> None:
    key = BindKey(KEY, ADDRESS)
    assert KEY.hex() not in repr(key)
    with pytest.raises(WireError) as caught:
        key.open(read_frame(EXAMPLE[:-1] + b"\x00"))
    assert KEY.hex() not in str(caught.value)


@given(st.binary(min_size=1, max_size=20), st.integers(0, 2**32 - 1), st.integers(0, 14), st.integers(1, 255))
def test_what_was_changed_on_its_way_is_refused(objects: bytes, counter: int, where: int, change: int) -> None:
    sealed = bytearray(seal(KEY, ADDRESS, 0x41, counter, objects))
    at = 1 + where % (len(sealed) - 1)
    sealed[at] ^= change
    with pytest.raises(WireError):
        BindKey(KEY, ADDRESS).open(read_frame(bytes(sealed)))
