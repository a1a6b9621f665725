"""A delay for clients that guess tokens. No I/O.

The right token and wrong ones wait alike, otherwise a guesser could hang up early. An address may be
wrong a few times for nothing. After that each of its tokens waits, longer with each wrong one, and only a few may wait
at a time; so an address tries four tokens a second at most, and its honest client comes in after a second.

A long token that was right from an address before does not wait there: guessers at the same address, or behind the
same router, cannot lock its program out. They would learn at once that a guess is right, which helps them with short
tokens alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from homebot.support.addresses import network_of
from homebot.support.bounded_map import BoundedMap

__all__ = ["TokenGuard"]

_FREE_ATTEMPTS = 5
_FIRST_DELAY, _LONGEST_DELAY = 0.1, 1.0
_DECAY_INTERVAL = 10.0
"""Seconds after which one wrong token is forgotten."""

_MOST_WRONG = 20
_MOST_WAITING = 4
_MOST_ADDRESSES = 1000
_MOST_PROVEN = 1000
_LONG = 16
"""Characters of a token that is too long to be guessed."""


@dataclass(slots=True)
class _Attempts:
    wrong: float
    since: float
    waiting: int = 0


@final
class TokenGuard:
    """The wrong tokens of the 1,000 addresses that were wrong last, and the 1,000 programs that came in last."""

    def __init__(self) -> None:
        self._attempts: BoundedMap[str, _Attempts] = BoundedMap(_MOST_ADDRESSES)
        self._proven: BoundedMap[tuple[str, str], None] = BoundedMap(_MOST_PROVEN)

    def __len__(self) -> int:
        """Return the number of addresses that are remembered."""
        return len(self._attempts)

    def is_proven(self, address: str, name: str, token: str) -> bool:
        """Return whether the right *token*, of the program *name*, is long and was shown from *address* before."""
        return len(token) >= _LONG and (network_of(address), name) in self._proven

    def prove(self, address: str, name: str) -> None:
        """Record that the token of the program *name* was right from *address*."""
        self._proven[network_of(address), name] = None

    def begin(self, address: str, now: float) -> float | None:
        """Return the seconds that a token from *address* has to wait, or None where too many wait already.

        The caller that gets a number calls :meth:`end` in any case.
        """
        attempts = self._of(address, now)
        if attempts is None:
            return 0.0
        wrong = attempts.wrong - _FREE_ATTEMPTS
        if wrong < 0:
            return 0.0
        if attempts.waiting >= _MOST_WAITING:
            return None
        attempts.waiting += 1
        return float(min(_LONGEST_DELAY, _FIRST_DELAY * 2**wrong))

    def end(self, address: str, now: float, *, waited: bool, was_wrong: bool) -> None:
        """Record the end of an attempt; one that was given up is not wrong."""
        key = network_of(address)
        attempts = self._of(address, now)
        if attempts is not None and waited:
            attempts.waiting = max(0, attempts.waiting - 1)
        if not was_wrong:
            return
        if attempts is None:
            attempts = _Attempts(0.0, now)
        attempts.wrong = min(_MOST_WRONG, attempts.wrong + 1)
        self._attempts[key] = attempts

    def throttled_addresses(self, now: float) -> tuple[str, ...]:
        """Return the addresses (IPv6: networks) with delayed tokens."""
        known = [(address, self._of(address, now)) for address in tuple(self._attempts)]
        return tuple(
            address for address, attempts in known if attempts is not None and attempts.wrong >= _FREE_ATTEMPTS
        )

    def _of(self, address: str, now: float) -> _Attempts | None:
        key = network_of(address)
        attempts = self._attempts.get(key)
        if attempts is None:
            return None
        attempts.wrong -= (now - attempts.since) / _DECAY_INTERVAL
        attempts.since = now
        if attempts.wrong <= 0 and not attempts.waiting:
            del self._attempts[key]
            return None
        attempts.wrong = max(0.0, attempts.wrong)
        return attempts
