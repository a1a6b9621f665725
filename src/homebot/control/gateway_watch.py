"""News of gateways that matter to commands: reports and answers of devices, and connections that were lost."""

from __future__ import annotations

import math
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterable
from functools import partial
from typing import Final, TypeAlias, final

from homebot.control.pending import PendingCommand
from homebot.devices.device import Route
from homebot.devices.gateway_messages import CommandAnswer, GatewayState, Report
from homebot.devices.names import GatewayNames
from homebot.devices.value import PlainValue
from homebot.errors import InvalidNameError
from homebot.graph import DurabilityPolicy, Node, QoSProfile, Subscription

__all__ = ["GatewayWatch", "PartWatch", "ReportWatch", "TakeReading"]

TakeReading: TypeAlias = Callable[[str, PlainValue], None]
"""Takes the capability and the value of a live report."""

_Place: TypeAlias = tuple[str, str, str]
"""A gateway, and what it calls a device and its part."""

_QOS: Final = QoSProfile(depth=1000)
"""The newest report of each stream survives a flood, older ones may be lost: the newest decides."""

_STATE_QOS: Final = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MOST_KNOWN: Final = 10_000


@final
class PartWatch:
    """A watch of one part, until it is stopped.

    Attributes:
        take: Called with each live reading of the part; whoever goes on to watch the part may put his own here.
        places: Where it is found.
    """

    __slots__ = ("_watch", "places", "take")

    def __init__(self, watch: ReportWatch, take: TakeReading) -> None:
        self.take = take
        self.places: list[_Place] = []
        self._watch = watch

    def stop(self) -> None:
        """Take no more readings; not to be called twice."""
        self.take = _drop  # who takes them may hold this watch: the two would stay in memory
        self._watch.remove(self)


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
        watch = PartWatch(self, take)
        for one in routes:
            place = one.gateway, one.key, one.part
            watch.places.append(place)
            known = self._watchers.get(place)
            if known is not None:
                known.append(watch)
            else:
                self._watchers[place] = [watch]
                self._listen(one.gateway)
        return watch

    def remove(self, watch: PartWatch) -> None:
        """Hand no more readings to *watch*; called by it."""
        for place in watch.places:
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


@final
class GatewayWatch:
    """Hands each answer to its command, and knows which parts answer, the last 10,000, and who lost its connection.

    Args:
        node: The node that listens.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._pending: dict[str, PendingCommand] = {}
        self._subscriptions: dict[str, tuple[Subscription[CommandAnswer], Subscription[GatewayState]] | None] = {}
        self._answering: OrderedDict[_Place, None] = OrderedDict()
        self._lost_at: dict[str, float] = {}

    def expect(self, pending: PendingCommand) -> None:
        """Take the answers to a command; one to a part that answered before, and reports nothing, is waited for."""
        self._pending[pending.command.id] = pending
        for route in pending.command.part.routes:
            if route.gateway not in self._subscriptions:
                self._subscriptions[route.gateway] = self._listen(route.gateway)
            if self._answering and (route.gateway, route.key, route.part) in self._answering:
                pending.must_answer = True

    def forget(self, pending: PendingCommand) -> None:
        """Take no more answers to a command."""
        del self._pending[pending.command.id]

    def lost_at(self, routes: Iterable[Route]) -> float:
        """Return when a gateway of *routes* last lost its connection, on the monotonic clock; -inf for never."""
        return max([self._lost_at.get(route.gateway, -math.inf) for route in routes], default=-math.inf)

    def _listen(self, gateway: str) -> tuple[Subscription[CommandAnswer], Subscription[GatewayState]] | None:
        names, create = GatewayNames(gateway), self._node.create_subscription
        take, note = partial(self._take, gateway), partial(self._note_state, gateway)
        try:
            return (
                create(CommandAnswer, names.answers, take, _QOS, from_node=names.node),
                create(GatewayState, names.state, note, _STATE_QOS, from_node=names.node),
            )
        except InvalidNameError:
            return None  # nobody publishes under such a name

    def _take(self, gateway: str, answer: CommandAnswer) -> None:
        place = gateway, answer.key, answer.part
        self._answering[place] = None
        self._answering.move_to_end(place)
        if len(self._answering) > _MOST_KNOWN:
            self._answering.popitem(last=False)
        pending = self._pending.get(answer.command_id)
        if pending is not None:
            pending.take_answer(
                answer.capability, answer.message if not answer.success else "", self._clock.monotonic()
            )

    def _note_state(self, gateway: str, state: GatewayState) -> None:
        if state.state == "unavailable":
            self._lost_at[gateway] = self._clock.monotonic()


def _drop(_capability: str, _value: PlainValue) -> None:
    pass
