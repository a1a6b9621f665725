"""Next levels of the candidates, chosen so that most is learnt about the likely ones. Pure."""

from random import Random
from typing import Final

from homebot.identify.belief import Belief

_TRIED: Final = 60


def next_code(belief: Belief, random: Random) -> tuple[bool, ...]:
    """Return for each candidate whether it is bright next: the best of some that are drawn."""
    drawn = ([random.random() < 0.5 for _ in range(belief.count)] for _ in range(_TRIED))
    return tuple(max(drawn, key=lambda one: belief.gain([float(bright) for bright in one])))
