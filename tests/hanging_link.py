"""A link over TCP that can hang: it stays connected, and nothing passes until it goes on."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import anyio
from anyio.abc import SocketStream
from tests.ports import reserve_port


class HangingLink:
    """Passes connections on to *port* of this computer; use :meth:`running`.

    Attributes:
        address: Its own address, as of a router of Zenoh.
    """

    def __init__(self, port: int) -> None:
        self._port, self._own_port = port, reserve_port()
        self.address = f"tcp/127.0.0.1:{self._own_port}"
        self._passes = anyio.Event()
        self._passes.set()

    def hang(self) -> None:
        """Let nothing pass from now on."""
        self._passes = anyio.Event()

    def go_on(self) -> None:
        """Let pass what waits, and what comes."""
        self._passes.set()

    @asynccontextmanager
    async def running(self) -> AsyncIterator[HangingLink]:
        """Listen inside the block."""
        listener = await anyio.create_tcp_listener(local_host="127.0.0.1", local_port=self._own_port)
        async with listener, anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, self._join)
            yield self
            tasks.cancel_scope.cancel()

    async def _join(self, near: SocketStream) -> None:
        async with near, await anyio.connect_tcp("127.0.0.1", self._port) as far, anyio.create_task_group() as tasks:
            tasks.start_soon(self._pass, near, far)
            await self._pass(far, near)
            tasks.cancel_scope.cancel()

    async def _pass(self, source: SocketStream, target: SocketStream) -> None:
        with suppress(anyio.EndOfStream, anyio.BrokenResourceError, anyio.ClosedResourceError):
            while True:
                data = await source.receive()
                await self._passes.wait()
                await target.send(data)
        await target.aclose()
