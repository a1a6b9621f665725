"""The subscriptions that a connection should have on every link, and those that it has on the current one."""

from collections.abc import Iterable, Mapping
from typing import final

import anyio

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client import MqttClient, MqttSubscription

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
        is_paced: Whether retained messages are requested one filter at a time; see `MqttConnection`.
    """

    def __init__(self, client: MqttClient, *, is_paced: bool = True) -> None:
        self._client = client
        self._is_paced = is_paced
        self._wanted: dict[str, MqttSubscription] = {}
        self._renewed: set[str] = set()
        self._made: set[str] = set()
        self._refused: dict[str, str] = {}
        self._unwanted: dict[str, None] = {}
        self._bursts_end = True

    @property
    def refused(self) -> Mapping[str, str]:
        """The reasons by refused filter of the current link; a copy."""
        return dict(self._refused)

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
            self._unwanted[name] = None

    def link_ended(self) -> None:
        """Forget the refusals of a lost link."""
        self._refused.clear()

    async def begin_link(self, *, resumed: bool) -> dict[str, RefusedError]:
        """Subscribe missing filters on a new link and unsubscribe surplus ones; return the refused ones."""
        self._bursts_end = True
        if resumed:
            self._made -= self._renewed
        else:
            self._made.clear()
        refused = await self.make([name for name in self._wanted if name not in self._made])
        if self._unwanted:
            await self.unsubscribe_from(tuple(self._unwanted))
        return refused

    async def make(self, names: Iterable[str]) -> dict[str, RefusedError]:
        """Subscribe to the wanted filters among *names*; return the refused ones; see also `batches`."""
        refused: dict[str, RefusedError] = {}
        for batch in batches(filter(None, map(self._wanted.get, names)), is_paced=self._is_paced):
            try:
                await self._subscribe(*batch)
            except RefusedError as error:
                if len(batch) == 1:
                    refused[batch[0].filter] = error
                    self._refused[batch[0].filter] = error.reason
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
        before = counters.received
        try:
            await self._client.subscribe(*batch)
        except LinkError:
            await self._client.subscribe(*batch)  # raises at once where the link is gone
        if self._is_paced and batch[0].qos == 0:
            # for at most a second, until a burst of messages ends
            for _ in range(_MAX_ROUNDS if self._bursts_end else 0):
                now = counters.received
                if now - before < _BURST:
                    return
                before = now
                await anyio.sleep(_ROUND)
            self._bursts_end = False


def batches(subscriptions: Iterable[MqttSubscription], *, is_paced: bool) -> list[tuple[MqttSubscription, ...]]:
    """Return *subscriptions* in order, grouped into requests of at most 100.

    If *is_paced*, a filter with a wildcard, or of QoS 1 or 2, has its own request, because a broker sends all retained
    messages for it at once. The others have at most one retained message each.
    """
    groups: list[list[MqttSubscription]] = []
    room = characters = 0
    for subscription in subscriptions:
        is_single = is_paced and (subscription.qos > 0 or "+" in subscription.filter or "#" in subscription.filter)
        if not room or is_single or len(subscription.filter) > characters:
            groups.append([])
            room, characters = MAX_SUBSCRIPTIONS, MAX_CHARACTERS
        groups[-1].append(subscription)
        room = 0 if is_single else room - 1
        characters -= len(subscription.filter)
    return list(map(tuple, groups))
