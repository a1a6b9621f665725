"""The code by which the first page of a new home logs in; its owner reads it in the terminal of ``homebot run``."""

import secrets
from typing import Final, final

from pydantic import SecretStr

from homebot.clock import Clock

MINUTES: Final = 15
"""How long a code is valid."""

_LETTERS: Final = "23456789ABCDEFGHJKMNPQRSTVWXYZ"
"""None of them looks like another."""

_LENGTH: Final = 8
_MAX_WRONG: Final = 20


@final
class FirstCode:
    """A code that lets one page in, once and with every right; 20 wrong ones end it, from all addresses together.

    Attributes:
        secret: The code: capitals and digits.
    """

    def __init__(self, clock: Clock) -> None:
        self.secret = SecretStr("".join(secrets.choice(_LETTERS) for _ in range(_LENGTH)))
        self._clock = clock
        self._until = clock.monotonic() + 60 * MINUTES
        self._tries = _MAX_WRONG

    def use(self) -> bool:
        """Return whether it was valid; it is not any more."""
        was_valid = self._tries > 0 and self._clock.monotonic() < self._until
        self._tries = 0
        return was_valid

    def count_wrong(self) -> None:
        """Count a wrong token or code."""
        self._tries -= 1
