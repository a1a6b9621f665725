"""A process started by a service manager: its notifications for systemd (sd_notify(3)), and its end."""

import os
import socket
import time
from collections.abc import AsyncIterator, Collection, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import final

import anyio

from homebot.devices import GatewayNames, GatewayState
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.support.logger import get_logger

__all__ = ["CONNECTS_WITHIN", "FirstConnection", "ServiceManager", "service_manager"]


NEVER_CONNECTED = "runtime.never_connected"
CONNECTS_WITHIN = 300.0
"""Seconds within which a gateway must become active; after a power cut a router takes two minutes."""

_log = get_logger(node="/homebot")


class ServiceManager:
    """The service manager; without one, notifications are dropped.

    Args:
        path: Its socket, as in ``NOTIFY_SOCKET``; one that begins with ``@`` is abstract.
    """

    def __init__(self, path: str) -> None:
        self._address = "\0" + path[1:] if path[:1] == "@" else path if path[:1] == "/" else ""

    def notify(self, *lines: str) -> None:
        """Send *lines*; a service manager that does not listen is ignored."""
        if not self._address:
            return
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as connection:
            connection.settimeout(0)
            connection.connect(self._address)
            connection.send("\n".join(lines).encode())

    @contextmanager
    def reloading(self) -> Iterator[None]:
        """Report that the process reloads during the block."""
        self.notify("RELOADING=1", f"MONOTONIC_USEC={time.monotonic_ns() // 1000}")
        try:
            yield
        finally:
            self.notify("READY=1")

    async def keep_alive(self) -> None:
        """Report from the event loop, every third of the time limit, that it is not blocked."""
        limit = os.environ.get("WATCHDOG_USEC", "")
        while limit.isdigit() and int(limit):
            self.notify("WATCHDOG=1")
            await anyio.sleep(int(limit) / 3_000_000)


@asynccontextmanager
async def service_manager() -> AsyncIterator[ServiceManager]:
    """Report that the process is ready, that it is alive during the block, and that it stops afterwards."""
    manager = ServiceManager(os.environ.get("NOTIFY_SOCKET", ""))
    manager.notify("READY=1")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(manager.keep_alive)
        yield manager
        manager.notify("STOPPING=1")
        tasks.cancel_scope.cancel()


@final
class FirstConnection:
    """Waits until one of the *gateways* is active."""

    def __init__(self, graph: Graph, gateways: Collection[str]) -> None:
        self.is_missing = False
        self._graph = graph
        self._gateways = gateways

    async def wait_in_vain(self) -> None:
        """Return if no gateway became active in time; otherwise, or without gateways, wait forever."""
        if self._gateways and not await self._is_made():
            self.is_missing = True
            minutes = f"{CONNECTS_WITHIN / 60:g} minutes"
            _log.critical(
                NEVER_CONNECTED,
                message=f"no gateway was connected within {minutes} ({', '.join(self._gateways)}); "
                "the service ends, so that it is restarted; homebot doctor --offline --reach looks for the cause",
            )
            return
        await anyio.sleep_forever()

    async def _is_made(self) -> bool:
        connected = anyio.Event()

        def check(state: GatewayState) -> None:
            if state.state == "active":
                connected.set()

        async with Node(self._graph, "first_connection", namespace="/homebot") as node:
            for name in self._gateways:
                node.create_subscription(GatewayState, GatewayNames(name).state, check, qos_profile_latched)
            with anyio.move_on_after(CONNECTS_WITHIN):
                await connected.wait()
        return connected.is_set()
