"""Changes of another program, past homebot, told from those of people by their habits. Pure."""

import math
from typing import Final, NamedTuple, final

from homebot.control import durations
from homebot.control.timeline.facts import Reported
from homebot.control.timeline.profile import KEPT, DeviceProfile
from homebot.devices.value import PlainValue

_LOOKS: Final = frozenset({"level", "color_temperature", "color"})
_MAX_CREEP: Final = 0.05


class _Creep(NamedTuple):
    """Change of the level or colour of a lit lamp that nothing explains, with its further steps.

    Attributes:
        at: When its newest step came, in seconds.
        begin: The values before, by capability.
        is_small: Whether nobody would see it.
        is_usual: Whether another program makes such changes.
    """

    at: float
    begin: dict[str, PlainValue]
    is_small: bool
    is_usual: bool


@final
class ProgramWatch:
    """The changes of one part that nothing explains: a program makes them regularly, or little by little.

    At intervals of at most an hour; a setpoint at the same second each day; or the level and colour of a lit lamp by at
    most five percent, again and again.
    """

    def __init__(self, profile: DeviceProfile) -> None:
        self._profile = profile
        self._creep: _Creep | None = None
        self._changed_at: dict[tuple[str, PlainValue], float] = {}

    def recognizes(self, fact: Reported, *, is_lit: bool) -> bool:
        """Return whether a change that nothing explains is usual for a program; learn from it."""
        capability, is_look = fact.capability, fact.capability in _LOOKS
        value = "" if is_look else fact.value  # each value is another one
        last_at = self._changed_at.pop((capability, value), -math.inf)
        self._changed_at[capability, value] = fact.at
        if len(self._changed_at) > KEPT:
            del self._changed_at[next(iter(self._changed_at))]
        if is_look and self._creep is not None and fact.at - self._creep.at < durations.CREEPS:
            return self._is_further_step(fact, self._creep)
        gap = fact.at - last_at
        is_interval = gap <= durations.INTERVAL or (isinstance(value, float) and gap < math.inf)
        is_usual = is_interval and self._profile.learn_gap(capability, value, gap)
        if is_look and is_lit:
            is_small = _is_small(capability, fact.previous, fact.value)
            is_usual = self._profile.learn_creep(is_small=is_small) or is_usual
            self._creep = _Creep(fact.at, {capability: fact.previous}, is_small, is_usual)
        return is_usual

    def _is_further_step(self, fact: Reported, creep: _Creep) -> bool:
        """Return whether a step, or the colour after the level, still belongs to a usual small change."""
        begin = creep.begin.setdefault(fact.capability, fact.previous)
        is_small = creep.is_small and _is_small(fact.capability, begin, fact.value)
        if creep.is_small and not is_small:
            self._profile.learn_creep(is_small=False)
        self._creep = creep._replace(at=fact.at, is_small=is_small)
        return creep.is_usual and is_small


def _is_small(capability: str, before: PlainValue, value: PlainValue) -> bool:
    """Return whether a number changed by at most five percent, of the range of a level or of the colour temperature."""
    if not (isinstance(before, float) and isinstance(value, float)):
        return False
    return abs(value - before) <= _MAX_CREEP * (100.0 if capability == "level" else before)
