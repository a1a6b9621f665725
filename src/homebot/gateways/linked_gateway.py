"""The base of gateways that reach all their devices by one link: to a server, a hub, a directory."""

from abc import abstractmethod
from typing import ClassVar, Final

import anyio
from anyio.abc import TaskStatus

from homebot.errors import LinkError, PeerError, UsageError, WireError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings
from homebot.graph import Node
from homebot.support.backoff import LINK_BACKOFF, REFUSED_BACKOFF, WRONG_ANSWER_BACKOFF, BackoffCounter
from homebot.support.isolation import run_as

STEADY_AFTER: Final = 60.0
"""Seconds after which a link that is lost counts as a first failure."""

CONFIRM_EVERY: Final = 60.0
"""Seconds between two confirmations of the devices that the peer reaches: it notices when one stops answering."""


class LinkedGateway(Gateway):
    """A gateway with one link, which it makes again and again.

    Attributes:
        peer: The name of the other end of the link.
        problem: The reason why there is no link; empty while there is one.
    """

    peer: ClassVar[str]
    devices: PublishedDevices

    def __init__(self, node: Node, settings: GatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self.problem = "not connected yet"
        self._retries = BackoffCounter(node.graph.clock, self.random, STEADY_AFTER)
        self._confirm_every = min(CONFIRM_EVERY, settings.stale_after / 3)
        self._task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED

    @abstractmethod
    async def connect(self) -> None:
        """Make the link, call :meth:`on_link`, and work until it is lost.

        Raises:
            LinkError: It cannot be made, or was lost.
            PeerError: The peer refuses homebot, or broke the rules of its protocol.
            UsageError: The settings are wrong.
        """

    async def maintain(self) -> None:
        """Do what is due before the devices are confirmed."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep a link until cancelled, with pauses after failures; ready after its first link or failure."""
        self._task_status = task_status
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(run_as, self.node.full_name, self._confirm_devices)
            while True:
                self._retries.begin()
                backoff = LINK_BACKOFF
                try:
                    await self.connect()
                    self.problem = "the connection was closed"
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

    def on_link(self) -> None:
        """Record that the link works."""
        self.problem = ""
        self._retries.begin()
        self.publish_state("active")
        self.mark_ready(self._task_status)

    def check_link(self) -> None:
        """Raise LinkError while there is no link."""
        if self.problem:
            raise LinkError(f"{self.peer} cannot be reached: {self.problem}")

    def on_invalid(self, payload: bytes, why: str) -> None:
        """Count an invalid message of the peer."""
        self.devices.reject(self.peer, payload, why)

    async def _confirm_devices(self) -> None:
        while True:
            await anyio.sleep(self._confirm_every)
            if not self.problem:
                await self.maintain()
                await self.devices.confirm(self.devices.keys, f"{self.peer} reaches it")
