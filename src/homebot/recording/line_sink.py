"""Port through which the lines of a recording are written."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, final

from anyio import to_thread

from homebot.recording.recording_file import RecordingFile

__all__ = ["FileSink", "LineSink"]


class LineSink(Protocol):
    """Takes lines, and keeps the event loop waiting for nothing."""

    @property
    def is_full(self) -> bool:
        """True once it takes no more."""
        ...

    async def write(self, lines: Sequence[str]) -> None:
        """Write *lines*.

        Raises:
            OSError: They could not be written.
        """
        ...


@final
class FileSink:
    """Writes into a file, by a thread.

    Args:
        file: The file.
    """

    def __init__(self, file: RecordingFile) -> None:
        self._file = file

    @property
    def is_full(self) -> bool:
        """True once the file takes no more."""
        return self._file.is_full

    async def write(self, lines: Sequence[str]) -> None:
        """Write *lines*; see :class:`LineSink`."""
        await to_thread.run_sync(self._file.write, lines)
