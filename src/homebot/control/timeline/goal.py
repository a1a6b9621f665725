"""Goal of one command: which reports show that the device obeyed, or is on its way. Pure."""

import math
from collections.abc import Mapping
from typing import Final, Literal, final

from homebot.control import durations
from homebot.control.timeline.facts import NOTHING, Nothing, Order, Reported, ReportRole
from homebot.control.timeline.profile import DeviceProfile
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import END_POSITIONS, STOPPED, changes, fits, is_same, related

_RUNS: Final = frozenset({"opening", "closing"})
_OPENINGS: Final = frozenset({"movement", "valve"})
_GRID: Final = 10.0
"""Percent by which a level may be beyond the wanted one: a dimmer has at least ten steps."""

STEP: Final = 0.5
"""The smallest change of a level or position, in percent, while a device is on its way."""


@final
class WantedValue:
    """Value that a part should report for one command, and its reports since.

    Args:
        known: The value that was certain before; :data:`NOTHING` if none was.

    Attributes:
        seen: The value that the device reported since; :data:`NOTHING` if it reported none.
        seen_at: When it did; -inf if it did not.
        met_at: When the wanted value was first reported; None if it is not reported any more, or never was.
        echoed_at: When its last echo came; None if none did.
        fast_at: When it was reported so fast that it may be an echo; None for never.
        returned_after: The seconds between a fast report and another value before the outcome; None if none followed.
        is_answered: Whether a report of the device itself followed an echo.
        is_step: Whether *seen* is an intermediate value.
    """

    seen: PlainValue | Nothing = NOTHING
    seen_at = -math.inf
    met_at: float | None = None
    echoed_at: float | None = None
    fast_at: float | None = None
    returned_after: float | None = None
    is_answered = is_step = False

    def __init__(
        self, order: Order, capability: str, value: PlainValue, known: PlainValue | Nothing, profile: DeviceProfile
    ) -> None:
        self._order, self._capability, self._known, self._profile = order, capability, known, profile
        self.value = value

    @property
    def was_so(self) -> bool:
        """True if the wanted value was certain before."""
        return self._known is not NOTHING and self._is_so(self._known)

    @property
    def is_certain(self) -> bool:
        """True if the wanted value is reported, or was certain before and nothing else is reported since."""
        is_kept = self.seen is NOTHING and self.was_so and not self._order.opens_further
        return self.met_at is not None or is_kept

    def fits(self, value: PlainValue) -> bool:
        """Return whether *value* is the wanted one, allowing for the device's rounding."""
        return self._profile.fits(self._capability, self.value, value)

    def is_told(self, value: PlainValue) -> bool:
        """Return whether *value*, which fits, shows that the device obeyed: the one from before must be exact."""
        return self._known != value or self._is_so(value)

    def refine(self, value: PlainValue) -> None:
        """Record that the device now reports the confirmed value as *value*, by itself."""
        self.seen = value
        self._profile.learn_answer(self._capability, self.value, value)

    def meet(self, fact: Reported, sent_at: float) -> None:
        """Record a report of the wanted value."""
        self.is_answered = self.is_answered or self.echoed_at is not None
        self.seen, self.seen_at = fact.value, fact.at
        if self.met_at is None:
            self.met_at = fact.at
            if fact.at - sent_at <= durations.FAST:
                self.fast_at = fact.at
        self.is_step = False

    def depart(self, fact: Reported) -> None:
        """Record a report of another value."""
        self.met_at = None
        if self.fast_at is not None and self.returned_after is None:
            self.returned_after = fact.at - self.fast_at
        self.is_answered = self.is_answered or self.echoed_at is not None
        self.seen, self.seen_at = fact.value, fact.at

    def echo(self, at: float, *, is_fast: bool) -> None:
        """Record that a bridge repeats the wanted value."""
        if is_fast:
            self.fast_at = at
        self.echoed_at = at

    def _is_so(self, value: PlainValue) -> bool:
        """Return whether *value* is exactly the wanted one, or was the device's answer to the same command earlier."""
        if is_same(self._capability, self.value, value):
            return True
        wanted = self._order.settings.get(self._capability)
        is_answer = (wanted, value) in self._profile.answers.get(self._capability, ())
        return is_answer and fits(self._capability, wanted, value)


@final
class Motion:
    """Approach of a level or position to its goal in the reports after one command.

    Many dimmers have a ramp of their own, and many blinds report only their position until the last step. Many bridges
    report "off" before the lamp has faded there: its further reports have lower and lower levels, but a lamp that was
    turned on again mostly reports its level from before. An innr RB 214 reports 1 at the end of its fade
    (Koenkk/zigbee2mqtt#2850).

    Attributes:
        moved_at: When the device was last seen on its way; -inf if it was not.
        stopped_at: When a motor last reported that it stopped; -inf if it did not.
    """

    __slots__ = (
        "_goals",
        "_is_fade",
        "_is_positioned",
        "_now",
        "_range",
        "_rose",
        "_told_at",
        "moved_at",
        "stopped_at",
    )

    def __init__(self, order: Order, last: Mapping[str, PlainValue]) -> None:
        settings = order.settings
        self.moved_at = self.stopped_at = self._told_at = -math.inf
        self._is_fade = self._rose = False
        self._range = -math.inf, math.inf
        self._is_positioned = order.moves and "position" in settings
        self._goals: dict[str, float] = {}
        self._now: dict[str, PlainValue] = {}
        level = 0.0 if settings.get("on_off") is False else settings.get("level")
        if isinstance(level, float):
            self._goals["level"] = level
            known = last.get("level")
            begun = self._now["level"] = 0.0 if last.get("on_off") is False else known
            if isinstance(known, float) and isinstance(begun, float):
                self._range = min(level - _GRID, begun), max(level + _GRID, known)
        position = END_POSITIONS.get(settings.get("movement"))
        if order.moves and not self._is_positioned and position is not None:
            self._goals["position"] = position
            self._now["position"] = last.get("position")

    @property
    def is_under_way(self) -> bool:
        """True if it was seen to move; a dimmer may be stuck on its ramp."""
        return self.moved_at > -math.inf and not self._is_fade

    @property
    def has_faded(self) -> bool:
        """True if a dimmer was seen on its way."""
        return self._is_fade and self.moved_at > -math.inf

    @property
    def has_stopped(self) -> bool:
        """True if a motor was seen on its way, and then reported that it stopped."""
        return -math.inf < self.moved_at <= self.stopped_at + durations.SAME_MESSAGE

    @property
    def has_level(self) -> bool:
        """True if the level of a lamp that is told its level, or off, is known."""
        return isinstance(self._now.get("level"), float)

    def approaches(self, capability: str, value: PlainValue, at: float) -> bool:
        """Record a report at that time; return whether it shows that the device is on its way."""
        goal = self._goals.get(capability)
        if self._is_positioned and capability in _OPENINGS:
            is_nearer = value in _RUNS
        elif goal is None or not isinstance(value, float):
            return False
        else:
            before = self._now.get(capability)
            if isinstance(before, float) and abs(value - before) < STEP:
                is_nearer = False
            else:
                self._now[capability] = value
                is_nearer = isinstance(before, float) and abs(before - goal) - abs(value - goal) >= STEP
                is_nearer = is_nearer and self.may_pass(capability, value)
            if capability == "level":
                self._is_fade = self._is_fade or is_nearer
                self._told_at = -math.inf if before is None else at
                self._rose = isinstance(before, float) and value >= before + STEP
        if is_nearer:
            self.moved_at = at
        return is_nearer

    def may_pass(self, capability: str, value: PlainValue) -> bool:
        """Return whether a *value* may be on the way of the device, as far as that is known."""
        lowest, highest = self._range
        return capability != "level" or not isinstance(value, float) or lowest <= value < highest + STEP

    def is_led_away(self, capability: str, value: PlainValue) -> bool:
        """Return whether a *value* is not on the way of a dimmer that was seen on it."""
        return self.has_faded and not self.may_pass(capability, value)

    def fade_sign(self, at: float) -> Literal["fading", "back", "unknown"]:
        """Return what the level in a message at that time shows of a lamp that is on after it was told off."""
        if at - self.moved_at <= durations.SAME_MESSAGE:
            return "fading"
        is_back = at - self._told_at <= durations.SAME_MESSAGE and (self._rose or self.moved_at == -math.inf)
        return "back" if is_back else "unknown"


def side_role(order: Order, capability: str, value: PlainValue) -> ReportRole:
    """Return the role of a report of a capability that *order* does not set."""
    settings = order.settings
    if STOPPED in settings.values():
        return ReportRole.MATCHES
    own = [name for name in related(capability) if name in settings and name != capability]
    is_against = any(changes(capability, value, name, settings[name]) for name in own)
    return ReportRole.SIDE_EFFECT if is_against else ReportRole.MATCHES
