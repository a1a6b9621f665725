"""News of gateways that matter to commands: answers of devices, and connections that were lost."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Iterable
from functools import partial
from typing import Final, TypeAlias, final

from homebot.control.pending import PendingCommand
from homebot.devices.device import Route
from homebot.devices.gateway_messages import CommandAnswer, GatewayState
from homebot.devices.names import GatewayNames
from homebot.errors import InvalidNameError
from homebot.graph import DurabilityPolicy, Node, QoSProfile, Subscription

__all__ = ["GatewayWatch"]

_QOS: Final = QoSProfile(depth=1000)
_STATE_QOS: Final = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MOST_KNOWN: Final = 10_000

_Place: TypeAlias = tuple[str, str, str]


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
