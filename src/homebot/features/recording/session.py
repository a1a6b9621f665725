"""Recording in a running homebot: into a file, or for a client that fetches the lines through a service."""

from typing import Final, final

import anyio
from anyio.abc import TaskStatus

from homebot.features.recording import READ_RECORDING
from homebot.features.recording.recorder import Recorder
from homebot.features.recording.recording_file import LineSink
from homebot.graph import Node
from homebot.messages.message import Message, ServiceType
from homebot.recording.lines import RecordingHeader

FAILED = "recording.failed"
FULL = "recording.file_full"

_EVERY: Final = 1.0
_UNREAD: Final = 10.0
"""Seconds after which a client that fetches nothing is considered gone: a slow disk may delay it for a while."""

_MAX_LINES: Final = 2_000
_MAX_BYTES: Final = 2 * 1024 * 1024


class ReadRecordingRequest(Message):
    """Request for the next lines; waits up to a second for some.

    Attributes:
        is_last: Whether to end the recording; repeat the request until it is over.
    """

    is_last: bool = False


class ReadRecordingResponse(Message):
    """Lines, which the recorder then forgets.

    Attributes:
        lines: The lines, in order, without line breaks.
        is_over: Whether these were the last.
    """

    lines: tuple[str, ...] = ()
    is_over: bool = False


ReadRecording = ServiceType("homebot/srv/ReadRecording", ReadRecordingRequest, ReadRecordingResponse)


async def record_into(
    node: Node, header: RecordingHeader, sink: LineSink, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED
) -> None:
    """Record into *sink*, once a second, until cancelled or the sink is full."""
    recorder = Recorder(node, header)
    try:
        async with anyio.create_task_group() as tasks:
            await tasks.start(recorder.run)
            task_status.started()
            await _write_all(node, recorder, sink)
            tasks.cancel_scope.cancel()
    finally:
        recorder.finish()
        with anyio.CancelScope(shield=True):
            await _write(node, recorder, sink)


async def record_for_client(node: Node, header: RecordingHeader, ready: anyio.Event) -> None:
    """Record for a client that fetches the lines, until it is done, leaves, or fetches nothing for ten seconds."""
    recorder = Recorder(node, header)
    async with anyio.create_task_group() as tasks:
        await tasks.start(recorder.run)
        reader = _LineReader(node, recorder)
        node.create_service(ReadRecording, READ_RECORDING.name, reader.read, cancel_with_caller=True)
        ready.set()
        await reader.run()
        tasks.cancel_scope.cancel()


@final
class _LineReader:
    def __init__(self, node: Node, recorder: Recorder) -> None:
        self._clock = node.graph.clock
        self._recorder = recorder
        self._read_at = self._clock.monotonic()
        self._is_finished = False
        self._is_over = anyio.Event()

    async def run(self) -> None:
        """Return when the client is done, or gone."""
        while (left := self._read_at + _UNREAD - self._clock.monotonic()) > 0 and not self._is_over.is_set():
            with anyio.move_on_after(left):
                await self._is_over.wait()

    async def read(self, request: ReadRecordingRequest) -> ReadRecordingResponse:
        """Answer the service."""
        recorder = self._recorder
        self._read_at = self._clock.monotonic()
        recorder.record_lost()
        if request.is_last and not self._is_finished:
            self._is_finished = True
            recorder.finish()
        elif recorder.lines.is_empty:
            try:
                await anyio.sleep(_EVERY)
            except anyio.get_cancelled_exc_class():  # the client has left
                self._is_over.set()
                raise
        lines = tuple(recorder.lines.pop(_MAX_LINES, _MAX_BYTES))
        is_over = self._is_finished and recorder.lines.is_empty
        if is_over:
            self._is_over.set()
        return ReadRecordingResponse(lines=lines, is_over=is_over)


async def _write_all(node: Node, recorder: Recorder, sink: LineSink) -> None:
    while await _write(node, recorder, sink):
        if sink.is_full:
            node.log.warning(FULL, message="the recording ended: its file is full")
            return
        await recorder.lines.wait()
        await anyio.sleep(_EVERY)


async def _write(node: Node, recorder: Recorder, sink: LineSink) -> bool:
    recorder.record_lost()
    try:
        await sink.write(recorder.lines.pop())
    except OSError as exc:
        node.log.error(FAILED, message=f"the recording ended: its file cannot be written: {exc.strerror}")
        return False
    return True
