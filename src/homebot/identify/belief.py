"""Probability of each candidate to be the one in view, from a sensor that looks while all of them change. Pure.

What is seen is taken as ``base + sum(level * effect) + noise``. The base drifts, and a cloud or a lamp of somebody else
makes it jump; the effects are those of reflections, except that one candidate at most stands out, as it is in view. A
lamp that shines late looks like a weaker one, and like no other.

Because neither the effect of what is in view nor the strength of the reflections is known, several *families* of both
are followed beside each other, each by a Gaussian-sum filter: a few alternatives with and without jumps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import erf, exp, inf, log, pi, sqrt
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

_INEXACT: Final = 0.03
"""What the sensor's own error is at least, as such a share."""

_SHARE: Final = 0.05
"""The least effect of a candidate in view, as a share of what is seen, if it is unknown."""

_LOOKS_OF_A_JUMP: Final = 12
"""Looks for each jump of the base: if it jumps more often, what is seen does not follow the candidates."""

_CLEARLY: Final = ((1.0, 3.0), (1.2, 1.0))
"""How many times the effect of any other candidate that of the one in view is, by how many standard deviations."""

_EXCLUDED: Final = 3.0
"""Standard deviations by which the effects are smaller than what is excluded."""

_TINY: Final = 1e-6
_ALTERNATIVES: Final = 5
_MOST_FAMILIES: Final = 8


@dataclass(frozen=True, slots=True)
class Seen:
    """Mean of the sensor while the candidates keep still.

    Attributes:
        levels: Of each candidate, from 0.0 (off) to 1.0.
        value: The mean, in the unit of the sensor.
        variance: That of the mean.
        seconds: Since the middle of the last time.
    """

    levels: tuple[float, ...]
    value: float
    variance: float
    seconds: float


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
        self._levels = [first.levels]
        effect, effects = least / _IN_VIEW[0], list[float]()
        while not effects or (effect < 2 * most and len(effects) < _MOST_FAMILIES):
            effects.append(effect)
            effect *= 2
        self._families = [
            _Family(first, one, share * one, may_be_none=one == effects[0]) for one in effects for share in _REFLECTIONS
        ]
        self._weigh()

    def add(self, seen: Seen) -> None:
        """Learn from what was seen next."""
        self._levels.append(seen.levels)
        for one in self._families:
            one.add(seen)
        self._weigh()

    @property
    def follows(self) -> bool:
        """True if the candidates explain what is seen, but for a cloud now and then."""
        return self._best.tracks[0].jumps * _LOOKS_OF_A_JUMP <= len(self._levels)

    def drop(self, candidate: int) -> None:
        """Rule a candidate out, as it does not change any more."""
        self._dropped.add(candidate)

    def effect(self, candidate: int) -> tuple[float, float]:
        """Return by how much a candidate changes what is seen, and the standard deviation."""
        return self._families[-1].effect(candidate)  # that which supposes least

    def stands_out(self, candidate: int) -> bool:
        """Return whether a candidate clearly has more effect than each other one: two in view are never told apart."""
        columns = [*zip(*self._levels, strict=True)]
        return columns.count(columns[candidate]) == 1 and all(  # one relay may be announced twice
            self._best.exceeds(candidate, other, more, deviations)
            for other in {*range(self.count)} - {candidate, *self._dropped}
            for more, deviations in _CLEARLY
        )

    def largest(self) -> float:
        """Return the effect that is excluded for each candidate."""
        effects = map(self.effect, {*range(self.count)} - self._dropped)
        return max((effect + _EXCLUDED * deviation for effect, deviation in effects), default=0.0)

    def gain(self, levels: Sequence[float]) -> float:
        """Return how much is learnt about the likely candidates from what is seen with these levels."""
        track = self._best.tracks[0]
        row = _times(track.covariance, (*levels, 1.0))
        variance = sum(level * one for level, one in zip((*levels, 1.0), row, strict=True)) + self._best.usual
        return sum(float(p**0.3) * one * one for p, one in zip(self.each, row, strict=False)) / variance

    def _weigh(self) -> None:
        """Compute the probability of none and of each candidate."""
        each = [[*family.hypotheses()] for family in self._families]
        sums = [_log_sum(one) for one in each]
        self._best = self._families[sums.index(max(sums))]
        whole = _log_sum(sums)
        self.none, *rest = (exp(_log_sum(column) - whole) for column in zip(*each, strict=True))
        each_left = [0.0 if number in self._dropped else one for number, one in enumerate(rest)]
        total = self.none + sum(each_left)
        self.none, self.each = self.none / total, tuple(one / total for one in each_left)


def begun(dark: Seen, bright: Seen, least: float = 0.0) -> Belief:
    """Return what is known after a look with all candidates dark, and one with all bright.

    Args:
        least: The least effect of a candidate in view; 0 for a share of what is seen.
    """
    least = least or _SHARE * max(abs(dark.value), abs(bright.value), _TINY)
    belief = Belief(dark, least, max(2 * abs(bright.value - dark.value), least))
    belief.add(bright)
    return belief


def is_brightening(looks: Sequence[Seen]) -> bool:
    """Return whether what is seen may change further, while all candidates are told to be bright."""
    return len(looks) == 1 or _differ(looks[-2], looks[-1], 1.0)


def is_brighter(looks: Sequence[Seen]) -> bool:
    """Return whether it changed between the first and the last look: lamps faded on."""
    return _differ(looks[0], looks[-1], 2.0)


def _differ(one: Seen, other: Seen, deviations: float) -> bool:
    return abs(one.value - other.value) > deviations * sqrt(one.variance + other.variance)


@dataclass(slots=True)
class _Track:
    """One alternative: when the base has jumped, the effects and the base that follow.

    Attributes:
        weight: The logarithm of its likelihood if no candidate is in view.
        mean: The effects, and then the base.
        jumps: How often the base has jumped.
    """

    weight: float
    mean: list[float]
    covariance: list[list[float]]
    hypotheses: list[float]
    jumps: int = 0


class _Family:
    """One effect of what is in view with one strength of the reflections."""

    def __init__(self, first: Seen, effect: float, strongest: float, *, may_be_none: bool) -> None:
        self._may_be_none = may_be_none  # in the others, what is none has more than the least effect
        self._effect = effect
        self._mean = strongest / 2
        self._variance = (_SCATTER * strongest) ** 2
        self.usual, self._last = first.variance, first.value
        count = len(first.levels)
        covariance = [[0.0] * count + [-level * self._variance] for level in first.levels]
        for place, row in enumerate(covariance):
            row[place] = self._variance
        base = first.value - self._mean * sum(first.levels)
        spread = self._variance * sum(one * one for one in first.levels) + first.variance
        covariance.append([row[-1] for row in covariance] + [spread])
        track = _Track(0.0, [self._mean] * count + [base], covariance, [])
        self.tracks = [self._weighed(track)]

    def add(self, seen: Seen) -> None:
        self.usual = max(seen.variance, (_INEXACT * self._effect) ** 2)
        drift = (_DRIFT * self._effect) ** 2 * seen.seconds
        jump = drift + max(_JUMP * self._effect, abs(seen.value - self._last)) ** 2
        self._last = seen.value
        tracks = [
            self._weighed(_followed(track, seen, self.usual, moved, log(chance), track.jumps + jumps))
            for track in self.tracks
            for jumps, moved, chance in ((0, drift, 1 - _JUMPS), (1, jump, _JUMPS))
        ]
        tracks.sort(key=lambda one: _log_sum(one.hypotheses), reverse=True)
        self.tracks = tracks[:_ALTERNATIVES]

    def effect(self, candidate: int) -> tuple[float, float]:
        """Return an effect and its deviation in the likeliest alternative."""
        track = self.tracks[0]
        return track.mean[candidate], sqrt(max(track.covariance[candidate][candidate], 0.0))

    def exceeds(self, candidate: int, other: int, more: float, deviations: float) -> bool:
        """Return whether an effect is larger than *more* times another one, by so many standard deviations."""
        track = self.tracks[0]
        own, row = track.covariance[candidate], track.covariance[other]
        spread = own[candidate] - 2 * more * own[other] + more**2 * row[other]
        return track.mean[candidate] - more * track.mean[other] > deviations * sqrt(max(spread, 0.0))

    def hypotheses(self) -> Iterator[float]:
        """Yield the logarithm of the likelihood of none and of each candidate."""
        none, *each = zip(*(one.hypotheses for one in self.tracks), strict=True)
        yield _log_sum(none) if self._may_be_none else -inf
        yield from map(_log_sum, each)

    def _weighed(self, track: _Track) -> _Track:
        places = range(len(track.mean) - 1)
        limits = [self._limit(track.mean[one], track.covariance[one][one]) for one in places]
        none = track.weight + sum(limits)
        ratios = (self._ratio(track.mean[one], track.covariance[one][one]) for one in places)
        track.hypotheses = [none, *(none - limit + one for limit, one in zip(limits, ratios, strict=True))]
        return track

    def _limit(self, mean: float, variance: float) -> float:
        """Return the logarithm of how much likelier a reflection is below the effects in view than before."""
        least = _IN_VIEW[0] * self._effect
        shares = (
            _below((least - one) / sqrt(spread)) for one, spread in ((mean, variance), (self._mean, self._variance))
        )
        now, before = (log(max(share, 1e-300)) for share in shares)
        return now - before

    def _ratio(self, mean: float, variance: float) -> float:
        """Return the logarithm of how much likelier the candidate is in view than a reflection.

        Args:
            mean: Of its effect, if it is a reflection.
        """
        least, most = (share * self._effect for share in _IN_VIEW)
        learnt = 1 / max(variance, 1e-12 * self._variance) - 1 / self._variance
        if learnt * self._variance < 1e-6:
            return 0.0
        seen = (mean / variance - self._mean / self._variance) / learnt  # without what was assumed before
        spread = sqrt(1 / learnt)
        in_view = (_below((most - seen) / spread) - _below((least - seen) / spread)) / (most - least)
        reflected = _density(seen, self._mean, self._variance + spread**2)
        return log(max(in_view, 1e-300)) - log(max(reflected, 1e-300))


def _followed(track: _Track, seen: Seen, noise: float, moved: float, chance: float, jumps: int) -> _Track:
    """Return the track after *seen*, by a step of a Kalman filter; *moved* is the variance of the base since."""
    weights = (*seen.levels, 1.0)
    gains = _times(track.covariance, weights)
    gains[-1] += moved
    variance = sum(weight * gain for weight, gain in zip(weights, gains, strict=True)) + noise
    error = seen.value - sum(weight * one for weight, one in zip(weights, track.mean, strict=True))
    mean = [one + gain * error / variance for one, gain in zip(track.mean, gains, strict=True)]
    covariance = [
        [one - gain * other / variance for one, other in zip(row, gains, strict=True)]
        for row, gain in zip(track.covariance, gains, strict=True)
    ]
    covariance[-1][-1] += moved
    return _Track(track.weight + chance + log(max(_density(error, 0.0, variance), 1e-300)), mean, covariance, [], jumps)


def _times(matrix: list[list[float]], weights: Sequence[float]) -> list[float]:
    places = [place for place, weight in enumerate(weights) if weight]
    return [sum(row[place] * weights[place] for place in places) for row in matrix]


def _below(deviations: float) -> float:
    """Return the share of a normal distribution below so many deviations."""
    return 0.5 * (1 + erf(deviations / sqrt(2)))


def _density(value: float, mean: float, variance: float) -> float:
    return exp(-((value - mean) ** 2) / (2 * variance)) / sqrt(2 * pi * variance)


def _log_sum(values: Sequence[float]) -> float:
    most = max(values)
    return most + log(sum(exp(one - most) for one in values))
