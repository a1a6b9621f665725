"""Growing delays for those who guess a secret. Pure."""

from typing import Final, final

from homebot.support.bounded_map import BoundedMap

_FREE: Final = 3  # wrong secrets without a delay: people mistype
_FIRST: Final = 0.5
_LONGEST: Final = 8.0
"""Seconds; less than a CONNECT may wait, so that an honest client on the same host gets its chance."""

_FORGOTTEN: Final = 600.0  # seconds after the last wrong secret
_MOST: Final = 1000


class _Guesses:
    __slots__ = ("failed_at", "failures")

    def __init__(self) -> None:
        self.failures = 0
        self.failed_at = 0.0

    @property
    def delay(self) -> float:
        """Seconds after the last failure without another attempt."""
        excess = self.failures - _FREE
        return 0.0 if excess <= 0 else min(_FIRST * 2.0 ** min(excess - 1, 10), _LONGEST)


@final
class GuessDelays:
    """The delays of the last 1,000 guessers.

    After three wrong secrets each further one delays the next attempts: by half a second at first, twice as long each
    time, at most eight seconds. Ten minutes after the last one all are forgotten.
    """

    def __init__(self) -> None:
        self._guesses: BoundedMap[str, _Guesses] = BoundedMap(_MOST)

    def __len__(self) -> int:
        return len(self._guesses)

    def until(self, guesser: str) -> float:
        """Return when the next attempt is allowed; may be in the past."""
        found = self._guesses.get(guesser)
        return 0.0 if found is None else found.failed_at + found.delay

    def failed(self, guesser: str, now: float) -> tuple[int, float]:
        """Record a wrong secret; return the number of them, and the delay of the next attempt."""
        found = self._guesses.get(guesser)
        if found is None or found.failed_at < now - _FORGOTTEN:
            found = _Guesses()
        self._guesses[guesser] = found
        found.failed_at = now
        found.failures += 1
        return found.failures, found.delay
