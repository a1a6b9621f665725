"""Faults between a broker and its clients.

A fault begins with the call that causes it, and ends with :meth:`Fault.lift` or its ``with`` block. Faults may be
caused and lifted in any thread; they apply from the next packet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from enum import Enum
from typing import Self, final

from homebot.mqtt.broker import BrokerPolicy
from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topics import topic_matches


class FaultKind(Enum):
    """The kinds of faults; acknowledgements are PUBACK, PUBREC and PUBCOMP."""

    DROPPED_ACKS = "acknowledgements vanish on their way to the client"
    DELAYED_ACKS = "acknowledgements come late; other packets overtake them"
    HALF_PACKET = "the next packet to the client is cut in the middle and the connection closed"
    SLOW_READER = "the client accepts no bytes; written ones follow when the fault is lifted"
    REFUSED_SUBSCRIBE = "subscriptions to exactly this filter are refused"
    REFUSED_PUBLISH = "messages on topics that match the filter are refused and not forwarded"


@final
@dataclass(eq=False)
class Fault:
    """A fault in force until it is lifted.

    Attributes:
        client: Client id of the concerned connection, or None for all.
        seconds: The delay of acknowledgements.
        reason: The answer to a refused packet.
        on_lift: Called once, in the thread that lifts it.
    """

    kind: FaultKind
    client: str | None
    _: KW_ONLY
    seconds: float = 0.0
    filter: str = ""
    reason: ReasonCode = ReasonCode.SUCCESS
    hits: int = 0
    on_lift: Callable[[Fault], None] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.lift()

    def lift(self) -> None:
        """End the fault. Idempotent."""
        on_lift, self.on_lift = self.on_lift, None
        if on_lift is not None:
            on_lift(self)

    def concerns(self, kind: FaultKind, client: str | None, topic: str) -> bool:
        """Return whether it is of *kind*, for *client*, and for *topic*."""
        if self.kind is not kind or self.client not in (None, client):
            return False
        is_publish = kind is FaultKind.REFUSED_PUBLISH
        return topic_matches(self.filter, topic) if is_publish else self.filter == topic


@final
class FaultRules:
    """The faults in force.

    Args:
        on_lift: Called with each fault that is lifted, in the thread that lifts it.
    """

    def __init__(self, on_lift: Callable[[Fault], None]) -> None:
        self._faults: tuple[Fault, ...] = ()  # replaced as a whole: the broker's thread reads it at any time
        self._on_lift = on_lift

    def find(self, kind: FaultKind, client: str | None, topic: str = "") -> Fault | None:
        """Return the first fault of this kind that concerns *client*; a refusal concerns a filter or topic."""
        return next((fault for fault in self._faults if fault.concerns(kind, client, topic)), None)

    def add(self, fault: Fault) -> Fault:
        """Put a fault in force."""
        fault.on_lift = self._remove
        self._faults = (*self._faults, fault)
        return fault

    def lift_all(self) -> None:
        """End every fault."""
        for fault in self._faults:
            fault.lift()

    def _remove(self, fault: Fault) -> None:
        self._faults = tuple(kept for kept in self._faults if kept is not fault)
        self._on_lift(fault)


@final
class FaultPolicy:
    """A :class:`BrokerPolicy` that refuses by the faults in force, and otherwise by the policy below."""

    def __init__(self, rules: FaultRules, otherwise: BrokerPolicy) -> None:
        self._rules = rules
        self._otherwise = otherwise

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002 - the port's own word
        """Return success or the reason of a refusal."""
        refusal = self._refusal(FaultKind.REFUSED_SUBSCRIBE, client_id, filter)
        return refusal or self._otherwise.subscribe(client_id, filter)

    def publish(self, client_id: str, topic: str) -> ReasonCode:
        """Return success or the reason of a refusal."""
        return self._refusal(FaultKind.REFUSED_PUBLISH, client_id, topic) or self._otherwise.publish(client_id, topic)

    def _refusal(self, kind: FaultKind, client_id: str, topic: str) -> ReasonCode:
        fault = self._rules.find(kind, client_id, topic)
        if fault is None:
            return ReasonCode.SUCCESS
        fault.hits += 1
        return fault.reason
