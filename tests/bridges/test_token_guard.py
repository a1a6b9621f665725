"""Guessing tokens becomes slow, and stays bearable for whoever knows the right one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.bridges.token_guard import TokenGuard

pytestmark = pytest.mark.slow


def guess(guard: TokenGuard, address: str, now: float) -> float | None:
    wait = guard.begin(address, now)
    if wait is not None:
        guard.end(address, now + wait, waited=wait > 0, was_wrong=True)
    return wait


def guessed(address: str) -> TokenGuard:
    """A guard that was shown thirty wrong tokens from an address."""
    guard = TokenGuard()
    for _ in range(30):
        guess(guard, address, 0.0)
    return guard


def test_the_first_wrong_tokens_cost_nothing_and_then_each_waits_longer_up_to_a_second() -> None:
    guard = TokenGuard()
    waits = [guess(guard, "10.0.0.5", 0.0) for _ in range(12)]
    assert waits[:5] == [0.0] * 5
    assert waits[5] == 0.1
    assert [one for one in waits[5:] if one is not None] == sorted(one for one in waits[5:] if one is not None)
    assert waits[-1] == 1.0


def test_the_right_token_waits_as_long_as_a_wrong_one_and_is_not_counted() -> None:
    guard = guessed("10.0.0.5")
    assert guard.begin("10.0.0.5", 0.0) == 1.0
    guard.end("10.0.0.5", 1.0, waited=True, was_wrong=False)
    assert guard.begin("10.0.0.6", 0.0) == 0.0


def test_only_four_tokens_of_an_address_wait_at_a_time() -> None:
    guard = guessed("10.0.0.5")
    assert [guard.begin("10.0.0.5", 0.0) for _ in range(5)] == [1.0, 1.0, 1.0, 1.0, None]
    guard.end("10.0.0.5", 1.0, waited=True, was_wrong=True)
    assert guard.begin("10.0.0.5", 1.0) == 1.0


def test_wrong_tokens_are_forgotten_in_time() -> None:
    guard = guessed("10.0.0.5")
    assert guard.throttled_addresses(0.0) == ("10.0.0.5",)
    assert guard.begin("10.0.0.5", 155.0) == 0.0
    assert guard.throttled_addresses(300.0) == ()
    assert len(guard) == 0


def test_addresses_of_one_network_are_one_address() -> None:
    guard = TokenGuard()
    for number in range(30):
        guess(guard, f"2001:db8::{number:x}", 0.0)
    assert guard.begin("2001:db8::ffff", 0.0) == 1.0
    assert guard.begin("2001:db8:0:1::1", 0.0) == 0.0
    guard = guessed("::ffff:10.0.0.5")
    assert guard.begin("10.0.0.5", 0.0) == 1.0


@pytest.mark.no_cover
@given(st.lists(st.tuples(st.integers(0, 3000), st.floats(0, 100)), max_size=300))
def test_it_remembers_a_thousand_addresses_at_most(guesses: list[tuple[int, float]]) -> None:
    guard = TokenGuard()
    now = 0.0
    for number in range(1500):
        guess(guard, f"10.1.{number // 256}.{number % 256}", now)
    for address, later in guesses:
        now += later
        wait = guess(guard, f"10.0.{address // 256}.{address % 256}", now)
        assert wait is None or 0 <= wait <= 1
        assert len(guard) <= 1000


def test_a_long_token_that_was_right_does_not_wait_and_a_short_one_tells_no_guesser_anything() -> None:
    guard = TokenGuard()
    guard.prove("10.0.0.5", "robot")
    assert guard.is_proven("10.0.0.5", "robot", "0123456789abcdef")
    assert not guard.is_proven("10.0.0.5", "robot", "1234")
    assert not guard.is_proven("10.0.0.6", "robot", "0123456789abcdef")
    assert not guard.is_proven("10.0.0.5", "owner", "0123456789abcdef")


def test_programs_that_came_in_are_remembered_within_bounds() -> None:
    guard = TokenGuard()
    for number in range(1001):
        guard.prove(f"10.0.{number // 256}.{number % 256}", "robot")
    assert not guard.is_proven("10.0.0.0", "robot", "0123456789abcdef")
    assert guard.is_proven("10.0.0.1", "robot", "0123456789abcdef")
