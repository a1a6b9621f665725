"""Decision when an identification is sure. Pure."""

from typing import Final, final

from homebot.identify.belief import Belief

_LEAST: Final = 4
"""Looks before a conclusion, and one more for each doubling of the candidates: in fewer, a lamp of somebody else may
look like a candidate."""

_IN_A_ROW: Final = 2
_SURER: Final = 0.1
"""The share of the doubt with which one look is enough for a candidate."""


@final
class Conclusion:
    """The hypothesis that is sure enough, two times in a row; for a candidate that is far surer, once.

    Args:
        sure: The probability that it needs.

    Attributes:
        found: The number of the candidate; None for none of them, and before it is sure.
    """

    def __init__(self, sure: float) -> None:
        self.found: int | None = None
        self._sure = sure
        self._looks = 1  # the one with which a belief begins
        self._row = 0

    def add(self, belief: Belief, trouble: str = "") -> bool:
        """Return whether it is sure after one more look; never with *trouble* of the sensor."""
        each = belief.each
        best = max(range(belief.count), key=each.__getitem__)
        probability, found = max((belief.none, None), (each[best], best), key=lambda one: one[0])
        self._looks += 1
        if found is not None and not belief.stands_out(found):
            probability = 0.0
        if trouble or not belief.follows:
            probability, found = 0.0, None
        self._row = (self._row if found == self.found else 0) + 1 if probability >= self._sure else 0
        self.found = found
        is_surer = found is not None and 1 - probability <= _SURER * (1 - self._sure)
        return (is_surer or self._row >= _IN_A_ROW) and self._looks >= _LEAST + belief.count.bit_length() - 1
