"""The check of clients' tokens: whoever guesses waits, and is named."""

from __future__ import annotations

import anyio

from homebot.bridges.access_settings import AccessSettings
from homebot.bridges.admission import is_token
from homebot.bridges.token_guard import TokenGuard
from homebot.clock import Clock

__all__ = ["TokenCheck"]


class TokenCheck:
    """The check of the tokens that clients of one server show.

    Args:
        settings: The settings of the server, with its token.
        clock: The clock to live by.

    Attributes:
        wrong: Number of wrong tokens.
    """

    def __init__(self, settings: AccessSettings, clock: Clock) -> None:
        self.wrong = 0
        self._settings = settings
        self._clock = clock
        self._guard = TokenGuard()

    async def check(self, address: str, token: str) -> bool | None:
        """Return whether a client at *address* shows the right token; None where too many from there wait already."""
        if self._settings.token is None:
            return True
        now = self._clock.monotonic
        wait = self._guard.begin(address, now())
        if wait is None:
            return None
        is_wrong = False
        try:
            await anyio.sleep(wait)
            is_wrong = not is_token(self._settings, token)
        finally:
            self._guard.end(address, now(), waited=wait > 0, was_wrong=is_wrong)
        self.wrong += is_wrong
        return not is_wrong

    def problems(self) -> tuple[str, ...]:
        """Return who guesses, as text for a health report."""
        guessing = self._guard.throttled_addresses(self._clock.monotonic())
        return (f"wrong tokens were received from {', '.join(guessing[:5])}",) if guessing else ()
