"""A process started by a service manager: its notifications for systemd (sd_notify(3)), and its end."""

import os
import socket
import time
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager, suppress
from functools import partial
from typing import final

import anyio

from homebot.devices import GatewayNames, GatewayState
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.support.logger import get_logger

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
    """The *gateways* that were never active, and why.

    Args:
        is_service: Whether one of them must become active within five minutes.
    """

    def __init__(self, graph: Graph, gateways: Iterable[str], *, is_service: bool) -> None:
        self.is_missing = False
        self._graph = graph
        self._missing = dict.fromkeys(gateways, "it has not answered yet")
        self._limit = CONNECTS_WITHIN if is_service and self._missing else None
        self._connected = anyio.Event()

    @asynccontextmanager
    async def watched(self, service: AbstractAsyncContextManager[None]) -> AsyncIterator[None]:
        """Enter *service*, and note the states of its gateways from the first one on."""
        async with Node(self._graph, "first_connection", namespace="/homebot") as node:
            for name in self._missing:
                topic = GatewayNames(name).state
                node.create_subscription(GatewayState, topic, partial(self._record, name), qos_profile_latched)
            async with service:
                yield

    async def wait_in_vain(self) -> None:
        """Return if no gateway of a service became active in time; otherwise wait forever."""
        with anyio.move_on_after(self._limit):
            await self._connected.wait()
        if self._connected.is_set():
            await anyio.sleep_forever()
        self.is_missing = True
        minutes = f"{CONNECTS_WITHIN / 60:g} minutes"
        _log.critical(
            NEVER_CONNECTED,
            message=f"no gateway was connected within {minutes} ({', '.join(self._missing)}); "
            "the service ends, so that it is restarted; homebot doctor --offline --reach looks for the cause",
        )

    def log_missing(self, seconds: float | None) -> None:
        """Log which gateways were not connected once in *seconds*, if any."""
        self.is_missing = bool(self._missing)
        if self.is_missing:
            reasons = "; ".join(f"gateway {name}: {reason}" for name, reason in self._missing.items())
            _log.critical(NEVER_CONNECTED, message=f"never connected in {seconds:g} s: {reasons}")

    def _record(self, name: str, state: GatewayState) -> None:
        if state.state == "active":
            self._missing.pop(name, None)
            self._connected.set()
        elif name in self._missing:
            self._missing[name] = state.reason
