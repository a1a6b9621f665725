"""Choice of the next code of the candidates, and of the conclusion from all looks. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise, starmap, takewhile
from math import inf, log2, sqrt
from operator import itemgetter
from random import Random
from statistics import median
from typing import Final, TypeAlias, final

from homebot.features.identify.belief import Belief, Seen

Code: TypeAlias = "tuple[bool, ...] | None"
"""Whether each candidate is bright; None to look again."""

STILL_LOOKS: Final = 2
"""Looks before anything changes, of a sensor that does not report changes alone."""

_LOOKS: Final = 8
"""Looks before a conclusion, and a further look for a doubling of the candidates: a light that changes by itself,
such as another person's lamp, is as expected in half of all looks, and fits by chance in one of 2 to their number."""

_LOOKS_OF_A_JUMP: Final = 5
"""Further looks for a jump of the light: the one in which it jumps, and one for each doubling of those it may be."""

_DEVIATIONS: Final = 3.0
_SHARE: Final = 0.05
"""The least effect in view, if it is unknown: so many deviations of a look, and at least this share of what is seen."""

_MAX_SHARE: Final = 0.1
"""The least effect, as such a share, that excludes nothing: what is seen varies too much by itself."""

_IN_A_ROW: Final = 2
_SURER: Final = 0.1
"""The share of the doubt with which a single look is enough for a candidate."""

_LIKELY: Final = 0.9
"""The probability from which a candidate is told apart from others that may be the same device."""

_MAX_RIVALS: Final = 3
_MAX_REPEATS: Final = 2
"""Further looks at the same code, but at a fade: they tell little of slow changes from elsewhere."""

_TRIED: Final = 60
"""Codes of which the next is chosen."""

_TINY: Final = 1e-6


@final
class Inquiry:
    """One identification: first what is seen before anything changes is added, and then with each of :meth:`codes`.

    Args:
        count: Of the candidates.
        least: The least effect of a candidate in view; 0 for what can be told from noise.
        sure: The probability that is enough.

    Attributes:
        belief: None until all have been bright.
        found: The candidate that is likeliest; None for none of them.
        is_sure: Whether that is sure.
        follows: Whether the candidates explain what is seen, but for a cloud now and then.
    """

    def __init__(self, count: int, least: float, sure: float, random: Random) -> None:
        self._count, self._least, self._sure, self._random = count, least, sure, random
        self._looks: list[Seen] = []
        self._row = 0
        self._least_in_view = least
        self._cost = 2.0  # seconds of a change and a look; a look alone takes one
        self._waits = self._is_prompt = False
        self._dropped: set[int] = set()
        self.belief: Belief | None = None
        self.found: int | None = None
        self.is_sure = False
        self.follows = True

    def codes(self) -> Iterator[Code]:
        """Yield what the candidates do next, until it is sure."""
        still = len(self._looks)
        yield (False,) * self._count
        yield (True,) * self._count
        self._is_prompt = still == STILL_LOOKS
        if self._is_prompt:  # they may fade on after their reports
            yield None
        dark, *_, bright = blinked = self._looks[still:]
        whole = max(median(abs(seen.value) for seen in blinked), _TINY)
        noise = _DEVIATIONS * sqrt(min(seen.variance for seen in blinked))
        least = self._least_in_view = self._least or max(noise, _SHARE * whole)
        self._excluded = least if self._least or noise <= _MAX_SHARE * whole else 0.0
        belief = Belief(self._looks[0], least, max(2 * abs(bright.value - dark.value), least))
        for seen in self._looks[1:]:
            belief.add(seen)
        self.belief = belief
        while not self.is_sure:
            yield self._next_code(self.belief)

    @property
    def rivals(self) -> list[int]:
        """The two or three candidates of which one is in view, but which are not told apart; else empty."""
        if self.belief is None or self.found is None:
            return []
        probabilities, others = self.belief.each, self.belief.alike(self.found) | self.belief.tied(self.found)
        if probabilities[self.found] < _LIKELY:
            others = {other for other in others if probabilities[other] > 1 - _LIKELY}
        rivals = sorted({self.found, *others})
        return (
            rivals
            if 1 < len(rivals) <= _MAX_RIVALS and sum(probabilities[rival] for rival in rivals) >= _LIKELY
            else []
        )

    @property
    def fades_on(self) -> float:
        """Seconds for which candidates fade on after they have settled by their reports."""
        return self.belief.fade if self.belief is not None and self.belief.fades else 0.0

    def drop(self, candidate: int) -> None:
        """Rule a candidate out, as it does not change any more."""
        self._dropped.add(candidate)

    def add(self, seen: Seen, trouble: str = "") -> None:
        """Learn from what is seen with the last code; nothing is concluded while the sensor has *trouble*."""
        self._looks.append(seen)
        if self.belief is not None:
            for candidate in self._dropped:
                self.belief.drop(candidate)
            self.belief.add(seen)
            self._conclude(self.belief, trouble)

    def _conclude(self, belief: Belief, trouble: str) -> None:
        hypotheses = (belief.none, None), *((chance, number) for number, chance in enumerate(belief.each))
        probability, candidate = max(hypotheses, key=itemgetter(0))
        jumps = max(len(belief.jumps), sum(starmap(self._has_jumped, pairwise(self._looks))))
        due = _LOOKS + log2(self._count) + _LOOKS_OF_A_JUMP * jumps
        if candidate is None:
            is_clear = belief.largest() <= self._excluded
        else:
            is_in_view = belief.least(candidate) >= self._least_in_view
            is_clear = is_in_view and not belief.alike(candidate) and not belief.tied(candidate)
        is_likely = probability >= self._sure and is_clear and not trouble
        self._row = (self._row if candidate == self.found else 0) + 1 if is_likely else 0
        self.found = candidate
        is_surer = candidate is not None and self._row and 1 - probability <= _SURER * (1 - self._sure)
        self._waits = bool(is_surer or self._row >= _IN_A_ROW)
        self.is_sure = self._waits and len(self._looks) > due
        self.follows = len(self._looks) > _LOOKS_OF_A_JUMP * jumps

    def _has_jumped(self, before: Seen, after: Seen) -> bool:
        """Return whether the value changed as much as by a candidate, while none of them changed."""
        if before.levels != after.levels or self._may_fade(after):
            return False
        least = max(self._least_in_view, _DEVIATIONS * sqrt(before.variance + after.variance))
        return abs(after.value - before.value) > least

    def _may_fade(self, seen: Seen) -> bool:
        return self.belief is not None and min(seen.ages, default=inf) < self.belief.fade

    def _next_code(self, belief: Belief) -> Code:
        """Return the code of some that are drawn by which most is learnt, or one that tells devices apart.

        None where the same tells more in the time: of a possible fade, of changes from elsewhere, or of noise.
        """
        *_, before, latest = self._looks
        if self._is_prompt and self._may_fade(latest) and not belief.fades:
            return None
        can_repeat = self._is_prompt and self._count_repeats() < _MAX_REPEATS
        if self._waits and can_repeat:
            return None
        best = max(range(self._count), key=belief.each.__getitem__)
        is_turn = len(self._looks) % 5 > 0  # what is tied may be untied by other codes
        if is_turn and belief.each[best] >= _LIKELY and (others := belief.tied(best) - self._dropped):
            return tuple((level > 0.5) != (number in others) for number, level in enumerate(latest.levels))
        rivals = [best, *belief.alike(best)] if belief.each[best] >= _LIKELY else []
        gain, code = self._draw_code(belief, rivals)
        if latest.levels != before.levels:
            self._cost = latest.seconds
        is_worth = can_repeat and belief.gain(latest.levels, rivals) * self._cost > gain
        return None if is_worth else code

    def _count_repeats(self) -> int:
        """Return how often the last look was repeated with the same levels."""
        levels = self._looks[-1].levels
        return sum(1 for _ in takewhile(lambda seen: seen.levels == levels, reversed(self._looks))) - 1

    def _draw_code(self, belief: Belief, rivals: Sequence[int]) -> tuple[float, tuple[bool, ...]]:
        """Return the drawn code by which most is learnt about *rivals*, with that gain."""
        drawn = ([self._random.random() < 0.5 for _ in range(self._count)] for _ in range(_TRIED))
        gain, code = max((belief.gain([*map(float, code)], rivals), code) for code in drawn)
        return gain, tuple(code)
