"""The forms in which numbers are stored, and their summaries."""

from array import array
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import WireError
from homebot.features.history.buckets import FIVE_MINUTES, HOUR, buckets_of, combined, wider
from homebot.features.history.codec import (
    decode_batch,
    decode_buckets,
    decode_values,
    encode_batch,
    encode_buckets,
    encode_values,
)

START = 490_000 * HOUR
GOLDEN = "017801631060506740010d0ea6a60e0e000b2e01e2"
NUMBERS = st.floats(-1e9, 1e9).map(lambda number: round(number, 3))
POINTS = st.lists(st.tuples(st.integers(0, HOUR - 1), NUMBERS), min_size=1, max_size=60)


def test_a_stored_hour_is_read_for_ever() -> None:
    """The bytes of version 1; those of another version are refused, not misread."""
    data = bytes.fromhex(GOLDEN)
    assert decode_values(START, data) == (array("q", [START, START + 10_000]), array("d", [21.5, 21.25]))
    with pytest.raises(WireError, match="cannot be read"):
        decode_values(START, b"\x02" + data[1:])
    with pytest.raises(WireError):
        decode_values(START, data[:-8])


@given(POINTS)
def test_what_is_written_is_read(points: list[tuple[int, float]]) -> None:
    points.sort()
    times = array("q", (START + at for at, _ in points))
    values = array("d", (value for _, value in points))
    assert decode_values(START, encode_values(START, times, values)) == (times, values)
    series = array("H", range(len(points)))
    assert decode_batch(encode_batch(series, times, values)) == (series, times, values)


@given(POINTS)
def test_summaries_are_those_of_the_values(points: list[tuple[int, float]]) -> None:
    times, values = [at for at, _ in sorted(points)], [value for _, value in points]
    fives = buckets_of(times, values, FIVE_MINUTES, HOUR, is_counter=True)
    (hour,) = wider(fives, 12).values()
    assert (hour.low, hour.high, hour.last) == (min(values), max(values), values[-1])
    assert hour.low <= hour.mean <= hour.high
    assert hour.rise == pytest.approx(sum(max(after - before, 0.0) for before, after in pairwise(values)), abs=1e-3)
    stored = decode_buckets(7, encode_buckets({7 + number: one for number, one in fives.items()}, 7, 12))
    assert stored.keys() == {7 + number for number in fives}
    for number, one in fives.items():
        assert stored[7 + number][:2] == one[:2]
        assert tuple(stored[7 + number]) == pytest.approx(tuple(one), rel=1e-6)


def test_a_mean_counts_each_value_for_as_long_as_it_lasted() -> None:
    """A kettle takes 2,000 W for 30 of 300 seconds."""
    (bucket,) = buckets_of([0, 30_000], [2000.0, 0.0], FIVE_MINUTES, FIVE_MINUTES, is_counter=False).values()
    assert bucket.mean == pytest.approx(200.0)
    assert combined(bucket, bucket).seconds == 600
