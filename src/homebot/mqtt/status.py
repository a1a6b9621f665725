"""Status of a client on its broker: retained "online" and "offline"."""

from __future__ import annotations

from typing import Final, final

import anyio

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client import MqttClient
from homebot.support.logger import get_logger

__all__ = ["OFFLINE", "ONLINE", "StatusPublisher"]

ONLINE: Final = b"online"
OFFLINE: Final = b"offline"

_OFFLINE_WITHIN = 1.0
"""Seconds for the last "offline" at a clean close; the broker publishes it otherwise, as the will."""

_log = get_logger()


@final
class StatusPublisher:
    """Publishes the status of a client.

    Args:
        topic: Where; None for nowhere.
    """

    def __init__(self, client: MqttClient, topic: str | None, url: str) -> None:
        self.topic = topic
        self._client = client
        self._url = url

    async def publish(self, status: bytes) -> None:
        """Publish *status*; that the broker refuses is logged: being visible is a courtesy, and all else still works.

        Raises:
            LinkError: There is no link.
        """
        if self.topic is None:
            return
        try:
            await self._client.publish(self.topic, status, qos=1, retain=True)
        except RefusedError as error:
            _log.warning(
                "mqtt.status_refused",
                message=f"{self._url}: cannot publish the status of homebot: {error}",
                broker=self._url,
                reason=error.reason,
            )

    async def publish_offline(self) -> None:
        """Publish "offline" at a clean close, also where it was cancelled; without a link the will is published."""
        with anyio.CancelScope(shield=True), anyio.move_on_after(_OFFLINE_WITHIN):
            try:
                await self.publish(OFFLINE)
            except LinkError:
                return
