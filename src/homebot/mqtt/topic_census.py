"""A count of all topics on a broker, for a minute after the start and each hour, by a client of its own."""

from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any, Final, final

import anyio

from homebot.errors import HomebotError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.options import MqttOptions

LISTENS_FOR: Final = 60.0
LISTENS_EVERY: Final = 3600.0
_ENDS_WITHIN: Final = 1.0
_LIMITS: Final = {"maximum_packet_size": 64 * 1024, "inbox_messages": 1_000, "session_expiry": 0}
"""Limits of the client: the broker leaves out large messages, such as pictures."""


@final
class TopicCensus:
    """Counts the messages on each topic.

    Another subscription of a client that is there would bring messages twice. A broker of MQTT 3.1.1 would send all its
    retained messages, and is not listened to.

    Args:
        most_messages: Messages after which a count ends early.
        most_topics: Topics that are counted; messages on further ones are left out.

    Attributes:
        counts: The messages of the last count by topic.
        is_counting: Whether a count goes on.
    """

    def __init__(
        self,
        make_client: Callable[[MqttOptions], MqttClient],
        options: MqttOptions,
        most_messages: int = 5_000,
        most_topics: int = 2_000,
    ) -> None:
        own: dict[str, Any] = {"client_id": f"{options.client_id[:200]}-look", **_LIMITS}
        self._client = make_client(replace(options, **own))
        self._most_messages, self._most_topics = most_messages, most_topics
        self.counts: Counter[str] = Counter()
        self.is_counting = False
        self._scope = anyio.CancelScope()
        self._is_over = anyio.Event()

    async def end(self) -> None:
        """End the count that goes on: to the broker, it is a client that may receive every message."""
        self._scope.cancel()
        with anyio.move_on_after(_ENDS_WITHIN):
            await self._is_over.wait()

    async def serve(self) -> None:
        """Count at intervals until cancelled; a broker that refuses is asked again after the next one."""
        while True:
            with suppress(HomebotError):
                await self._listen()
            await anyio.sleep(LISTENS_EVERY)

    async def _listen(self) -> None:
        async with self._client.connected() as grant:
            if grant.protocol != "5":
                return
            self.counts.clear()
            self._is_over, self.is_counting = anyio.Event(), True
            try:
                with anyio.move_on_after(LISTENS_FOR) as self._scope:
                    await self._client.subscribe(MqttSubscription("#", retain_handling=2))
                    await self._count()
                await self._client.unsubscribe("#")
            finally:
                self.is_counting = False
                self._is_over.set()

    async def _count(self) -> None:
        while self.counts.total() < self._most_messages:
            for topic in [message.topic for message in await self._client.receive()]:
                if topic in self.counts or len(self.counts) < self._most_topics:
                    self.counts[topic] += 1
