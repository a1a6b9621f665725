"""The recorder of a running homebot: of the whole run, and one at a time for clients."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Final, final

import anyio
from anyio.abc import TaskStatus

from homebot.feature_context import FeatureContext, RunObserver
from homebot.features.recording.recording_file import FileSink, LineSink, RecordingFile
from homebot.features.recording.session import record_for_client, record_into
from homebot.graph import Node
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.support.isolation import run_as

BUSY = "another client is recording; homebot makes one recording for clients at a time"

_MAX_START_S: Final = 10.0
_NAMESPACE: Final = "/homebot"


@final
class RecordingServer:
    """Starts a recorder for a client, one at a time."""

    def __init__(self, node: Node, house: FeatureContext) -> None:
        self._node, self._house = node, house
        self._is_busy = False

    def serve(self, name: str) -> None:
        """Create the service with this name; a recorder offers the other one."""
        self._node.create_service(Trigger, name, self._start)

    async def _start(self, _: TriggerRequest) -> SuccessResponse:
        if self._is_busy:
            return SuccessResponse(success=False, message=BUSY)
        self._is_busy = True
        ready = anyio.Event()
        self._node.create_task(partial(self._record, ready))
        with anyio.move_on_after(_MAX_START_S):
            await ready.wait()
        return SuccessResponse(success=ready.is_set(), message="" if ready.is_set() else "the recorder did not start")

    async def _record(self, ready: anyio.Event) -> None:
        try:
            facts = await self._house.run_facts()
            async with Node(self._house.graph, "recorder", namespace=_NAMESPACE) as node:
                await run_as(node.full_name, partial(record_for_client, node, facts, ready))
        finally:
            self._is_busy = False


@contextmanager
def record_into_file(file: str) -> Iterator[RunObserver]:
    """Record a run into a new file, which is closed after the block.

    Raises:
        UsageError: It cannot be written, or exists already.
    """
    with RecordingFile(Path(file)) as new:
        yield recorder_into(FileSink(new))


def recorder_into(sink: LineSink) -> RunObserver:
    """Return the observer that records a run into *sink*."""

    async def record(house: FeatureContext, *, task_status: TaskStatus[None]) -> None:
        facts = await house.run_facts()
        async with Node(house.graph, "file_recorder", namespace=_NAMESPACE) as node:
            await run_as(node.full_name, partial(record_into, node, facts, sink, task_status=task_status))

    return record
