"""``/homebot/start_recorder``: starts a recorder for a client, which then fetches the lines of the recording."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import TYPE_CHECKING

import anyio

from homebot.devices.names import START_RECORDER
from homebot.graph import Node
from homebot.messages.std_srvs import SuccessResponse, Trigger
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from homebot.runtime.run_recording import RunRecording

__all__ = ["RecorderStarter"]

BUSY = "another client records; homebot makes one recording at a time for a client"

_READY_WITHIN = 10.0


class RecorderStarter:
    """Starts one recorder at a time.

    Args:
        node: The node of the runtime, which runs the recorder's tasks.
    """

    def __init__(self, node: Node, recording: Callable[[], Awaitable[RunRecording]]) -> None:
        self._node = node
        self._recording = recording
        self._is_busy = False

    def offer(self) -> None:
        """Offer the service on the node."""
        self._node.create_service(Trigger, START_RECORDER, lambda _: self.start())

    async def start(self) -> SuccessResponse:
        """Start a recorder; the answer says why there is none."""
        if self._is_busy:
            return SuccessResponse(success=False, message=BUSY)
        self._is_busy = True
        ready = anyio.Event()
        self._node.create_task(partial(self._record, ready))
        with anyio.move_on_after(_READY_WITHIN):
            await ready.wait()
        return SuccessResponse(success=ready.is_set(), message="" if ready.is_set() else "the recorder did not start")

    async def _record(self, ready: anyio.Event) -> None:
        try:
            recording = await self._recording()
            async with Node(self._node.graph, "recorder", namespace=self._node.full_name) as node:
                await run_as(node.full_name, partial(recording.serve_client, node, ready))
        finally:
            self._is_busy = False
