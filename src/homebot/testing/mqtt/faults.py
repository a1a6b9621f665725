"""Faults between a broker and its clients.

A fault begins with the call that makes it, and ends with :meth:`Fault.lift` or at the end of its ``with`` block.
Rules may be made and lifted in any thread; they hold for the next packet.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Self, TypeVar, final

from homebot.mqtt.broker import BrokerPolicy
from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topics import topic_matches

__all__ = [
    "DelayedAcks",
    "DroppedAcks",
    "Fault",
    "FaultPolicy",
    "FaultRules",
    "HalfPacket",
    "RefusedPublish",
    "RefusedSubscribe",
    "SlowReader",
]


class Fault:
    """One thing that goes wrong until it is lifted.

    Args:
        client: Client id of the concerned connection, or None for all.
    """

    def __init__(self, client: str | None, on_lift: Callable[[Fault], None]) -> None:
        self.client = client
        self.hits = 0
        self._on_lift: Callable[[Fault], None] | None = on_lift

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.lift()

    def lift(self) -> None:
        """End the fault; nothing where it has ended."""
        on_lift, self._on_lift = self._on_lift, None
        if on_lift is not None:
            on_lift(self)


class DroppedAcks(Fault):
    """PUBACK, PUBREC and PUBCOMP vanish on their way to the client."""


class DelayedAcks(Fault):
    """PUBACK, PUBREC and PUBCOMP come *seconds* late; other packets overtake them."""

    def __init__(self, client: str | None, on_lift: Callable[[Fault], None], seconds: float) -> None:
        super().__init__(client, on_lift)
        self.seconds = seconds


class HalfPacket(Fault):
    """The next packet to the client is cut in the middle and the connection closed; then the fault is over."""


class SlowReader(Fault):
    """The client accepts no bytes; written ones follow when the fault is lifted."""


class RefusedSubscribe(Fault):
    """Subscriptions to exactly this filter are answered with *reason*."""

    def __init__(self, client: str | None, on_lift: Callable[[Fault], None], filter: str, reason: ReasonCode) -> None:  # noqa: A002 - the protocol's own word
        super().__init__(client, on_lift)
        self.filter = filter
        self.reason = reason


class RefusedPublish(RefusedSubscribe):
    """Messages on topics that match the filter are not forwarded, and answered with *reason*."""


_Kind = TypeVar("_Kind", bound=Fault)


@final
class FaultRules:
    """The faults in force.

    Args:
        on_lift: Called with each fault that is lifted, in the thread that lifts it.
    """

    def __init__(self, on_lift: Callable[[Fault], None]) -> None:
        self._faults: tuple[Fault, ...] = ()  # replaced as a whole: the broker's thread reads it at any time
        self._on_lift = on_lift

    def find(self, kind: type[_Kind], client: str | None) -> _Kind | None:
        """Return the first fault of exactly this kind that concerns *client*."""
        for fault in self._faults:
            if type(fault) is kind and fault.client in (None, client):
                return fault
        return None

    def subscribe_refusal(self, client: str, filter: str) -> RefusedSubscribe | None:  # noqa: A002 - the protocol's own word
        """Return the fault that refuses *client* a subscription."""
        for fault in self._faults:
            if type(fault) is RefusedSubscribe and fault.client in (None, client) and fault.filter == filter:
                return fault
        return None

    def publish_refusal(self, client: str, topic: str) -> RefusedPublish | None:
        """Return the fault that refuses a message of *client*."""
        for fault in self._faults:
            if (
                isinstance(fault, RefusedPublish)
                and fault.client in (None, client)
                and topic_matches(fault.filter, topic)
            ):
                return fault
        return None

    def add(self, kind: Callable[[Callable[[Fault], None]], Fault]) -> Fault:
        """Put in force the fault that *kind* makes of the call for its lifting."""
        fault = kind(self._lifted)
        self._faults = (*self._faults, fault)
        return fault

    def lift_all(self) -> None:
        """End every fault."""
        for fault in self._faults:
            fault.lift()

    def _lifted(self, fault: Fault) -> None:
        self._faults = tuple(each for each in self._faults if each is not fault)
        self._on_lift(fault)


@final
class FaultPolicy:
    """Fills the broker's :class:`BrokerPolicy` port from the faults in force."""

    def __init__(self, rules: FaultRules, otherwise: BrokerPolicy) -> None:
        self._rules = rules
        self._otherwise = otherwise

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002 - fills the port
        """Return the refusal reason of the fault, or the decision of the policy below."""
        return _apply_fault(self._rules.subscribe_refusal(client_id, filter)) or self._otherwise.subscribe(
            client_id, filter
        )

    def publish(self, client_id: str, topic: str) -> ReasonCode:
        """Return the refusal reason of the fault, or the decision of the policy below."""
        return _apply_fault(self._rules.publish_refusal(client_id, topic)) or self._otherwise.publish(client_id, topic)


def _apply_fault(fault: RefusedSubscribe | None) -> ReasonCode:
    if fault is None:
        return ReasonCode.SUCCESS
    fault.hits += 1
    return fault.reason
