"""The base of gateways that reach all their devices by one link: to a server, a hub, a directory."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.errors import LinkError, PeerError, UsageError, WireError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway
from homebot.gateways.context import GatewayContext
from homebot.graph import Node
from homebot.support.backoff import LINK_BACKOFF, REFUSED_BACKOFF, WRONG_ANSWER_BACKOFF, BackoffCounter

__all__ = ["LinkedGateway"]

STEADY_AFTER: Final = 60.0
"""Seconds after which a link that is lost counts as a first failure."""


class LinkedGateway(Gateway):
    """A gateway with one link, which it makes again and again.

    Attributes:
        devices: Its devices.
        problem: The reason why there is no link; empty while there is one.
    """

    devices: PublishedDevices

    def __init__(self, node: Node, settings: BaseModel, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self.problem = "not connected yet"
        self._retries = BackoffCounter(node.graph.clock, self.random, STEADY_AFTER)

    async def keep_link(self, connect: Callable[[], Awaitable[None]], task_status: TaskStatus[None]) -> None:
        """Call *connect* until cancelled, with pauses; the gateway is ready after its first link or failure.

        Args:
            connect: Makes the link, calls :meth:`on_link`, and works until it is lost. Raises LinkError, PeerError or
                UsageError.
        """
        while True:
            self._retries.begin()
            backoff, self.problem = LINK_BACKOFF, self.problem or "the connection was closed"
            try:
                await connect()
            except LinkError as exc:
                self.problem = str(exc)
            except WireError as exc:
                backoff, self.problem = WRONG_ANSWER_BACKOFF, str(exc)
            except (PeerError, UsageError) as exc:
                backoff, self.problem = REFUSED_BACKOFF, str(exc)
            self.publish_state("unavailable", self.problem)
            self.mark_ready(task_status)
            await self.devices.on_link_loss()
            await anyio.sleep(self._retries.fail(backoff))

    def on_link(self, task_status: TaskStatus[None]) -> None:
        """Record that the link works."""
        self.problem = ""
        self._retries.begin()
        self.publish_state("active")
        self.mark_ready(task_status)
