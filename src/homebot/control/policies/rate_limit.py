"""Rate limit: no value is switched back and forth endlessly. Pure."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Final

from pydantic import Field

from homebot.control import durations
from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.control.timeline.facts import Sent
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices.client_rights import LOCAL_CLIENT, issuer_of_client
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import POWERS
from homebot.units import Seconds

NAME: Final = "rate_limit"

_WITHIN: Final = Verdict(NAME, allowed=True)

_NAMELESS: Final = issuer_of_client(LOCAL_CLIENT)

_FLASHES: Final = 3
_ADVICE: Final = "; with a token (`homebot token new`) a program may more often"

_POWER: Final = "power_state"
"""Name for the power of a part, whichever capability switches it."""

_REPORTED_POWERS: Final = ("on_off", "level", "fan_speed")
"""The capabilities that report it, the best first."""


class RateLimitSettings(PolicyTable):
    """The table ``[control.rate_limit]``.

    Attributes:
        changes: How many turns of a value are allowed within *seconds*; to a program without a token at most as many as
            *seconds*, and three within any second, as WCAG 2.2 (2.3.1) allows flashes.
    """

    changes: int = Field(default=30, ge=1, le=1000)
    seconds: Seconds = Field(default=10.0, le=durations.COUNTED)

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse a command that turns a value more often than allowed."""
        limits = {self.seconds: self.changes}
        if command.issuer == _NAMELESS and command.trigger.kind == "program":
            limits |= {1.0: _FLASHES, self.seconds: math.ceil(self.seconds)}
        timeline = facts.timeline_of(command.device, command.part)
        sent, now = timeline.sent, facts.monotonic
        for seconds, most in limits.items():
            changes = min(most, self.changes)
            if len(sent) <= changes or sent[-changes].at <= now - seconds:
                continue  # as nearly always
            turns = count_turns(timeline, command, now, seconds)
            if turns >= changes:
                used = FactUsed(f"changes of {command.target} in {seconds:g} s", float(turns))
                advice = _ADVICE if changes < self.changes else ""
                reason = f"{command.label} was switched back and forth {turns} times within {seconds:g} s{advice}"
                return Verdict(NAME, allowed=False, reason=reason, facts=(used,))
        return _WITHIN


def count_turns(timeline: PartTimeline, command: IssuedCommand, now: float, seconds: float) -> int:
    """Return how often the values that *command* turns did so within *seconds*; 0 if it turns none.

    A turn is a command whose value differs from the one before; a number must also change direction, so dimming is not
    a turn. On and off are one value, whichever capability commands them: level 0 is off. A turn counts from the last
    sending of its command: the device may not have received it before.
    """
    last = {sending.command: sending for sending in timeline.sent if sending.command != command.id}
    sent = [*last.values(), Sent(command.id, command.settings, now)]
    return max((_turns_of(name, sent, timeline, now - seconds) for name in _effects(command.settings)), default=0)


def _turns_of(name: str, sent: list[Sent], timeline: PartTimeline, since: float) -> int:
    """Return how often the value of *name* turned, without the last of *sent*; 0 if that does not turn it."""
    effects = [(sending.at, effect) for sending in sent if (effect := _effects(sending.settings).get(name)) is not None]
    turns, is_turn, direction = 0, False, 0.0
    for (before_at, before), (at, value) in pairwise(effects):
        step = value - before if isinstance(value, float) and isinstance(before, float) else 0.0
        if value == before:
            is_turn = name == _POWER and _is_undone(timeline, value, before_at, at)
        else:
            is_turn = not step or step * direction < 0
        direction = step or direction
        turns += is_turn and at > since
    return turns - 1 if is_turn else 0


def _effects(settings: Mapping[str, PlainValue]) -> dict[str, PlainValue]:
    """Return the values of *settings*; for a power also :data:`_POWER`, with True for on."""
    effects = {name: value for name, value in settings.items() if name != "on_off"}
    if powers := [value for name, value in settings.items() if name in POWERS]:
        effects[_POWER] = bool(powers[-1])
    return effects


def _is_undone(timeline: PartTimeline, value: PlainValue, after: float, until: float) -> bool:
    """Return whether the part reported the opposite power after a command switched it, and before the next one."""
    power = next((name for name in _REPORTED_POWERS if timeline.value(name) is not None), "")
    reported = [fact.value for fact in timeline.reports if fact.capability == power and after < fact.at <= until]
    return bool(reported) and bool(reported[-1]) is not value
