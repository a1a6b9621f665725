"""The check of clients' tokens, with delays against guessing.

Right and wrong tokens wait equally long, as a guesser could otherwise hang up early. An address may be wrong a few
times without a delay. After that each of its tokens waits, longer after each wrong one, and only a few may wait at a
time, so that an address tries at most four tokens a second, and an honest client there gets in after a second.

A long token that was right from an address before does not wait there, so that guessers at the same address, or behind
the same router, cannot lock its program out. That would tell them at once that a guess is right, which only helps with
short tokens.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import anyio
from pydantic import SecretStr

from homebot.bridges.admission import name_of_token
from homebot.clock import Clock
from homebot.support.addresses import network_of
from homebot.support.bounded_map import BoundedMap

_FREE_ATTEMPTS = 5
_MIN_DELAY_S, _MAX_DELAY_S = 0.1, 1.0
_DECAY_INTERVAL = 10.0
"""Seconds after which one wrong token is forgotten."""

_MAX_WRONG = 20
_MAX_WAITING = 4
_MAX_ADDRESSES = 1000
_MAX_PROVEN = 1000
_LONG = 16
"""Characters of a token too long to guess."""


@dataclass(slots=True)
class _Attempts:
    wrong: float
    since: float
    waiting: int = 0


@final
class TokenCheck:
    """The check of the tokens of one server's clients.

    It remembers the wrong tokens of the last 1,000 addresses with any, and the last 1,000 programs admitted.

    Args:
        tokens: The right tokens by name; at least one.
    """

    def __init__(self, tokens: Mapping[str, SecretStr], clock: Clock) -> None:
        self.wrong = 0
        self._tokens = tokens
        self._clock = clock
        self._attempts: BoundedMap[str, _Attempts] = BoundedMap(_MAX_ADDRESSES)
        self._proven: BoundedMap[tuple[str, str], None] = BoundedMap(_MAX_PROVEN)

    async def check(self, address: str, token: str) -> str | None:
        """Return the name of the *token* of a client at *address*; empty if it is wrong.

        None if too many from there are waiting already. A cancelled check does not count.
        """
        network, name = network_of(address), name_of_token(self._tokens, token)
        if len(token) >= _LONG and (network, name) in self._proven:
            return name
        attempts, wait = self._attempts_of(network), 0.0
        if attempts.wrong >= _FREE_ATTEMPTS:
            if attempts.waiting >= _MAX_WAITING:
                return None
            attempts.waiting += 1
            wait = min(_MAX_DELAY_S, _MIN_DELAY_S * 2 ** (attempts.wrong - _FREE_ATTEMPTS))
        try:
            await anyio.sleep(wait)
        finally:
            attempts = self._attempts_of(network)
            attempts.waiting = max(0, attempts.waiting - (wait > 0))
        if name:
            self._proven[network, name] = None
        else:
            self.wrong += 1
            attempts.wrong = min(_MAX_WRONG, attempts.wrong + 1)
            self._attempts[network] = attempts
        return name

    def problems(self) -> tuple[str, ...]:
        """Return the guessing addresses (IPv6: networks), in words for a health report."""
        guessing = [attempt for attempt in tuple(self._attempts) if self._attempts_of(attempt).wrong >= _FREE_ATTEMPTS]
        return (f"wrong tokens were received from {', '.join(guessing[:5])}",) if guessing else ()

    def _attempts_of(self, network: str) -> _Attempts:
        now = self._clock.monotonic()
        attempts = self._attempts.get(network) or _Attempts(0.0, now)
        attempts.wrong = max(0.0, attempts.wrong - (now - attempts.since) / _DECAY_INTERVAL)
        attempts.since = now
        if not attempts.wrong and not attempts.waiting:
            self._attempts.pop(network, None)
        return attempts
