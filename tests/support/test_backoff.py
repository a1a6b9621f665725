"""Delays between tries."""

# ruff: noqa: S311 - jitter is no secret

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from homebot.clock import ManualClock
from homebot.support.backoff import LINK_BACKOFF, REFUSED_BACKOFF, Backoff, BackoffCounter

PLAIN = Backoff(first=1.0, factor=2.0, cap=5.0, late_cap=60.0, late_after=100.0, jitter=0.0)


def test_delays_double_up_to_the_cap() -> None:
    assert [PLAIN.delay(n, 0.0, Random(1)) for n in (1, 2, 3, 4, 5)] == [1.0, 2.0, 4.0, 5.0, 5.0]


def test_after_a_long_time_the_late_cap_holds() -> None:
    assert PLAIN.delay(10_000, 100.0, Random(1)) == 60.0


def test_the_same_seed_gives_the_same_delays() -> None:
    assert [LINK_BACKOFF.delay(n, 0.0, Random(7)) for n in range(1, 9)] == [
        LINK_BACKOFF.delay(n, 0.0, Random(7)) for n in range(1, 9)
    ]


@given(st.integers(1, 10**6), st.floats(0, 299), st.randoms(use_true_random=False))
def test_a_link_is_tried_again_within_one_and_a_half_seconds(failures: int, failing_for: float, random: Random) -> None:
    """With the handshake that is less than two seconds after the broker's return."""
    assert 0 <= LINK_BACKOFF.delay(failures, failing_for, random) <= 1.5


@given(st.integers(1, 10**6), st.floats(0, 10**6), st.randoms(use_true_random=False))
def test_a_refused_login_is_never_repeated_quickly(failures: int, failing_for: float, random: Random) -> None:
    assert 7.5 <= REFUSED_BACKOFF.delay(failures, failing_for, random) <= 300


def test_pauses_grow_with_each_failure_until_an_attempt_succeeds() -> None:
    retries = BackoffCounter(ManualClock(), Random(1))
    assert [retries.fail(PLAIN) for _ in range(3)] == [1.0, 2.0, 4.0]
    retries.succeed()
    assert retries.fail(PLAIN) == 1.0


def test_a_first_refusal_after_long_silence_has_the_first_pause() -> None:
    clock, refused = ManualClock(), PLAIN._replace(first=2.0)
    retries = BackoffCounter(clock, Random(1))
    for _ in range(100):
        retries.fail(PLAIN)
    clock.advance(PLAIN.late_after)
    assert [retries.fail(refused) for _ in range(2)] == [2.0, 4.0]
    assert retries.fail(PLAIN) == PLAIN.late_cap


def test_an_attempt_that_lasted_counts_as_a_success() -> None:
    clock = ManualClock()
    retries = BackoffCounter(clock, Random(1), steady_after=60.0)
    for lasts, pause in ((0.0, 1.0), (60.0, 2.0), (61.0, 1.0), (1.0, 2.0)):
        retries.begin()
        clock.advance(lasts)
        assert retries.fail(PLAIN) == pause


def test_the_late_cap_holds_when_all_has_failed_for_long() -> None:
    clock = ManualClock()
    retries = BackoffCounter(clock, Random(1))
    for _ in range(10):
        retries.fail(PLAIN)
    clock.advance(PLAIN.late_after)
    assert retries.fail(PLAIN) == 60.0
