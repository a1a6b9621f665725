"""Reports of the parts that commands are about, taken from the gateways only while somebody waits for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias, final

from homebot.devices import GatewayNames, Route
from homebot.devices.gateway_messages import Report
from homebot.devices.value import PlainValue
from homebot.errors import InvalidNameError
from homebot.graph import Node, QoSProfile, Subscription

__all__ = ["ReportWatch", "TakeReading"]

TakeReading: TypeAlias = Callable[[str, PlainValue], None]
"""Takes the capability and the value of a live report."""

_Place: TypeAlias = tuple[str, str, str]

_QOS = QoSProfile(depth=1000)
"""The newest report of each stream survives a flood, older ones may be lost: the newest decides."""


@final
class ReportWatch:
    """Hands each live reading to who watches the part, by whichever route it comes.

    Args:
        node: The node that listens.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._watchers: dict[_Place, list[TakeReading]] = {}
        self._subscriptions: dict[str, Subscription[Report]] = {}
        self._users: dict[str, int] = {}

    def watch(self, routes: Iterable[Route], take: TakeReading) -> Callable[[], None]:
        """Call *take* with each live reading that comes by one of *routes*; return the function to stop."""
        places = [(one.gateway, one.key, one.part) for one in routes]
        for place in places:
            self._watchers.setdefault(place, []).append(take)
            self._listen(place[0])

        def stop() -> None:
            for place in places:
                found = self._watchers[place]
                found.remove(take)
                if not found:
                    del self._watchers[place]
                self._release(place[0])

        return stop

    def _listen(self, gateway: str) -> None:
        self._users[gateway] = self._users.get(gateway, 0) + 1
        if gateway in self._subscriptions:
            return
        names = GatewayNames(gateway)
        try:
            self._subscriptions[gateway] = self._node.create_subscription(
                Report, names.readings, self._take, _QOS, from_node=names.node
            )
        except InvalidNameError:
            return  # nobody reports under such a name

    def _release(self, gateway: str) -> None:
        self._users[gateway] -= 1
        if not self._users[gateway]:
            del self._users[gateway]
            subscription = self._subscriptions.pop(gateway, None)
            if subscription is not None:
                subscription.close()

    def _take(self, report: Report) -> None:
        if report.retained:
            return
        for reading in report.readings:
            for take in tuple(self._watchers.get((report.gateway, report.key, reading.part), ())):
                take(reading.capability, reading.value.plain())
