"""Encrypted packets, by the example of https://bthome.io/encryption."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.bthome.encryption import MAX_REMEMBERED, RESTARTS_AFTER, RESTARTS_BELOW, BindKey, seal
from homebot.conventions.bthome.packet import read_frame
from homebot.errors import WireError

KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
ADDRESS = bytes.fromhex("5448E68F80A5")
EXAMPLE = bytes.fromhex("41a47266c95f730011223378237214")


def packet(counter: int, objects: bytes = b"\x01\x61") -> bytes:
    return seal(KEY, ADDRESS, 0x41, counter, objects)


def opened(key: BindKey, data: bytes, now: float = 0.0) -> bytes:
    found = key.open(read_frame(data), now)
    assert found is not None
    return found


def test_the_example_of_the_specification_is_opened() -> None:
    assert opened(BindKey(KEY, ADDRESS), EXAMPLE).hex() == "02ca0903bf13"


def test_the_example_of_the_specification_is_sealed() -> None:
    assert seal(KEY, ADDRESS, 0x41, 0x33221100, bytes.fromhex("02ca0903bf13")) == EXAMPLE


def test_a_packet_is_opened_once_and_an_older_one_not_at_all() -> None:
    key = BindKey(KEY, ADDRESS)
    assert opened(key, packet(500)) == opened(key, packet(501)) == b"\x01\x61"
    assert key.open(read_frame(packet(501)), 600.0) is None
    with pytest.raises(WireError, match="500 does not follow 501"):
        opened(key, packet(500), 600.0)


def test_another_packet_with_the_same_counter_is_a_replay() -> None:
    key = BindKey(KEY, ADDRESS)
    opened(key, packet(500))
    with pytest.raises(WireError, match="500 does not follow 500"):
        opened(key, packet(500, b"\x01\x62"), 600.0)


def test_a_counter_wraps_around() -> None:
    key = BindKey(KEY, ADDRESS)
    for counter in (2**32 - 2, 2**32 - 1, 0, 1):
        assert opened(key, packet(counter)) == b"\x01\x61"
    with pytest.raises(WireError, match="4294967295 does not follow 1"):
        opened(key, packet(2**32 - 1), 600.0)


def test_a_counter_begins_again_with_a_new_battery() -> None:
    key = BindKey(KEY, ADDRESS)
    opened(key, packet(500))
    assert opened(key, packet(3), RESTARTS_AFTER) == b"\x01\x61"
    assert opened(key, packet(4), RESTARTS_AFTER) == b"\x01\x61"
    with pytest.raises(WireError, match="replay"):
        opened(key, packet(3), RESTARTS_AFTER)


@pytest.mark.parametrize(
    ("counter", "now"), [(RESTARTS_BELOW, 3600.0), (3, RESTARTS_AFTER - 0.1)], ids=["too high", "too soon"]
)
def test_a_lower_counter_is_no_new_battery(counter: int, now: float) -> None:
    key = BindKey(KEY, ADDRESS)
    opened(key, packet(500))
    with pytest.raises(WireError, match="replay"):
        opened(key, packet(counter), now)


def test_a_recorded_packet_with_a_low_counter_is_no_new_battery() -> None:
    """As in ``bthome-ble`` a counter may fall below 100; but what was opened before is not opened again."""
    key = BindKey(KEY, ADDRESS)
    for counter in (5, 500):
        opened(key, packet(counter))
    with pytest.raises(WireError, match="5 does not follow 500"):
        opened(key, packet(5), 3600.0)
    assert opened(key, packet(5, b"\x01\x62"), 3600.0) == b"\x01\x62"


def test_a_recorded_packet_is_refused_after_the_counter_began_again() -> None:
    key = BindKey(KEY, ADDRESS)
    opened(key, packet(500))
    opened(key, packet(0), RESTARTS_AFTER)
    with pytest.raises(WireError, match="500 does not follow 0"):
        opened(key, packet(500), RESTARTS_AFTER)
    assert opened(key, packet(1), RESTARTS_AFTER) == b"\x01\x61"


def test_a_bounded_number_of_packets_is_remembered() -> None:
    key = BindKey(KEY, ADDRESS)
    for number in range(MAX_REMEMBERED + 50):
        opened(key, packet(7, number.to_bytes(2)), number * RESTARTS_AFTER)
    for number in range(MAX_REMEMBERED + 50):
        opened(key, packet(RESTARTS_BELOW + number))
    assert len(key._low) == len(key._recent) == MAX_REMEMBERED


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 50), st.floats(0, 100)), max_size=60),
)
def test_no_recorded_packet_is_ever_opened_twice(first: int, steps: list[tuple[int, int, float]]) -> None:
    """A device counts on, loses its battery at times, and somebody sends any of its packets again."""
    key, now, counter, content = BindKey(KEY, ADDRESS), 0.0, first, 0
    sent: list[bytes] = []
    times: dict[bytes, int] = {}
    for what, number, pause in steps:
        now += pause
        if what == 0 and sent:
            data = sent[number % len(sent)]
        else:
            counter = number if what == 1 else (counter + 1 + number) % 2**32
            content += 1
            data = packet(counter, content.to_bytes(2))
            sent.append(data)
        try:
            found = key.open(read_frame(data), now)
        except WireError:
            continue
        times[data] = times.get(data, 0) + (found is not None)
    assert set(times.values()) <= {0, 1}


def test_a_packet_that_cannot_be_opened_does_not_move_the_counter() -> None:
    key = BindKey(KEY, ADDRESS)
    forged = seal(bytes(16), ADDRESS, 0x41, 2**31 - 1, b"\x01\x61")
    opened(key, packet(499))
    with pytest.raises(WireError, match="bind key"):
        opened(key, forged)
    assert opened(key, packet(500)) == b"\x01\x61"


def test_a_too_short_packet_is_refused() -> None:
    with pytest.raises(WireError, match="too short"):
        opened(BindKey(KEY, ADDRESS), EXAMPLE[:9])


def test_a_key_is_not_shown() -> None:
    key = BindKey(KEY, ADDRESS)
    assert KEY.hex() not in repr(key)
    with pytest.raises(WireError) as caught:
        opened(key, EXAMPLE[:-1] + b"\x00")
    assert KEY.hex() not in str(caught.value)


@given(st.binary(min_size=1, max_size=20), st.integers(0, 2**32 - 1), st.integers(0, 14), st.integers(1, 255))
def test_a_changed_packet_is_refused(objects: bytes, counter: int, where: int, change: int) -> None:
    sealed = bytearray(seal(KEY, ADDRESS, 0x41, counter, objects))
    at = 1 + where % (len(sealed) - 1)
    sealed[at] ^= change
    with pytest.raises(WireError):
        opened(BindKey(KEY, ADDRESS), bytes(sealed))
