"""A look at the topics that nothing here reads: programs that publish there do not announce themselves."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any, Final, final

import anyio

from homebot.errors import HomebotError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.options import MqttOptions

__all__ = ["UnreadTopics"]

LISTENS_FOR: Final = 60.0
LISTENS_EVERY: Final = 3600.0
_ENDS_WITHIN: Final = 1.0
_LIMITS: Final = {"maximum_packet_size": 64 * 1024, "inbox_messages": 1_000, "session_expiry": 0}
"""Limits of the client: the broker leaves out large messages, such as pictures."""

_BUSY, _MOST_SHOWN = 3, 5


@final
class UnreadTopics:
    """Listens to everything on a broker for a minute, after the start and each hour, with a client of its own.

    Another subscription of the gateway's own client would bring messages twice. A broker of MQTT 3.1.1 would send all
    its retained messages, and is not listened to.

    Args:
        is_read: Returns whether a topic is read.
        used: Returns all topics and filters that are read or commanded.
        announced: The filters of announcements.
        most_messages: Messages after which a look ends early.
        most_topics: Topics that one look counts; messages on further ones are left out.
    """

    def __init__(
        self,
        make_client: Callable[[MqttOptions], MqttClient],
        options: MqttOptions,
        is_read: Callable[[str], object],
        used: Callable[[], Iterable[str]],
        announced: Iterable[str],
        most_messages: int = 5_000,
        most_topics: int = 2_000,
    ) -> None:
        own: dict[str, Any] = {"client_id": f"{options.client_id[:200]}-look", **_LIMITS}
        self._client = make_client(replace(options, **own))
        self._is_read = is_read
        self._used = used
        self._most_messages, self._most_topics = most_messages, most_topics
        self._programs = {"homebot", *(one.partition("/")[0] for one in announced)}
        self._counts: Counter[str] = Counter()
        self._look = anyio.CancelScope()
        self._is_over = anyio.Event()
        self._is_over.set()

    async def end(self) -> None:
        """End a look that goes on: to the broker, it is a client that may receive every command."""
        self._look.cancel()
        with anyio.move_on_after(_ENDS_WITHIN):
            await self._is_over.wait()

    async def serve(self) -> None:
        """Listen at intervals until cancelled; a broker that refuses is asked again after the next one."""
        while True:
            with suppress(HomebotError):
                await self._listen()
            await anyio.sleep(LISTENS_EVERY)

    def notes(self) -> Iterator[str]:
        """Yield a note on the busiest topics of the last look that nothing reads, by their first levels."""
        levels = {level for one in self._used() for level in _levels(one)}
        groups: Counter[str] = Counter()
        for topic, count in self._counts.items():
            first, second = _levels(topic)
            if first not in self._programs and second not in levels and not self._is_read(topic):
                groups[second if first in levels else first] += count
        busy = [(group, count) for group, count in groups.most_common() if count >= _BUSY]
        if busy:
            shown = ", ".join(f"{group[:100]} ({count})" for group, count in busy[:_MOST_SHOWN])
            more = f" and {len(busy) - _MOST_SHOWN} more" if len(busy) > _MOST_SHOWN else ""
            yield (
                f"nothing here reads the topics that begin with {shown}{more}, counted for a minute: programs publish "
                "there that announce no devices, or under a prefix that is not configured (docs/conventions.md)"
            )

    async def _listen(self) -> None:
        async with self._client.connected() as grant:
            if grant.protocol != "5":
                return
            self._counts.clear()
            self._is_over = anyio.Event()
            try:
                with anyio.move_on_after(LISTENS_FOR) as self._look:
                    await self._client.subscribe(MqttSubscription("#", retain_handling=2))
                    await self._count()
                await self._client.unsubscribe("#")
            finally:
                self._is_over.set()

    async def _count(self) -> None:
        while self._counts.total() < self._most_messages:
            for topic in [one.topic for one in await self._client.receive()]:
                if topic in self._counts or len(self._counts) < self._most_topics:
                    self._counts[topic] += 1


def _levels(topic: str) -> tuple[str, str]:
    """Return the first level of *topic*, and the first two."""
    levels = topic.split("/", 2)
    return levels[0], "/".join(levels[:2])
