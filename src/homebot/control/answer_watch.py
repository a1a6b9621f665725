"""Answers of devices to commands, taken from the gateways whose protocols have them."""

from __future__ import annotations

from collections import OrderedDict
from functools import partial
from typing import Final, TypeAlias, final

from homebot.control.pending import PendingCommand
from homebot.devices.gateway_messages import CommandAnswer
from homebot.devices.names import GatewayNames
from homebot.errors import InvalidNameError
from homebot.graph import Node, QoSProfile, Subscription

__all__ = ["AnswerWatch"]

_QOS: Final = QoSProfile(depth=1000)
_MOST_KNOWN: Final = 10_000

_Place: TypeAlias = tuple[str, str, str]


@final
class AnswerWatch:
    """Hands each answer to its command, and knows which parts answer: the last 10,000.

    Args:
        node: The node that listens.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._pending: dict[str, PendingCommand] = {}
        self._subscriptions: dict[str, Subscription[CommandAnswer] | None] = {}
        self._answering: OrderedDict[_Place, None] = OrderedDict()

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

    def _listen(self, gateway: str) -> Subscription[CommandAnswer] | None:
        names = GatewayNames(gateway)
        take = partial(self._take, gateway)
        try:
            return self._node.create_subscription(CommandAnswer, names.answers, take, _QOS, from_node=names.node)
        except InvalidNameError:
            return None  # nobody answers under such a name

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
