"""Encrypted packets, by the example of https://bthome.io/encryption."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import WireError
from homebot.integrations.bthome.formats.encryption import MAX_REMEMBERED, RESTARTS_AFTER, RESTARTS_BELOW, BindKey, seal
from homebot.integrations.bthome.formats.packet import read_frame

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


OTHER = b"\x01\x62"
SEQUENCES: dict[str, list[tuple[int, float, str] | tuple[int, float, str, bytes]]] = {
    "an older one is refused": [(500, 0, ""), (501, 0, ""), (500, 600, "500 does not follow 501")],
    "another one with the same counter is refused": [(500, 0, ""), (500, 600, "500 does not follow 500", OTHER)],
    "a counter wraps around": [
        *((counter, 0, "") for counter in (2**32 - 2, 2**32 - 1, 0, 1)),
        (2**32 - 1, 600, "4294967295 does not follow 1"),
    ],
    "a counter begins again with a new battery": [
        (500, 0, ""), (3, RESTARTS_AFTER, ""), (4, RESTARTS_AFTER, ""), (3, RESTARTS_AFTER, "replay"),
    ],
    "too high a counter is no new battery": [(500, 0, ""), (RESTARTS_BELOW, 3600, "replay")],
    "it is too soon for a new battery": [(500, 0, ""), (3, RESTARTS_AFTER - 0.1, "replay")],
    "what was opened before is no new battery": [
        (5, 0, ""), (500, 0, ""), (5, 3600, "5 does not follow 500"), (5, 3600, "", OTHER),
    ],
    "what was opened is refused after the counter began again": [
        (500, 0, ""), (0, RESTARTS_AFTER, ""), (500, RESTARTS_AFTER, "500 does not follow 0"), (1, RESTARTS_AFTER, ""),
    ],
}  # fmt: skip
"""Counter, time and refusal of packets, one after the other; as in ``bthome-ble`` a counter may fall below 100."""


@pytest.mark.parametrize("steps", SEQUENCES.values(), ids=SEQUENCES)
def test_counters_go_up_or_begin_again(steps: list[tuple[Any, ...]]) -> None:
    key = BindKey(KEY, ADDRESS)
    for counter, now, refusal, *objects in steps:
        data = packet(counter, *objects)
        if refusal:
            with pytest.raises(WireError, match=refusal):
                opened(key, data, now)
        else:
            assert opened(key, data, now) == (objects or [b"\x01\x61"])[0]


def test_the_last_packet_again_is_passed_over() -> None:
    key = BindKey(KEY, ADDRESS)
    opened(key, packet(501))
    assert key.open(read_frame(packet(501)), 600.0) is None


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
