"""A habit, with the occasions that prove it. Pure."""

from dataclasses import dataclass
from math import comb, sqrt


@dataclass(frozen=True, slots=True)
class Occasion:
    """One time at which a routine would have acted.

    Attributes:
        at: In seconds since the Unix epoch.
        done_at: When a person did the same; None if nobody did.
    """

    at: float
    done_at: float | None


@dataclass(frozen=True, slots=True)
class FoundHabit:
    """A step that people do after something else, or at a time of day.

    Attributes:
        when: The trigger of the routine that would do it.
        conditions: Its conditions.
        do: Its step.
        device: The id of the device of that.
        within: Seconds within which people do it.
        occasions: All of them, in the order of time.
        held_out: On days that were not used to find it, how often people did it, and the number of occasions.
        recall: The share of the times that people do it which follow the trigger.
    """

    when: str
    conditions: tuple[str, ...]
    do: str
    device: str
    within: float
    occasions: tuple[Occasion, ...]
    held_out: tuple[int, int]
    recall: float

    @property
    def done(self) -> int:
        """The number of occasions on which a person did it."""
        return sum(occasion.done_at is not None for occasion in self.occasions)


@dataclass(frozen=True, slots=True)
class TriedHabit:
    """A habit after its trial.

    Attributes:
        trial: The occasions of the trial.
    """

    found: FoundHabit
    trial: tuple[Occasion, ...]

    @property
    def done(self) -> int:
        """The number of occasions of the trial on which a person did it."""
        return sum(occasion.done_at is not None for occasion in self.trial)

    @property
    def precision(self) -> float:
        """The share of occasions to expect: of the trial and the days held out, shrunk by two hits in four tries."""
        done, of = self._known()
        return (done + 2) / (of + 4)

    @property
    def precision_range(self) -> tuple[float, float]:
        """The range of that with 90 % certainty."""
        done, of = self._known()
        return wilson_lower_bound(done, of), 1.0 - wilson_lower_bound(of - done, of)

    def _known(self) -> tuple[int, int]:
        done, of = self.found.held_out
        return done + self.done, of + len(self.trial)


def wilson_lower_bound(done: int, of: int) -> float:
    """Return the share that is at least so with 95 % certainty: the lower bound of E. B. Wilson (1927)."""
    if not of:
        return 0.0
    z2 = 1.645**2
    share = done / of
    spread = sqrt(z2 * (share * (1 - share) / of + z2 / (4 * of * of)))
    return (share + z2 / (2 * of) - spread) / (1 + z2 / of)


def p_value(done: int, of: int, chance: float) -> float:
    """Return the probability of at least *done* hits *of* so many tries by *chance* alone."""
    return sum(comb(of, hits) * chance**hits * (1 - chance) ** (of - hits) for hits in range(done, of + 1))
