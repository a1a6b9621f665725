"""Port that decides who may publish and subscribe what; a fault injector or an access list can fill it."""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol, final

from homebot.errors import UsageError
from homebot.mqtt.packets import ReasonCode

__all__ = ["BrokerPolicy", "RefusedFilters", "policy_of"]


class BrokerPolicy(Protocol):
    """Answers for each request of a logged-in client."""

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002 - the protocol's own word
        """Success, or the failure that SUBACK is to carry for *filter* (``$share/GROUP/`` included)."""
        ...

    def publish(self, client_id: str, topic: str) -> ReasonCode:
        """Success, or the failure that PUBACK or PUBREC is to carry; before MQTT 5 the message just vanishes."""
        ...


@final
class RefusedFilters:
    """Refuses subscriptions to some filters, as written, with 0x80, as an access list would."""

    def __init__(self, filters: Collection[str] = ()) -> None:
        self._filters = frozenset(filters)

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002, ARG002 - fills the port
        """0x80 for the refused filters."""
        return ReasonCode.UNSPECIFIED_ERROR if filter in self._filters else ReasonCode.SUCCESS

    def publish(self, client_id: str, topic: str) -> ReasonCode:  # noqa: ARG002 - fills the port
        """Always success."""
        return ReasonCode.SUCCESS


def policy_of(policy: BrokerPolicy | None, refuse_filters: Collection[str]) -> BrokerPolicy:
    """The policy a broker is given: itself, or as filters to refuse.

    Raises:
        UsageError: Both are given.
    """
    if policy is not None and refuse_filters:
        raise UsageError("give refuse_filters or policy, not both")
    return policy or RefusedFilters(refuse_filters)
