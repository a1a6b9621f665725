"""Probability of each candidate to be the one in view, from a sensor that looks while all of them change. Pure.

What is seen is taken as ``base + sum(level * effect) + noise``. The base drifts, and a cloud or a lamp of somebody else
makes it jump; the effects are those of reflections, except that one candidate at most stands out, as it is in view. A
lamp that shines late looks like a weaker one, and like no other.

Because neither the effect of what is in view nor the strength of the reflections is known, several *families* of both
are followed beside each other, each by a Gaussian-sum filter: a few alternatives with and without jumps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import erf, exp, inf, log, pi, sqrt
from operator import mul
from typing import Final, final

_IN_VIEW: Final = (0.45, 1.3)
"""The effects of what is in view, as shares of the family's."""

_REFLECTIONS: Final = (0.2, 0.5)
"""The strongest reflections of the families, as such a share; their mean is half of it, with this deviation:"""
_SCATTER: Final = 0.35

_DRIFT: Final = 0.045
"""Deviation of the base in a second, and of the jumps, as shares of the family's effect; and how often it jumps."""
_JUMP: Final = 1.0
_JUMPS: Final = 0.02

_INEXACT: Final = 0.1
"""What the sensor's own error is at least, as such a share."""

_CLEARLY: Final = 1.1, 3.0
"""How many times the effect of any other candidate that of the one in view is, by how many standard deviations."""

_FADES: Final = {0.0: 0.94, 2.5: 0.03, 5.0: 0.03}
"""Seconds for which candidates fade after their reports, and how likely that is before anything is seen."""

_POSSIBLE: Final = 0.02
"""The probability of a fade from which it is waited for."""

_UNLIKELY: Final = 12.0
"""Logarithm of how much less likely than the others a family is that is given up."""

_CERTAINTY: Final = 3.0
"""Standard deviations by which effects are smaller than what is excluded, and larger than the least in view."""

_TINY: Final = 1e-9
_LEAST: Final = 1e-300
_ROOT_2: Final = sqrt(2)
_ALTERNATIVES: Final = 5
_MAX_FAMILIES: Final = 8


@dataclass(frozen=True, slots=True)
class Seen:
    """Mean of the sensor while the candidates keep still.

    Attributes:
        levels: Of each candidate, from 0.0 (off) to 1.0.
        value: The mean, in the unit of the sensor.
        variance: That of the mean.
        seconds: Since the middle of the last time.
        ages: Of each candidate, the seconds since it reported its last change; empty if all have long settled.
    """

    levels: tuple[float, ...]
    value: float
    variance: float
    seconds: float
    ages: tuple[float, ...] = ()

    def faded(self, fade: float, before: Seen, shown: Seen) -> Seen:
        """Return this with the levels of candidates that go on to fade for so many seconds.

        Args:
            before: What was seen last, by the levels that were reported.
            shown: The same, by those that were reached.
        """
        if not fade or not self.ages:
            return self
        levels = []
        for old, new, level, age in zip(before.levels, self.levels, shown.levels, self.ages, strict=True):
            reached = _nearer(level, old, (self.seconds - age) / fade) if age < self.seconds else level
            levels.append(_nearer(reached, new, min(age, self.seconds) / fade))
        return replace(self, levels=tuple(levels))


@final
class Belief:
    """Probabilities and effects after each :class:`Seen`.

    Args:
        first: What was seen first.
        least: The least effect of a candidate in view, in the unit of the sensor; above 0.
        most: The largest effect that is possible.
    """

    def __init__(self, first: Seen, least: float, most: float) -> None:
        self.count = len(first.levels)
        self._dropped: set[int] = set()
        self._looks = {fade: [first] for fade in _FADES}
        effect, effects = least / _IN_VIEW[0], list[float]()
        while not effects or (effect < 2 * most and len(effects) < _MAX_FAMILIES):
            effects.append(effect)
            effect *= 2
        self._families = [
            _Family(first, effect, share * effect, least, fade)
            for effect in effects
            for share in _REFLECTIONS
            for fade in _FADES
        ]
        self._weigh()

    def add(self, seen: Seen) -> None:
        """Learn from what was seen next."""
        before = self._looks[0.0][-1]
        for fade, looks in self._looks.items():
            looks.append(seen.faded(fade, before, looks[-1]))
        for family in self._families:
            family.add(self._looks[family.fade][-1])
        self._weigh()

    @property
    def jumps(self) -> tuple[int, ...]:
        """The looks before which what is seen jumped by itself, at the likeliest."""
        return self._best.tracks[0].jumps

    @property
    def fade(self) -> float:
        """Seconds for which candidates may fade after their reports."""
        return max(fade for fade, share in self._fades.items() if share > _POSSIBLE)

    @property
    def fades(self) -> bool:
        """True if they surely do."""
        return self._fades[0.0] <= _POSSIBLE

    def drop(self, candidate: int) -> None:
        """Rule a candidate out, as it does not change any more."""
        self._dropped.add(candidate)

    def effect(self, candidate: int) -> tuple[float, float]:
        """Return by how much a candidate changes what is seen, and the standard deviation."""
        return self._families[-1].effect(candidate)  # that which supposes least

    def alike(self, candidate: int) -> set[int]:
        """Return the others in view as clearly, for all that is known: two in view are never told apart."""
        others = {*range(self.count)} - {candidate, *self._dropped}
        return {other for other in others if not self._best.exceeds(candidate, other)}

    def tied(self, candidate: int) -> set[int]:
        """Return the others that may be the same device, announced twice: it does what either was told last.

        It is not the same if little changed as the other went away, while the candidate stayed.
        """
        effects, own, inexact = self._best.tracks[0].mean, self._best.effect_in_view(candidate), self._best.inexact
        sums, weights, away = [0.0] * self.count, [0.0] * self.count, set[int]()  # those that went away last
        shown = pairwise(self._looks[self._best.fade])
        pairs = enumerate(zip(pairwise(self._looks[0.0]), shown, strict=True), start=1)
        for look, ((before, after), (old, new)) in pairs:
            if before.levels[candidate] != (level := after.levels[candidate]) or look in self.jumps:
                away.clear()
                continue
            moves = [end - start for start, end in zip(old.levels, new.levels, strict=True)]
            change = after.value - before.value - sum(map(mul, moves, effects))
            variance = max(before.variance, inexact) + max(after.variance, inexact)
            for other, (start, end) in enumerate(zip(before.levels, after.levels, strict=True)):
                if end != level and other in self._dropped:
                    weights[other] = inf
                elif end != level or other in away:
                    sums[other] += moves[other] * (change + moves[other] * effects[other]) / variance
                    weights[other] += moves[other] ** 2 / variance
                if start != end:
                    (away.discard if end == level else away.add)(other)
        return {
            other
            for other, (whole, weight) in enumerate(zip(sums, weights, strict=True))
            if other != candidate and weight < inf and own * weight - whole <= _CLEARLY[1] * sqrt(weight)
        }

    def largest(self) -> float:
        """Return the effect that is excluded for each candidate."""
        left = {*range(self.count)} - self._dropped
        return max((self._best.effect_in_view(number, _CERTAINTY) for number in left), default=0.0)

    def least(self, candidate: int) -> float:
        """Return the effect that a candidate has at least."""
        return self._best.effect_in_view(candidate, -_CERTAINTY)

    def gain(self, levels: Sequence[float], rivals: Sequence[int] = ()) -> float:
        """Return how much is learnt about the likely candidates from what is seen with these levels.

        Args:
            rivals: The likeliest candidate, and those that are alike.
        """
        track = self._best.tracks[0]
        row = _times(track.covariance, (*levels, 1.0))
        variance = (
            sum(level * covariance for level, covariance in zip((*levels, 1.0), row, strict=True)) + self._best.usual
        )
        shares = [(float(p**0.3), covariance) for p, covariance in zip(self.each, row, strict=False)]
        shares += [(1.0, row[rivals[0]] - _CLEARLY[0] * row[other]) for other in rivals[1:]]
        return sum(share * covariance * covariance for share, covariance in shares) / variance

    def _weigh(self) -> None:
        """Compute the probability of none and of each candidate."""
        by_family = [[*family.hypotheses()] for family in self._families]
        sums = [_log_sum(weights) for weights in by_family]
        self._best = self._families[sums.index(max(sums))]
        whole = _log_sum(sums)
        self._fades = dict.fromkeys(_FADES, 0.0)
        for family, weight in zip(self._families, sums, strict=True):
            self._fades[family.fade] += exp(weight - whole)
        self._families = [
            family for family, weight in zip(self._families, sums, strict=True) if weight > max(sums) - _UNLIKELY
        ]
        self.none, *rest = (exp(_log_sum(column) - whole) for column in zip(*by_family, strict=True))
        each_left = [0.0 if number in self._dropped else probability for number, probability in enumerate(rest)]
        total = self.none + sum(each_left)
        self.none, self.each = self.none / total, tuple(probability / total for probability in each_left)


@dataclass(slots=True)
class _Track:
    """One alternative: when the base has jumped, the effects and the base that follow.

    Attributes:
        weight: The logarithm of its likelihood if no candidate is in view.
        mean: The effects, and then the base.
        hypotheses: The logarithms of the likelihood of none and of each candidate.
        jumps: The looks before which the base has jumped.
    """

    weight: float
    mean: list[float]
    covariance: list[list[float]]
    hypotheses: list[float] = field(default_factory=list)
    jumps: tuple[int, ...] = ()


@dataclass(slots=True)
class _FilterStep:
    """A track after a look, with the covariance of before: most steps are not taken.

    Attributes:
        gains: The covariances of what was seen with the effects and the base.
        variance: That of what was seen.
        moved: The variance by which the base moved before.
    """

    track: _Track
    gains: list[float]
    variance: float
    moved: float

    def variances(self) -> list[float]:
        """Return the variances of the effects after it."""
        rows = zip(self.track.covariance, self.gains[:-1], strict=False)
        return [row[place] - gain * gain / self.variance for place, (row, gain) in enumerate(rows)]

    def taken(self) -> _Track:
        """Return the track with the covariance after it."""
        self.track.covariance = [
            [covariance - gain * other / self.variance for covariance, other in zip(row, self.gains, strict=True)]
            for row, gain in zip(self.track.covariance, self.gains, strict=True)
        ]
        self.track.covariance[-1][-1] += self.moved
        return self.track


class _Family:
    """One effect of what is in view with one strength of the reflections."""

    def __init__(self, first: Seen, effect: float, strongest: float, least: float, fade: float) -> None:
        self._effect, self.fade = effect, fade
        self.inexact = (_INEXACT * effect) ** 2
        self._mean = strongest / 2
        self._variance = (_SCATTER * strongest) ** 2
        self._limits = [
            (limit, _log_below((limit - self._mean) / sqrt(self._variance))) for limit in (least, _IN_VIEW[0] * effect)
        ]
        self._most = _IN_VIEW[1] * effect
        self.usual, self._last = first.variance, first.value
        self._looks, count = 0, len(first.levels)
        covariance = [[0.0] * count + [-level * self._variance] for level in first.levels]
        for place, row in enumerate(covariance):
            row[place] = self._variance
        base = first.value - self._mean * sum(first.levels)
        spread = self._variance * sum(level * level for level in first.levels) + first.variance
        covariance.append([row[-1] for row in covariance] + [spread])
        track = _Track(log(_FADES[fade]), [self._mean] * count + [base], covariance)
        self._weigh(track, [self._variance] * count)
        self.tracks = [track]

    def add(self, seen: Seen) -> None:
        self._looks += 1
        self.usual = max(seen.variance, self.inexact)
        drift = (_DRIFT * self._effect) ** 2 * seen.seconds
        jump = drift + max(_JUMP * self._effect, abs(seen.value - self._last)) ** 2
        self._last = seen.value
        alternatives = ((drift, log(1 - _JUMPS), ()), (jump, log(_JUMPS), (self._looks,)))
        steps = [step for track in self.tracks for step in _follow(track, seen, self.usual, alternatives)]
        for step in steps:
            self._weigh(step.track, step.variances())
        steps.sort(key=lambda step: _log_sum(step.track.hypotheses), reverse=True)
        self.tracks = [step.taken() for step in steps[:_ALTERNATIVES]]

    def effect(self, candidate: int) -> tuple[float, float]:
        """Return an effect and its deviation in the likeliest alternative."""
        track = self.tracks[0]
        return track.mean[candidate], sqrt(max(track.covariance[candidate][candidate], 0.0))

    def effect_in_view(self, candidate: int, deviations: float = 0.0) -> float:
        """Return an effect, and so many standard deviations, without what is supposed of reflections."""
        track = self.tracks[0]
        own = track.covariance[candidate][candidate]
        learnt = max(self._variance - own, _TINY * own)
        effect = track.mean[candidate] + own * (track.mean[candidate] - self._mean) / learnt
        return effect + deviations * sqrt(max(own * self._variance / learnt, 0.0))

    def exceeds(self, candidate: int, other: int) -> bool:
        """Return whether an effect is clearly larger than another, without what is supposed of reflections."""
        track, (more, deviations) = self.tracks[0], _CLEARLY
        one, both, two = (track.covariance[a][b] for a, b in ((candidate,) * 2, (candidate, other), (other,) * 2))
        whole = max(one * two - both * both, _TINY * one * two)
        a, b, c = two / whole - 1 / self._variance, -both / whole, one / whole - 1 / self._variance
        if min(a, c) <= 0 or (rest := a * c - b * b) <= 0:
            return False
        x = (two * track.mean[candidate] - both * track.mean[other]) / whole - self._mean / self._variance
        y = (one * track.mean[other] - both * track.mean[candidate]) / whole - self._mean / self._variance
        difference = (c * x - b * y) - more * (a * y - b * x)
        return difference > deviations * sqrt(rest * (c + 2 * more * b + more**2 * a))

    def hypotheses(self) -> Iterator[float]:
        """Yield the logarithm of the likelihood of none and of each candidate."""
        none, *columns = zip(*(track.hypotheses for track in self.tracks), strict=True)
        yield _log_sum(none)
        yield from map(_log_sum, columns)

    def _weigh(self, track: _Track, variances: Iterable[float]) -> None:
        """Compute the hypotheses of a track from the *variances* of its effects.

        An identification spends its time here: it calls nothing that can be written out.
        """
        (least, supposed), (limit, supposed_below) = self._limits
        usual, whole_mean, most = self._variance, self._mean, self._most
        precision, weighted = 1 / usual, whole_mean / usual
        none, below, ratios = list[float](), list[float](), list[float]()
        for mean, variance in zip(track.mean, variances, strict=False):
            spread = sqrt(variance)
            none.append(log(0.5 * (1 + erf((least - mean) / spread / _ROOT_2)) or _LEAST) - supposed)
            below.append(log(0.5 * (1 + erf((limit - mean) / spread / _ROOT_2)) or _LEAST) - supposed_below)
            learnt = 1 / max(variance, 1e-12 * usual) - precision
            if learnt * usual < 1e-6:
                ratios.append(0.0)
                continue
            seen = (mean / variance - weighted) / learnt  # without what was assumed before
            spread = sqrt(1 / learnt)
            in_view = (
                0.5 * (1 + erf((most - seen) / spread / _ROOT_2)) - 0.5 * (1 + erf((limit - seen) / spread / _ROOT_2))
            ) / (most - limit)
            whole = usual + spread**2
            reflected = exp(-((seen - whole_mean) ** 2) / (2 * whole)) / sqrt(2 * pi * whole)
            ratios.append(log(max(in_view, _LEAST)) - log(max(reflected, _LEAST)))
        all_reflected = track.weight + sum(below)
        weights = [all_reflected - one + ratio for one, ratio in zip(below, ratios, strict=True)]
        track.hypotheses = [track.weight + sum(none), *weights]


def _nearer(level: float, wanted: float, step: float) -> float:
    return level + max(-step, min(step, wanted - level))


def _follow(
    track: _Track, seen: Seen, noise: float, alternatives: Iterable[tuple[float, float, tuple[int, ...]]]
) -> Iterator[_FilterStep]:
    """Yield the step of a Kalman filter by *seen* for each alternative of the base since.

    Args:
        alternatives: The variance of the base, the logarithm of its likelihood, and the looks before which it jumped.
    """
    weights = (*seen.levels, 1.0)
    *lamps, base = _times(track.covariance, weights)
    error = seen.value - sum(map(mul, weights, track.mean))
    for moved, chance, jumps in alternatives:
        gains = [*lamps, base + moved]
        variance = sum(map(mul, weights, gains)) + noise
        mean = [estimate + gain * error / variance for estimate, gain in zip(track.mean, gains, strict=True)]
        weight = track.weight + chance + log(max(_density(error, 0.0, variance), _LEAST))
        yield _FilterStep(_Track(weight, mean, track.covariance, jumps=(*track.jumps, *jumps)), gains, variance, moved)


def _times(matrix: list[list[float]], weights: Sequence[float]) -> list[float]:
    return [sum(map(mul, row, weights)) for row in matrix]


def _log_below(deviations: float) -> float:
    """Return the logarithm of the share of a normal distribution below so many deviations."""
    return log(0.5 * (1 + erf(deviations / _ROOT_2)) or _LEAST)


def _density(value: float, mean: float, variance: float) -> float:
    return exp(-((value - mean) ** 2) / (2 * variance)) / sqrt(2 * pi * variance)


def _log_sum(values: Sequence[float]) -> float:
    most = max(values)
    return most + log(sum([exp(value - most) for value in values]))
