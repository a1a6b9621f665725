"""Leases: held values of parts, their holders, and their end."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

import anyio

from homebot.control.command import IssuedCommand
from homebot.control.timeline.cause import HeldValue
from homebot.control.timeline.facts import PartRef
from homebot.devices.command_messages import Setting
from homebot.devices.outcomes import NoAnswer, Outcome, Refused
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import STOPPED, changes
from homebot.devices.wording.journal_words import issuer_text, trigger_text
from homebot.devices.wording.values import value_text

LEASE_POLICY: Final = "lease"
"""The policy that a refusal names."""

MAX_HOLDERS: Final = 1000
"""The limit of holders in all; further ones are refused and counted."""

MAX_HOLDERS_OF_ISSUER: Final = 50
"""The limit of holders of one issuer; further ones are refused and counted, so that there is room for others."""

_MAX_NAMED: Final = 3
_COMMANDING: Final = NoAnswer(0.0, "it is being commanded")

_KEEPING: Final = frozenset({"lease", "end"})
"""Triggers of commands that keep or put back a value, whoever began that."""

HolderKey: TypeAlias = tuple[str, str, str]
"""Issuer, name for people, and the name of the lease."""


@dataclass(slots=True)
class LeaseHolder:
    """Holder of a lease.

    Attributes:
        ttl: Seconds that each renewal gives.
        deadline: The end, on the monotonic clock.
        scope: Its rights, if it is a client of the door.
        is_open_ended: Whether it renews the lease until it releases it.
        yields_to_persons: Whether a person's command is obeyed nevertheless, if all holders say so.
        transition: Seconds of each change to the value; 0 for those of the device.
    """

    by: str
    ttl: float
    deadline: float
    scope: tuple[str, ...] = ()
    trigger: Trigger = NO_TRIGGER
    is_open_ended: bool = False
    yields_to_persons: bool = False
    transition: float = 0.0

    @property
    def text(self) -> str:
        """Its name, with the client that called it."""
        return f"{self.by} ({trigger_text(self.trigger, {})})" if self.trigger.kind == "client" else self.by


@dataclass(slots=True, eq=False)
class Lease:
    """A held value of a part.

    Attributes:
        again_at: The time at which the value is commanded again, on the monotonic clock; inf for never.
        hand_until: When a hand, or a stop command, no longer outranks the lease.
        yielded_to: The issuer of a person's command that outranks it: it is neither renewed nor commanded again.
        held: The watched value; None before the watch begins.
        stop_watch: Ends the watch of the part; None before it begins.
    """

    part: PartRef
    capability: str
    value: PlainValue
    holders: dict[HolderKey, LeaseHolder] = field(default_factory=dict)
    again_at: float = math.inf
    hand_until: float = -math.inf
    saw: str = ""
    yielded_to: str = ""
    held: HeldValue | None = None
    stop_watch: Callable[[], None] | None = None
    lock: anyio.Lock = field(default_factory=anyio.Lock)
    outcome: Outcome = _COMMANDING

    @property
    def setting(self) -> Setting:
        """The held setting."""
        return Setting.of(self.capability, self.value)

    @property
    def held_value(self) -> str:
        """The value after the word *held*: ``open``, ``at 40 %``."""
        text = value_text(self.capability, self.value)
        return f"at {text}" if isinstance(self.value, float) else text

    def text(self, now: float) -> str:
        """Return the value, the holders and the time left, for people."""
        names = list(dict.fromkeys(holder.text for holder in self.holders.values()))
        more = f" and {len(names) - _MAX_NAMED} more" if len(names) > _MAX_NAMED else ""
        left = max((holder.deadline - now for holder in self.holders.values()), default=0.0)
        is_open_ended = any(holder.is_open_ended for holder in self.holders.values())
        until = "until it is released" if is_open_ended else f"for {math.ceil(left)} s more"
        return f"held {self.held_value} by {', '.join(names[:_MAX_NAMED])}{more} {until}"

    @property
    def yields_to_persons(self) -> bool:
        """True if all its holders yield to persons."""
        return all(holder.yields_to_persons for holder in self.holders.values())

    def outranked(self, now: float) -> str:
        """Return why the lease is outranked at *now*; empty if it is not."""
        left = self.hand_until - now
        return f"{self.saw}, which outranks leases for {math.ceil(left)} s more" if left > 0 else ""

    def hand_back(self) -> bool:
        """Record that no hand outranks the lease any more, or is waited for; return whether one did."""
        was_outranked = self.hand_until > -math.inf
        self.again_at, self.hand_until, self.saw = math.inf, -math.inf, ""
        return was_outranked


@final
class Leases:
    """The leases of a home: one for each part and capability, with any number of holders of the same value.

    Args:
        hand_time: Seconds for which a hand outranks a lease.

    Attributes:
        refused: The number of holders beyond :data:`MAX_HOLDERS` or :data:`MAX_HOLDERS_OF_ISSUER`.
        parts: The leases of each part that has any, by capability; for reading.
        on_outranked: Called with each lease when a hand or a command outranks it.
    """

    def __init__(self, hand_time: float) -> None:
        self.refused = 0
        self.hand_time = hand_time
        self.on_outranked: Callable[[Lease], None] = lambda _: None
        self._ended: dict[HolderKey, tuple[float, str]] = {}
        self.parts: dict[PartRef, dict[str, Lease]] = {}
        self._of: dict[HolderKey, Lease] = {}

    def __iter__(self) -> Iterator[Lease]:
        return (lease for leases in self.parts.values() for lease in leases.values())

    def hold(
        self, part: PartRef, capability: str, value: PlainValue, key: HolderKey, holder: LeaseHolder, now: float
    ) -> Lease | str:
        """Add *holder* at *now*, after :meth:`expire`; return the lease, or the reason of a refusal."""
        if key in self._ended:
            return f"its lease was ended by {self._ended[key][1]}"
        if problem := self.refusal(part, {capability: value}, now):
            return problem
        if key in self._of:
            return f"{key[1]} has a lease {key[2]} already"
        if full := self._limit(key[0]):
            self.refused += 1
            return full
        lease = self.parts.setdefault(part, {}).setdefault(capability, Lease(part, capability, value))
        if outranked := lease.outranked(now):
            return outranked
        lease.holders[key] = holder
        self._of[key] = lease
        return lease

    def renew(self, key: HolderKey, now: float) -> Lease | None:
        """Renew the lease of a holder, unless it has yielded; return it, or None if it is over."""
        lease = self._of.get(key)
        if lease is None or (holder := lease.holders[key]).deadline <= now:
            return None
        if not lease.yielded_to:
            holder.deadline = now + holder.ttl
        return lease

    def release(self, key: HolderKey) -> Lease | None:
        """Remove a holder; return its lease, which ends with its last holder."""
        lease = self._of.pop(key, None)
        if lease is None:
            return None
        del lease.holders[key]
        if not lease.holders:
            if lease.stop_watch is not None:
                lease.stop_watch()
            leases = self.parts[lease.part]
            del leases[lease.capability]
            if not leases:
                del self.parts[lease.part]
        return lease

    def end(self, device: str, by: str, now: float) -> list[tuple[Lease, HolderKey, LeaseHolder]]:
        """Release all holders of *device* for *by*; return them with their leases.

        A holder may request its lease again: under the same name that is refused for the duration of the lease.
        """
        ended = [
            (lease, key, holder) for lease in self if lease.part[0] == device for key, holder in lease.holders.items()
        ]
        for _, key, holder in ended:
            self.release(key)
            self._ended[key] = now + holder.ttl, by
            if len(self._ended) > MAX_HOLDERS:
                del self._ended[next(iter(self._ended))]
        return ended

    def expire(self, now: float) -> list[tuple[Lease, HolderKey, LeaseHolder]]:
        """Release the holders with a deadline before *now*, and return them with their leases."""
        self._ended = {key: ended for key, ended in self._ended.items() if ended[0] > now}
        over = [(key, lease.holders[key]) for key, lease in self._of.items() if lease.holders[key].deadline <= now]
        return [(lease, key, holder) for key, holder in over if (lease := self.release(key)) is not None]

    def outranked(self, key: HolderKey, now: float) -> str:
        """Return why the lease of a holder is outranked at *now*; empty if it is not."""
        lease = self._of.get(key)
        return "" if lease is None else lease.outranked(now)

    def refusal(
        self,
        part: PartRef,
        settings: Mapping[str, PlainValue],
        now: float,
        *,
        is_by_person: bool = False,
        overrides: bool = False,
    ) -> str:
        """Return why a command, perhaps by a person, is refused at *now*; empty if no lease forbids it."""
        leases = self.parts.get(part)
        if leases is None:
            return ""
        for lease in leases.values():
            if all(holder.deadline <= now for holder in lease.holders.values()):
                continue  # ended, but not removed yet
            if is_by_person and (overrides or lease.yields_to_persons):
                continue
            for capability, value in settings.items():
                if value != STOPPED and changes(lease.capability, lease.value, capability, value):
                    return lease.text(now)
        return ""

    def refuse(self, command: IssuedCommand, now: float) -> Refused | None:
        """Return the refusal of a command at *now*; None if no lease forbids it."""
        by_person = _is_by_person(command)
        reason = self.refusal(command.place, command.settings, now, is_by_person=by_person, overrides=command.override)
        return Refused(LEASE_POLICY, reason, command_id=command.id) if reason else None

    def record_stop(self, command: IssuedCommand, now: float) -> None:
        """Record that a stop command outranks the leases of its part, just as a hand does."""
        leases = self.parts.get(command.place)
        if leases is not None and STOPPED in command.settings.values():
            for lease in leases.values():
                self.outrank(lease, "it was stopped", now)

    def yield_to(self, command: IssuedCommand, now: float) -> None:
        """Record that *command*, if a person gave it, outranks leases of its parts: those that yield or are overridden.

        One that is overridden counts again after a while, as after a hand.
        """
        places = (command.place, *((device.id, part.id) for device, part in command.members))
        for place in places if _is_by_person(command) else ():
            for lease in self.parts.get(place, {}).values():
                is_against = any(
                    changes(lease.capability, lease.value, name, value) for name, value in command.settings.items()
                )
                if command.override and is_against and not lease.yields_to_persons:
                    self.outrank(lease, f"{issuer_text(command.issuer)} overrode it", now)
                elif lease.yields_to_persons:
                    lease.yielded_to, lease.saw = command.issuer, f"a command by {issuer_text(command.issuer)}"
                    lease.again_at = lease.hand_until = max(holder.deadline for holder in lease.holders.values())
                    self.on_outranked(lease)

    def outrank(self, lease: Lease, saw: str, now: float) -> None:
        """Record that a hand changed the held value of *lease*: nothing is commanded for a while."""
        if lease.yielded_to:
            return
        lease.saw = saw
        lease.again_at = lease.hand_until = now + self.hand_time
        self.on_outranked(lease)

    def next_time(self) -> float:
        """Return when the next lease ends, or a value is commanded again; inf for never."""
        times = (min([lease.again_at, *(holder.deadline for holder in lease.holders.values())]) for lease in self)
        return min(times, default=math.inf)

    def _limit(self, issuer: str) -> str:
        """Return the limit that *issuer* has reached; empty if there is room for one more holder."""
        if len(self._of) >= MAX_HOLDERS:
            return f"there are {MAX_HOLDERS:,} holders already"
        if sum(key[0] == issuer for key in self._of) >= MAX_HOLDERS_OF_ISSUER:
            return f"{issuer} has {MAX_HOLDERS_OF_ISSUER} leases already; release one first"
        return ""


def _is_by_person(command: IssuedCommand) -> bool:
    """Return whether a person gave *command*, and neither a lease nor the end of what a person began."""
    return command.is_by_person and command.trigger.kind not in _KEEPING
