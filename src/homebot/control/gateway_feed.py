"""Messages of gateways that control needs: live reports, answers to commands, and lost connections."""

import math
from collections.abc import AsyncIterator, Callable, Iterable
from functools import partial
from typing import Final, NamedTuple, TypeAlias, final

from homebot.devices.device import Route
from homebot.devices.gateway_messages import REACHABLE, CommandAnswer, GatewayState, Report
from homebot.devices.names import GatewayNames, gateway_of
from homebot.devices.value import PlainValue, SetBy
from homebot.errors import InvalidNameError
from homebot.graph import DurabilityPolicy, EntityKind, Graph, Node, QoSProfile
from homebot.messages import Time
from homebot.support.bounded_map import BoundedMap

OnReport: TypeAlias = Callable[[str, PlainValue, float, SetBy], None]
"""Called with capability and value of a live report, its time since the Unix epoch, and who set it, if known."""

_Place: TypeAlias = tuple[str, str, str]
"""A gateway, and its names of a device and of a part."""

_QOS: Final = QoSProfile(depth=1000)
"""In a flood older reports of a stream may be lost, but never the newest, which decides."""

_STATE_QOS: Final = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MAX_ROUTES: Final = 10_000


class LinkLoss(NamedTuple):
    """The last loss of a connection, on the monotonic clock and in seconds since the Unix epoch; -inf for never."""

    monotonic: float = -math.inf
    wall: float = -math.inf


_NEVER: Final = LinkLoss()


def places_of(routes: Iterable[Route]) -> list[_Place]:
    """Return where the gateways of *routes* report."""
    return [(route.gateway, route.key, route.part) for route in routes]


@final
class GatewayFeed:
    """The one subscription to the reports, answers and states of each gateway.

    Attributes:
        began_at: The time before any device was heard, in seconds since the Unix epoch, rounded as in messages.
        losses: The last loss of each gateway that has lost its connection.
        on_gateway: Called with the name of each gateway.
        on_answer: Called with the id of a command, a capability, and the problem, empty for none.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = node.graph.clock
        self.began_at = Time.from_seconds(self._clock.now()).to_seconds()
        self._watches: dict[_Place, list[OnReport]] = {}
        self._states: set[str] = set()
        self._reports: set[str] = set()
        self._answering: BoundedMap[_Place, None] = BoundedMap(_MAX_ROUTES)
        self._absences: BoundedMap[_Place, float] = BoundedMap(_MAX_ROUTES)
        self.losses: dict[str, LinkLoss] = {}
        self.on_gateway: Callable[[str], None] = lambda _: None
        self.on_answer: Callable[[str, str, str], None] = lambda *_: None

    async def run(self) -> None:
        """Follow the states of all present and future gateways until cancelled."""
        async for gateway in watch_gateways(self._node.graph):
            self._follow_state(gateway)

    def watch(self, routes: Iterable[Route], on_report: OnReport) -> Callable[[], None]:
        """Call *on_report* with each live report by one of *routes*; return the function that stops it, once."""
        places = places_of(routes)
        for place in places:
            self._watches.setdefault(place, []).append(on_report)
            self._follow_reports(place[0])
        return partial(self._unwatch, places, on_report)

    def _unwatch(self, places: list[_Place], on_report: OnReport) -> None:
        for place in places:
            watches = self._watches[place]
            watches.remove(on_report)
            if not watches:
                del self._watches[place]

    def last_loss(self, routes: Iterable[Route]) -> LinkLoss:
        """Return when a gateway of *routes* last lost its connection."""
        if not self.losses:
            return _NEVER
        return max([self.losses.get(route.gateway, _NEVER) for route in routes], default=_NEVER)

    def last_absence(self, routes: Iterable[Route]) -> float:
        """Return when a device or part on one of *routes* was last unreachable, on the monotonic clock."""
        if not self._absences:
            return -math.inf
        places = [(route.gateway, route.key, part) for route in routes for part in ("", route.part)]
        return max([self._absences.get(place, -math.inf) for place in places], default=-math.inf)

    def is_answering(self, routes: Iterable[Route]) -> bool:
        """Return whether a device ever answered a command by one of *routes*; the last 10,000 routes are remembered."""
        return bool(self._answering) and any(place in self._answering for place in places_of(routes))

    def _follow_state(self, gateway: str) -> None:
        if gateway in self._states:
            return
        self._states.add(gateway)
        names, on_state = GatewayNames(gateway), partial(self._on_state, gateway)
        self._node.create_subscription(GatewayState, names.state, on_state, _STATE_QOS, from_node=names.node)
        self.on_gateway(gateway)

    def _follow_reports(self, gateway: str) -> None:
        if gateway in self._reports:
            return
        self._reports.add(gateway)
        names, create = GatewayNames(gateway), self._node.create_subscription
        try:
            create(Report, names.readings, partial(self._on_report, gateway), _QOS, from_node=names.node)
            create(CommandAnswer, names.answers, partial(self._on_answer, gateway), _QOS, from_node=names.node)
        except InvalidNameError:
            return  # no node can have such a name
        self._follow_state(gateway)

    def _on_report(self, gateway: str, report: Report) -> None:
        if report.gateway != gateway:  # it may report only its own devices
            return
        for reading in report.readings:
            if reading.capability == REACHABLE and reading.value.plain() is False:
                self._absences[gateway, report.key, reading.part] = self._clock.monotonic()
        for reading in () if report.retained else report.readings:
            for on_report in tuple(self._watches.get((gateway, report.key, reading.part), ())):
                on_report(reading.capability, reading.value.plain(), report.received_at.to_seconds(), report.set_by)

    def _on_answer(self, gateway: str, answer: CommandAnswer) -> None:
        self._answering[gateway, answer.key, answer.part] = None
        self.on_answer(answer.command_id, answer.capability, answer.message if not answer.success else "")

    def _on_state(self, gateway: str, state: GatewayState) -> None:
        if state.state == "unavailable":
            self.losses[gateway] = LinkLoss(self._clock.monotonic(), self._clock.now())


async def watch_gateways(graph: Graph) -> AsyncIterator[str]:
    """Yield the name of each gateway, and again when it starts again. Read it to its end, in one task."""
    with graph.watch() as changes:
        nodes, lost = tuple(graph.get_node_names()), 0
        while True:
            for gateway in filter(None, map(gateway_of, nodes)):
                yield gateway
            change = await changes.receive()
            is_node = change.change == "added" and change.entity.kind is EntityKind.NODE
            nodes = (change.entity.name,) if is_node else ()
            if changes.lost > lost:
                nodes, lost = tuple(graph.get_node_names()), changes.lost
