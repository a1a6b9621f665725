"""Reports of the parts that commands are about, taken from the gateways only while somebody waits for them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Final, TypeAlias, final

from homebot.devices import GatewayNames, Route
from homebot.devices.gateway_messages import Report
from homebot.devices.value import PlainValue
from homebot.errors import InvalidNameError
from homebot.graph import Node, QoSProfile, Subscription

__all__ = ["PartWatch", "ReportWatch", "TakeReading"]

TakeReading: TypeAlias = Callable[[str, PlainValue], None]
"""Takes the capability and the value of a live report."""

_Place: TypeAlias = tuple[str, str, str]

_QOS: Final = QoSProfile(depth=1000)
"""The newest report of each stream survives a flood, older ones may be lost: the newest decides."""


@final
class PartWatch:
    """A watch of one part, until it is stopped.

    Attributes:
        take: Called with each live reading of the part; whoever goes on to watch the part may put his own here.
    """

    __slots__ = ("_places", "_watch", "take")

    def __init__(self, watch: ReportWatch, places: list[_Place], take: TakeReading) -> None:
        self.take = take
        self._watch = watch
        self._places = places

    def stop(self) -> None:
        """Take no more readings; not to be called twice."""
        self.take = _drop  # who takes them may hold this watch: the two would stay in memory
        self._watch.remove(self, self._places)


@final
class ReportWatch:
    """Hands each live reading to who watches the part, by whichever route it comes.

    Args:
        node: The node that listens.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._watchers: dict[_Place, list[PartWatch]] = {}
        self._subscriptions: dict[str, Subscription[Report]] = {}
        self._places: Counter[str] = Counter()  # that are watched, of each gateway

    def watch(self, routes: Iterable[Route], take: TakeReading) -> PartWatch:
        """Call *take* with each live reading that comes by one of *routes*, until the watch is stopped."""
        places = [(one.gateway, one.key, one.part) for one in routes]
        watch = PartWatch(self, places, take)
        for place in places:
            known = self._watchers.get(place)
            if known is not None:
                known.append(watch)
            else:
                self._watchers[place] = [watch]
                self._listen(place[0])
        return watch

    def remove(self, watch: PartWatch, places: Iterable[_Place]) -> None:
        """Hand no more readings of *places* to *watch*; called by it."""
        for place in places:
            found = self._watchers[place]
            found.remove(watch)
            if not found:
                del self._watchers[place]
                self._release(place[0])

    def _listen(self, gateway: str) -> None:
        self._places[gateway] += 1
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
        self._places[gateway] -= 1
        if not self._places[gateway]:
            del self._places[gateway]
            subscription = self._subscriptions.pop(gateway, None)
            if subscription is not None:
                subscription.close()

    def _take(self, report: Report) -> None:
        if report.retained:
            return
        for reading in report.readings:
            for watch in tuple(self._watchers.get((report.gateway, report.key, reading.part), ())):
                watch.take(reading.capability, reading.value.plain())


def _drop(_capability: str, _value: PlainValue) -> None:
    pass
