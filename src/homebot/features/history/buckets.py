"""Summaries of numbers over equal spans of time: minimum, maximum, time-weighted mean, last, and rise. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

FIVE_MINUTES: Final = 300_000
HOUR: Final = 3_600_000
"""Milliseconds."""

COUNTERS: Final = frozenset({"energy", "energy_returned"})
"""Capabilities that only grow, except for resets."""


class Bucket(NamedTuple):
    """The summary of the values in one span of time.

    Attributes:
        mean: The mean, weighted by the duration of each value.
        seconds: The time for which a value was known.
        rise: The sum of the positive steps of a counter; 0 for other numbers.
    """

    low: float
    high: float
    mean: float
    last: float
    seconds: float
    rise: float


def buckets_of(
    times: Sequence[int], values: Sequence[float], width: int, until: int, *, is_counter: bool
) -> dict[int, Bucket]:
    """Return the buckets of *values* by number, ``time // width``; there are none without values.

    Args:
        times: Milliseconds since the Unix epoch, in the order of arrival; they may go back if the clock was set.
        values: The value at each time; it lasts until the next one, and no longer than its bucket. NaN is none, and the
            next one is no rise.
        width: Width of a bucket, in milliseconds.
    """
    sums: dict[int, list[float]] = {}
    before = values[0] if values else 0.0
    for at, value, after in zip(times, values, (*times[1:], until), strict=True):
        if value != value:
            before = value
            continue
        number = at // width
        end = min((number + 1) * width, max(until, at))
        lasted = max((after if at <= after < end else end) - at, 1)
        step = value - before
        before = value
        rise = step if is_counter and step > 0 else 0.0
        known = sums.get(number)
        if known is None:
            sums[number] = [value, value, value * lasted, value, lasted, rise]
            continue
        known[0] = min(known[0], value)
        known[1] = max(known[1], value)
        known[2] += value * lasted
        known[3] = value
        known[4] += lasted
        known[5] += rise
    return {
        number: Bucket(low, high, min(max(area / lasted, low), high), last, lasted / 1000, rise)
        for number, (low, high, area, last, lasted, rise) in sums.items()
    }


def combined(first: Bucket | None, second: Bucket) -> Bucket:
    """Return the summary of both; *second* is the later one."""
    if first is None:
        return second
    seconds = first.seconds + second.seconds
    mean = (first.mean * first.seconds + second.mean * second.seconds) / seconds
    low, high = min(first.low, second.low), max(first.high, second.high)
    return Bucket(low, high, min(max(mean, low), high), second.last, seconds, first.rise + second.rise)


def wider(buckets: Mapping[int, Bucket] | Iterable[tuple[int, Bucket]], times: int) -> dict[int, Bucket]:
    """Return *buckets*, oldest first, each combined from *times* buckets."""
    wide: dict[int, Bucket] = {}
    for number, bucket in buckets.items() if isinstance(buckets, Mapping) else buckets:
        wide[number // times] = combined(wide.get(number // times), bucket)
    return wide
