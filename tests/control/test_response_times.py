"""How long each device usually takes, which bounds the wait for its answer."""

import pytest

from homebot.control.timeline.profile import DeviceProfile

FIRST = 10.0


def times(*seconds: float, sendings: int = 1) -> DeviceProfile:
    found = DeviceProfile()
    for one in seconds:
        found.learn_time("on_off", one, FIRST, sendings=sendings)
    return found


def limit(known: DeviceProfile, capability: str = "on_off") -> float:
    return known.answer_time((capability,), FIRST)[0]


def longest(known: DeviceProfile) -> float:
    return known.answer_time(("on_off",), FIRST)[1]


@pytest.mark.parametrize(
    ("seconds", "seconds_to_wait"),
    [((), 10.0), ((0.1, 0.1), 10.0), ((0.1, 0.1, 0.1), 2.0), ((0.1, 2.0, 1.0), 7.0), ((5.0,), 16.0), ((60.0,), 120.0)],
)
def test_a_device_has_three_times_the_longest_that_it_took_and_a_second(
    seconds: tuple[float, ...], seconds_to_wait: float
) -> None:
    assert limit(times(*seconds)) == pytest.approx(seconds_to_wait)


def test_the_longest_answer_counts_as_a_second_where_fewer_than_three_are_known() -> None:
    assert (longest(times()), longest(times(0.1, 0.1)), longest(times(4.0))) == (1.0, 1.0, 4.0)
    assert longest(times(0.1, 0.4, 0.1)) == 0.4


def test_each_capability_has_its_own_limit() -> None:
    assert limit(times(0.1, 0.1, 0.1), "level") == 10.0


def test_only_the_last_sixteen_count() -> None:
    assert limit(times(20.0, *[0.1] * 16)) == 2.0


def test_an_answer_to_a_repeated_command_counts_as_no_longer_than_the_first_limit() -> None:
    assert limit(times(8.0, sendings=2)) == 25.0
    assert limit(times(25.0, sendings=3)) == 31.0


def test_a_device_that_misses_each_first_command_does_not_answer_later_each_time() -> None:
    found = times()
    for _ in range(20):
        repeated_after = limit(found) / 3
        found.learn_time("on_off", repeated_after + 0.1, FIRST, sendings=2)
    assert limit(found) < 32.0


def test_an_answer_that_says_what_was_known_before_never_makes_the_wait_longer() -> None:
    found = times()
    for one in (6.0, 0.4, 0.4, 0.4, 2.0):
        found.learn_time("on_off", one, FIRST, is_change=False)
    assert limit(found) == pytest.approx(2.2)
