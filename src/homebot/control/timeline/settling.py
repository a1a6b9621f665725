"""The seconds after a confirmation during which a device may still go back. Pure."""

import math
from collections.abc import Mapping
from typing import Final, Literal, NamedTuple, TypeAlias, final

from homebot.control import durations
from homebot.control.timeline.facts import Order, Reported, ReportRole
from homebot.control.timeline.goal import STEP, WantedValue, side_role
from homebot.devices.obedience import is_intermediate
from homebot.devices.value import PlainValue

FadeSign: TypeAlias = Literal["fading", "back", "unknown"]

_ON: Final = "on_off"
_NONE: Final[frozenset[str]] = frozenset()


class Undoing(NamedTuple):
    """The end of a confirmed value.

    Attributes:
        after: Seconds after the confirmation.
    """

    capability: str
    after: float


@final
class Settling:
    """Classifier of reports after a confirmation: further steps of a transition, or the end of the value.

    Args:
        known: The values that were certain before the command.
        last: The values that the part last reported before, certain or not.
        seconds: How long the values have to last.

    Attributes:
        until: When the watch ends, unless further steps come.
        undoing: The end of a value; None if all have lasted so far.
        has_held: Whether the values lasted until the end.
        led_nowhere: The numbers of the reports that counted as steps, but were the end of the value.
    """

    def __init__(
        self,
        order: Order,
        wanted: Mapping[str, WantedValue],
        known: Mapping[str, PlainValue],
        last: Mapping[str, PlainValue],
        at: float,
        seconds: float,
    ) -> None:
        self._order, self._wanted, self._known = order, wanted, known
        self._confirmed_at = at
        self._seconds = seconds
        self._steps_until = at + order.transition + durations.LAST_STEPS
        self._fades_until = at + order.transition if order.has_ramp else -math.inf
        self._fade = FadeOut(last.get("level")) if order.settings.get(_ON) is False else None
        self._is_fading = False
        self._step = ""  # the capability of the last intermediate value
        self._step_value: PlainValue = None
        self._level_until = math.inf
        self._steps: list[int] = []
        self.led_nowhere: frozenset[int] = frozenset()
        self._released = _NONE  # capabilities that newer commands set
        self.until = at + seconds + order.transition
        self.undoing: Undoing | None = None
        self.has_held = False

    @property
    def is_over(self) -> bool:
        """True if the value can no longer be undone, or was."""
        return self.undoing is not None or self.has_held or self._released >= self._order.settings.keys()

    @property
    def next_at(self) -> float:
        """The time of the next call of :meth:`advance`."""
        return min(self.until, self._level_until)

    def release(self, capabilities: set[str], at: float) -> None:
        """Stop watching *capabilities*, because a newer command sets them."""
        self._released |= capabilities
        if self._released >= self._order.settings.keys():
            self.until = min(self.until, at)

    def advance(self, now: float) -> None:
        """Record that the value is undone if no step followed the last one."""
        if self.is_over:
            return
        if self._step and (now >= self.until or (now >= self._level_until and not self._is_fading)):
            self._undo(self._step, min(now, self.next_at))
        elif now >= self.until:
            self.has_held = True

    def report(self, fact: Reported) -> ReportRole:
        """Return the role of a report, which may be the end of a value."""
        capability = fact.capability
        if self._fade is not None and capability == "level":
            return self._fade_role(self._fade.report(fact.value, fact.at), fact)
        if not self._departs(capability, fact.value):
            return self._kept_role(fact)
        is_fading = capability == _ON and fact.at < self._fades_until
        may_fade = is_fading or (self._fade is not None and self._fade.is_possible)
        if not (may_fade or self._may_move_on(fact)):
            self._undo(capability, fact.at)
            return ReportRole.UNDONE
        if (self._step, self._step_value) != (capability, fact.value):
            self._begin_step(fact, may_fade=may_fade)
        return self._step_role(fact.number)

    def _kept_role(self, fact: Reported) -> ReportRole:
        if self._step == fact.capability:
            self._end_steps()
        if fact.capability not in self._wanted:
            return side_role(self._order, fact.capability, fact.value)
        self._wanted[fact.capability].refine(fact.value)
        return ReportRole.EFFECT

    def _departs(self, capability: str, value: PlainValue) -> bool:
        """Return whether *value* is neither the wanted one nor on the way there."""
        is_commanded = capability in self._order.settings
        if capability not in self._wanted or (is_commanded and capability in self._released):
            return False
        if capability == _ON and not is_commanded:
            return False  # a newer command may have turned it off
        return self._wanted[capability].departs(value)

    def _may_move_on(self, fact: Reported) -> bool:
        """Return whether a dimmer or a motor that reported the wanted value may still be on its way there."""
        capability, value = fact.capability, fact.value
        before, wanted = self._known.get(capability), self._wanted[capability].value
        if not (isinstance(wanted, float) and isinstance(value, float)):
            return False
        if is_intermediate(capability, wanted, value):
            return True
        if fact.at > self._steps_until:
            return False
        if capability == "level" and self._order.turns_on and value < wanted:
            return True  # it fades in from 0
        return not isinstance(before, float) or min(before, wanted) < value < max(before, wanted)

    def _begin_step(self, fact: Reported, *, may_fade: bool) -> None:
        """Wait for the next step; for the level of a lamp that is on again, or the end of its transition."""
        self._step, self._step_value = fact.capability, fact.value
        self._steps_until = max(self._steps_until, fact.at + durations.LAST_STEPS)
        self._wait_on(fact.at)
        self._level_until = max(fact.at, self._fades_until) + durations.LEVEL_FOLLOWS if may_fade else math.inf
        if self._fade is not None:
            self._judge_fade(self._fade.sign(fact.at), fact.at)

    def _fade_role(self, sign: FadeSign, fact: Reported) -> ReportRole:
        if not self._step:  # it did not report that it is on again
            return ReportRole.STEP if sign == "fading" else ReportRole.AGREES
        self._judge_fade(sign, fact.at)
        return self._step_role(fact.number)

    def _judge_fade(self, sign: FadeSign, at: float) -> None:
        if sign == "back" and self._step == _ON and at < self._fades_until:
            self._level_until = min(self._level_until, max(at + durations.LEVEL_FOLLOWS, self._fades_until))
        elif sign == "back":
            self._undo(self._step, at)
        elif sign == "fading":
            self._is_fading, self._level_until = True, math.inf
            self._wait_on(at)

    def _wait_on(self, now: float) -> None:
        until = min(now + self._seconds, self._confirmed_at + durations.LONGEST_MOVE)
        self.until = max(self.until, until)

    def _step_role(self, number: int) -> ReportRole:
        if self.undoing is not None:
            return ReportRole.UNDONE
        self._steps.append(number)
        return ReportRole.STEP

    def _end_steps(self) -> None:
        self._step, self._step_value, self._is_fading, self._level_until = "", None, False, math.inf
        self._steps.clear()

    def _undo(self, capability: str, at: float) -> None:
        self.led_nowhere = frozenset(self._steps)
        self._steps.clear()
        self.undoing = Undoing(capability, at - self._confirmed_at)
        self.until = at


@final
class FadeOut:
    """Distinction between a lamp that fades out after it reported "off" and one that was turned on again.

    Many bridges report the commanded value before the lamp has faded there. Further reports have lower and lower
    levels, but a lamp that was turned on again mostly reports its level from before. An innr RB 214 reports 1 at the
    end of its fade (Koenkk/zigbee2mqtt#2850).

    Args:
        level: The level that the lamp reported before it was turned off; None if it reported none. The first level that
            it reports since takes its place.
    """

    __slots__ = ("_level", "_lowered_at", "_told_at")

    def __init__(self, level: PlainValue) -> None:
        self._level = level if isinstance(level, float) else math.inf
        self._told_at = self._lowered_at = -math.inf

    @property
    def is_possible(self) -> bool:
        """True if an earlier level is known."""
        return self._level < math.inf

    def report(self, level: PlainValue, now: float) -> FadeSign:
        """Record a report of *level* at *now*, and return its meaning."""
        if not isinstance(level, float):
            return "unknown"
        self._told_at = now
        if not self.is_possible:
            self._level = level
            return "unknown"
        if level < self._level - STEP:
            self._level, self._lowered_at = level, now
            return "fading"
        return "back" if level > self._level + STEP or self._lowered_at == -math.inf else "unknown"

    def sign(self, now: float) -> FadeSign:
        """Return the meaning of a report of "on" at *now*, judging by the level in the same message."""
        if now - self._lowered_at <= durations.SAME_MESSAGE:
            return "fading"
        is_back = now - self._told_at <= durations.SAME_MESSAGE and self._lowered_at == -math.inf
        return "back" if is_back else "unknown"
