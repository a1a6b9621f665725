"""A lock takes its time and may jam."""

from __future__ import annotations

import random

from homebot.house.devices import SimulatedDoorLock


def test_a_lock_turns_and_says_where_it_ended() -> None:
    """It is locked until the bolt is in."""
    lock = SimulatedDoorLock("lock", travel_time=2.0)
    assert lock.handle_command("unlock", 1.0) == ("unlocking",)
    assert lock.is_locked
    assert lock.advance(3.0) == ("unlocked",)
    assert not lock.is_locked
    assert lock.restore() == "unlock"


def test_a_jammed_lock_is_as_locked_as_it_was() -> None:
    """And says that it is jammed."""
    lock = SimulatedDoorLock("lock", jams=1.0, rng=random.Random(1))  # noqa: S311  # no secrets
    lock.handle_command("unlock", 0.0)
    assert lock.advance(2.0) == ("jammed",)
    assert lock.is_locked


def test_a_lock_that_jammed_tries_again() -> None:
    """About every other turn of this one works."""
    lock = SimulatedDoorLock("lock", jams=0.5, rng=random.Random(1))  # noqa: S311  # no secrets
    ends: set[str] = set()
    for turn in range(20):
        lock.handle_command("lock", turn * 10.0)
        ends.update(lock.advance(turn * 10.0 + 5.0))
    assert ends == {"jammed", "locked"}


def test_a_lock_knows_two_words() -> None:
    """Others it ignores."""
    assert SimulatedDoorLock("lock").handle_command("open", 0.0) == ()
