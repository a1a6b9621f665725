"""Steps of devices that round what they are told, learnt from their answers. Pure."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, TypeAlias, final

from homebot.control.tolerance import fits
from homebot.devices.value import PlainValue

__all__ = ["Roundings"]

_PERCENTAGES: Final = frozenset({"level", "volume"})
_STEPS: Final = tuple(100.0 / count for count in range(2, 41))
"""Percent from one value that a device can take to the next: 50 to 2.5, for finer ones need no rule."""

_KEPT: Final = 8
_ENOUGH: Final = 3
"""Answers that show by which steps a device rounds, to at least two values."""

_SLACK: Final = 1.0
"""Percent by which an answer may differ from a whole step: many devices count to 254, or whole percents."""

_NEAREST, _DOWN, _UP = 0.5, 0.0, 1.0 - 1e-6
_MOST: Final = 1000

_Target: TypeAlias = tuple[str, str]
_Answer: TypeAlias = tuple[float, float]
"""What a device was told, and what it took."""


@final
class Roundings:
    """The last answers of devices that took another value than they were told: 8 each, of at most 1,000 targets.

    A device rounds where one size of steps explains all of them: to the nearest step, down or up. Where several sizes
    do, and differ in what they make of a value, nothing is known of that value.

    Attributes:
        known: The answers, by target and capability; for reading.
    """

    def __init__(self) -> None:
        self.known: OrderedDict[_Target, deque[_Answer]] = OrderedDict()

    def note(self, target: str, capability: str, wanted: PlainValue, seen: PlainValue) -> None:
        """Note that *target*, told to be at *wanted*, came to *seen*; nothing is kept of who always does as told."""
        if capability not in _PERCENTAGES or not (isinstance(wanted, float) and isinstance(seen, float)):
            return
        place = target, capability
        if not fits(capability, wanted, seen) and place not in self.known:
            self.known[place] = deque(maxlen=_KEPT)
            if len(self.known) > _MOST:
                self.known.popitem(last=False)
        answers = self.known.get(place)
        if answers is not None:
            self.known.move_to_end(place)
            if (wanted, seen) not in answers:
                answers.append((wanted, seen))

    def expected(self, target: str, values: Mapping[str, PlainValue]) -> Mapping[str, PlainValue]:
        """Return *values* as *target* will report them; the same where it is not known to round."""
        return {name: self._rounded((target, name), value) for name, value in values.items()}

    def _rounded(self, place: _Target, value: PlainValue) -> PlainValue:
        answers = self.known.get(place, ())
        if not isinstance(value, float) or len(answers) < _ENOUGH or len({seen for _, seen in answers}) < 2:
            return value
        found = list(_results(answers, value))
        is_clear = bool(found) and found[0] > 0.0 and max(found) - min(found) <= _SLACK
        return found[0] if is_clear else value


def _results(answers: Sequence[_Answer], value: float) -> Iterator[float]:
    """Yield what each way to round makes of *value* that explains all *answers*."""
    for step in _STEPS:
        for way in (_NEAREST, _DOWN, _UP):
            if all(abs(_in_steps(wanted, step, way) - seen) <= _SLACK for wanted, seen in answers):
                yield _in_steps(value, step, way)


def _in_steps(value: float, step: float, way: float) -> float:
    return min(100.0, step * math.floor(value / step + way))
