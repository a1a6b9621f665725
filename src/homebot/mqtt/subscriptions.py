"""The subscriptions that a connection should have on every link, and those that it has on the current one."""

from collections.abc import Callable, Iterable, Mapping
from typing import final

import anyio

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.filter_tree import has_wildcard

MAX_SUBSCRIPTIONS = 100
MAX_CHARACTERS = 16_384

_ROUND = 0.01
_BURST = 20
"""Messages within 10 ms that count as a burst: retained ones, sent as fast as the broker can."""
_MAX_ROUNDS = 100


@final
class SubscriptionSet:
    """The set of filters that are wanted, made and refused.

    Args:
        is_paced: Whether a request is for at most 100 retained messages, and the next one waits until a burst of them
            ends. A filter with a wildcard, or of QoS 1 or 2, is requested alone until it is known how many it brings.
    """

    def __init__(self, client: MqttClient, *, is_paced: bool = True) -> None:
        self._client = client
        self._is_paced = is_paced
        self._wanted: dict[str, MqttSubscription] = {}
        self._renewed: set[str] = set()
        self._made: set[str] = set()
        self._refused: dict[str, str] = {}
        self._unwanted: dict[str, None] = {}
        self._brought: dict[str, int] = {}
        self._bursts_end = True

    @property
    def refused(self) -> Mapping[str, str]:
        """The reasons by refused filter of the current link; a copy."""
        return dict(self._refused)

    @property
    def is_complete(self) -> bool:
        """True if the broker has all wanted subscriptions."""
        return self._wanted.keys() <= self._made

    def want(self, subscriptions: Iterable[MqttSubscription], *, every_link: bool) -> None:
        """Add *subscriptions*, each replacing an earlier one to the same filter.

        Args:
            every_link: Whether to make them again on each link, even if the broker still has them.
        """
        for subscription in subscriptions:
            self._wanted[subscription.filter] = subscription
            self._made.discard(subscription.filter)
            self._unwanted.pop(subscription.filter, None)
            if every_link:
                self._renewed.add(subscription.filter)
            else:
                self._renewed.discard(subscription.filter)

    def drop(self, filters: Iterable[str]) -> None:
        """Remove *filters*."""
        for name in filters:
            self._wanted.pop(name, None)
            self._renewed.discard(name)
            self._made.discard(name)
            self._refused.pop(name, None)
            self._brought.pop(name, None)
            self._unwanted[name] = None

    def link_ended(self) -> None:
        """Forget the refusals of a lost link."""
        self._refused.clear()

    def begin_link(self, *, resumed: bool) -> None:
        """Begin a link; the broker still has the subscriptions of a resumed session."""
        self._bursts_end = True
        if not resumed:
            self._made.clear()

    async def make_all(self) -> dict[str, RefusedError]:
        """Subscribe on a new link, first to quiet filters, and unsubscribe surplus filters; return the refused."""
        due = [one for name, one in self._wanted.items() if name not in self._made or name in self._renewed]
        refused = await self.make(one.filter for one in sorted(due, key=self._expected))
        if self._unwanted:
            await self.unsubscribe_from(tuple(self._unwanted))
        return refused

    async def make(self, names: Iterable[str]) -> dict[str, RefusedError]:
        """Subscribe to the wanted filters among *names*; return the refused ones; see also `batches`."""
        refused: dict[str, RefusedError] = {}
        for batch in batches(filter(None, map(self._wanted.get, names)), self._expected):
            try:
                await self._subscribe(*batch)
            except RefusedError as error:
                if len(batch) == 1:
                    refused[batch[0].filter] = error
                    self._refused[batch[0].filter] = error.reason
                    self._brought[batch[0].filter] = MAX_SUBSCRIPTIONS  # not to refuse others along with it again
                else:  # a refusal concerns one filter
                    for subscription in batch:
                        refused |= await self.make([subscription.filter])
            else:
                for subscription in batch:
                    self._made.add(subscription.filter)
                    self._refused.pop(subscription.filter, None)
        return refused

    async def unsubscribe_from(self, filters: tuple[str, ...]) -> None:
        """Unsubscribe from *filters*."""
        await self._client.unsubscribe(*filters)
        for name in filters:
            self._unwanted.pop(name, None)

    async def _subscribe(self, *batch: MqttSubscription) -> None:
        """Subscribe, repeating it if there is no answer, and wait for the retained messages.

        Some brokers, such as Mosquitto 2.0, drop packets that a client reads too slowly: QoS 0 messages, and even the
        answer to its next request.
        """
        counters = self._client.counters
        before, retained = counters.received, counters.retained
        try:
            await self._client.subscribe(*batch)
        except LinkError:
            await self._client.subscribe(*batch)  # raises at once where the link is gone
        if not self._is_paced:
            return
        if any(subscription.qos == 0 for subscription in batch) and self._bursts_end:
            self._bursts_end = await self._wait_for_end(before)
        brought = counters.retained - retained
        if len(batch) == 1 and batch[0].filter in self._wanted:
            self._brought[batch[0].filter] = brought
        elif brought > 2 * MAX_SUBSCRIPTIONS:
            for subscription in batch:  # one of them brings more than it did
                self._brought.pop(subscription.filter, None)

    async def _wait_for_end(self, before: int) -> bool:
        """Wait for at most a second until a burst of messages ends; return whether it did."""
        for _ in range(_MAX_ROUNDS):
            now = self._client.counters.received
            if now - before < _BURST:
                return True
            before = now
            await anyio.sleep(_ROUND)
        return False

    def _expected(self, subscription: MqttSubscription) -> int:
        """Return how many retained messages it brings, at least 1; a full request for unknown."""
        is_unknown = self._is_paced and (subscription.qos > 0 or has_wildcard(subscription.filter))
        return max(1, self._brought.get(subscription.filter, MAX_SUBSCRIPTIONS if is_unknown else 1))


def batches(
    subscriptions: Iterable[MqttSubscription], expected: Callable[[MqttSubscription], int]
) -> list[tuple[MqttSubscription, ...]]:
    """Return *subscriptions* in order, grouped into requests of at most 100 filters and retained messages.

    Args:
        expected: Returns how many retained messages a subscription brings, at least 1.
    """
    groups: list[list[MqttSubscription]] = []
    room = characters = 0
    for subscription in subscriptions:
        messages = expected(subscription)
        if messages > room or len(subscription.filter) > characters:
            groups.append([])
            room, characters = MAX_SUBSCRIPTIONS, MAX_CHARACTERS
        groups[-1].append(subscription)
        room -= messages
        characters -= len(subscription.filter)
    return list(map(tuple, groups))
