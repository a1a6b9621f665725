"""Notifications to the service manager that started the process, as systemd reads them: sd_notify(3)."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress

import anyio

__all__ = ["ServiceManager", "service_manager"]


class ServiceManager:
    """The service manager; without one, notifications go nowhere.

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
        """Report every third of the time limit, from the event loop, that it is not blocked."""
        limit = os.environ.get("WATCHDOG_USEC", "")
        while limit.isdigit() and int(limit):
            self.notify("WATCHDOG=1")
            await anyio.sleep(int(limit) / 3_000_000)


@asynccontextmanager
async def service_manager() -> AsyncIterator[ServiceManager]:
    """Report that the process is ready, is alive during the block, and stops after it."""
    manager = ServiceManager(os.environ.get("NOTIFY_SOCKET", ""))
    manager.notify("READY=1")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(manager.keep_alive)
        yield manager
        manager.notify("STOPPING=1")
        tasks.cancel_scope.cancel()
