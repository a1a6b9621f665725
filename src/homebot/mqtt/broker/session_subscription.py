"""A subscription of a session: one filter with its options. No I/O."""

from typing import NamedTuple, Self

from homebot.mqtt.packets import MqttSubscription
from homebot.mqtt.topics import parse_shared_filter


class SessionSubscription(NamedTuple):
    """A filter with its options.

    Attributes:
        name: The filter as given, with ``$share/GROUP/``; the key for unsubscribing.
        identifier: The subscription identifier; 0 is none.
        share: Group and filter of a shared subscription, else None.
    """

    name: str
    filter: str
    qos: int
    no_local: bool = False
    retain_as_published: bool = False
    identifier: int = 0
    share: tuple[str, str] | None = None

    @classmethod
    def of(cls, request: MqttSubscription, identifier: int = 0) -> Self:
        """Make it from one filter of a SUBSCRIBE packet."""
        shared = parse_shared_filter(request.filter)
        return cls(
            request.filter,
            request.filter if shared is None else shared.filter,
            request.qos,
            request.no_local,
            request.retain_as_published,
            identifier,
            None if shared is None else (shared.group, shared.filter),
        )

    @property
    def levels(self) -> list[str]:
        """The filter's levels."""
        return self.filter.split("/")
