"""The check of clients' tokens, with delays for guessing addresses."""

from __future__ import annotations

from collections.abc import Mapping

import anyio
from pydantic import SecretStr

from homebot.bridges.admission import name_of_token
from homebot.bridges.token_guard import TokenGuard
from homebot.clock import Clock

__all__ = ["TokenCheck"]


class TokenCheck:
    """The check of the tokens that clients of one server show.

    Args:
        tokens: The right tokens by name; at least one.

    Attributes:
        wrong: Number of wrong tokens.
    """

    def __init__(self, tokens: Mapping[str, SecretStr], clock: Clock) -> None:
        self.wrong = 0
        self._tokens = tokens
        self._clock = clock
        self._guard = TokenGuard()

    async def check(self, address: str, token: str) -> str | None:
        """Return the name of the *token* that a client at *address* shows; empty for a wrong one.

        None where too many from there wait already.
        """
        now = self._clock.monotonic
        name = name_of_token(self._tokens, token)
        if name and self._guard.is_proven(address, name, token):
            return name
        wait = self._guard.begin(address, now())
        if wait is None:
            return None
        is_wrong = False
        try:
            await anyio.sleep(wait)
            is_wrong = not name
        finally:
            self._guard.end(address, now(), waited=wait > 0, was_wrong=is_wrong)
        self.wrong += is_wrong
        if name:
            self._guard.prove(address, name)
        return name

    def problems(self) -> tuple[str, ...]:
        """Return the guessing addresses, as text for a health report."""
        guessing = self._guard.throttled_addresses(self._clock.monotonic())
        return (f"wrong tokens were received from {', '.join(guessing[:5])}",) if guessing else ()
