"""Response times of devices: how long each usually takes, which bounds the wait for its answer. Pure."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable
from typing import Final, final

__all__ = ["ResponseTimes"]

_KEPT: Final = 16
_ENOUGH: Final = 3
_FACTOR: Final = 3.0
_SPARE: Final = 1.0  # seconds
_SHORTEST: Final = 2.0
_LONGEST: Final = 120.0
_UNKNOWN: Final = 1.0  # seconds
_MOST: Final = 10_000


@final
class ResponseTimes:
    """The last response times of each target: at most 16 each, of at most 10,000; the longest unused are forgotten.

    Args:
        first: Seconds to wait for a target of which too few are known.

    Attributes:
        silent: The targets that answered none of several sendings in time, the last time; for reading.
    """

    def __init__(self, first: float) -> None:
        self._first = first
        self._known: OrderedDict[tuple[str, str], deque[float]] = OrderedDict()
        self.silent: OrderedDict[str, None] = OrderedDict()

    def note_silence(self, target: str, *, is_silent: bool) -> None:
        """Note whether *target* answered none of several sendings in time, which may be why."""
        if is_silent:
            self.silent[target] = None
            if len(self.silent) > _MOST:
                self.silent.popitem(last=False)
        elif self.silent:
            self.silent.pop(target, None)

    def note(self, target: str, capability: str, seconds: float, *, sendings: int = 1, is_change: bool = True) -> None:
        """Note how long an answer took, in seconds from the first of so many *sendings*.

        After several it is not known to which it is the answer; it counts as no longer than the first limit, or each
        answer to a repetition would make the next ones later. One that is no change, as it says what was known before,
        may have come by chance, as a deaf device tells now and then how it is; so it never makes the wait longer.
        """
        if not is_change and _FACTOR * seconds + _SPARE > self.expected(target, (capability,))[0]:
            return
        if sendings > 1:
            seconds = min(seconds, self._first)
        times = self._known.get((target, capability))
        if times is not None:
            self._known.move_to_end((target, capability))
        else:
            times = self._known[target, capability] = deque(maxlen=_KEPT)
            if len(self._known) > _MOST:
                self._known.popitem(last=False)
        times.append(seconds)

    def expected(self, target: str, capabilities: Iterable[str]) -> tuple[float, float]:
        """Return for how many seconds to wait for the answer of *target*, and the longest that is known.

        The wait is three times the longest and one second more, 2 s to 120 s. The longest counts as a second at least
        where too few are known.
        """
        longest, is_known = 0.0, True
        for capability in capabilities:
            times = self._known.get((target, capability), ())
            longest = max((longest, *times))
            is_known = is_known and len(times) >= _ENOUGH
        limit = _FACTOR * longest + _SPARE
        if not is_known:
            limit, longest = max(limit, self._first), max(longest, _UNKNOWN)
        return min(max(limit, _SHORTEST), _LONGEST), longest
