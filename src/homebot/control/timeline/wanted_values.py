"""Wanted values of one command, and which reports show that the device obeyed. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, final

from homebot.control.timeline.facts import Order
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.tolerance import fits, is_other_end, is_same
from homebot.devices.value import PlainValue

__all__ = ["WantedValues"]

_NOTHING: Final = object()


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
