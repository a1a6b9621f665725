"""Goal of one command: the reports that show that the device obeyed, or is on its way. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, final

from homebot.control.timeline.facts import Order
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.values import END_POSITIONS, fits, is_other_end, is_same
from homebot.devices.value import PlainValue

__all__ = ["Motion", "WantedValues"]

_NOTHING: Final = object()
_RUNS: Final = frozenset({"opening", "closing"})
_OPENINGS: Final = frozenset({"movement", "valve"})
_STEP: Final = 0.5
"""Percent by which a level or a position changes at least while a device is on its way."""


@final
class WantedValues:
    """Comparison of reports with the values that a part is to report, as its device rounds.

    Args:
        order: The command.
        known: The values that were certain before.
        profile: Knowledge of the device.

    Attributes:
        by_capability: The wanted values.
    """

    def __init__(self, order: Order, known: Mapping[str, PlainValue], profile: DeviceProfile) -> None:
        self._order = order
        self._known = known
        self._profile = profile
        self.by_capability = dict(order.wanted)
        self._slack = {one: slack for one in order.wanted if (slack := profile.rounding(one))}
        if order.turns_on:  # that it has the wanted colour, or level, does not show that it is on
            self.by_capability["on_off"] = True

    @property
    def were_so(self) -> bool:
        """True if the wanted values were certain before."""
        for name, value in (self.by_capability or self._order.settings).items():
            if name not in self._known:
                return False
            before = self._known[name]
            if not (is_same(name, value, before) or self._is_answer(name, before)):
                return False
        return not self._order.opens_further

    def fits(self, capability: str, value: PlainValue) -> bool:
        """Return whether *value* is the wanted one, as the device rounds."""
        wanted = self.by_capability[capability]
        if fits(capability, wanted, value):
            return True
        slack = self._slack.get(capability)
        if not slack or not (isinstance(wanted, float) and isinstance(value, float)):
            return False
        return abs(wanted - value) <= slack and not is_other_end(capability, wanted, value)

    def shows_obedience(self, capability: str, value: PlainValue) -> bool:
        """Return whether the device obeyed: a value that it had before shows that only if it is the exact one."""
        if not self.fits(capability, value):
            return False
        if self._known.get(capability, _NOTHING) != value:
            return True
        return is_same(capability, self.by_capability[capability], value) or self._is_answer(capability, value)

    def _is_answer(self, capability: str, value: PlainValue) -> bool:
        wanted = self._order.settings.get(capability)
        return fits(capability, wanted, value) and self._profile.is_answer(capability, wanted, value)


@final
class Motion:
    """Approach of a level or a position to its goal, over the reports after one command.

    Many dimmers have a ramp of their own, and many blinds report their position alone until the last step.

    Args:
        order: The command.
        last: The values that the part reported last.
    """

    __slots__ = ("_goals", "_is_positioned", "_now")

    def __init__(self, order: Order, last: Mapping[str, PlainValue]) -> None:
        settings = order.settings
        self._is_positioned = order.moves and "position" in settings
        self._goals: dict[str, float] = {}
        self._now: dict[str, float] = {}
        level = 0.0 if settings.get("on_off") is False else settings.get("level")
        if isinstance(level, float):
            self._goals["level"] = level
            self._begin("level", 0.0 if last.get("on_off") is False else last.get("level"))
        position = END_POSITIONS.get(settings.get("movement"))
        if order.moves and not self._is_positioned and position is not None:
            self._goals["position"] = position
            self._begin("position", last.get("position"))

    def shows(self, capability: str, value: PlainValue) -> bool:
        """Return whether a report shows that the device is on its way."""
        if self._is_positioned and capability in _OPENINGS:
            return value in _RUNS
        goal = self._goals.get(capability)
        if goal is None or not isinstance(value, float):
            return False
        before = self._now.get(capability)
        self._now[capability] = value
        return before is not None and abs(before - goal) - abs(value - goal) >= _STEP

    def _begin(self, capability: str, value: PlainValue) -> None:
        if isinstance(value, float):
            self._now[capability] = value
