"""The file of a recording, and the interface for writing its lines."""

import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Final, Protocol, Self, cast, final

from anyio import to_thread

from homebot.recording.lines import LostLines, RecordingEnd, RecordingLine, line_text
from homebot.support.new_file import create_file, explain_create_error

DEFAULT_MEGABYTES: Final = 500.0

_END_BYTES: Final = 1024
"""Space reserved for the lines that say that the file is full."""

_MEGABYTE: Final = 1_000_000


@final
class RecordingFile:
    """A new file, readable by its owner only: it shows when people were at home.

    Lines beyond the limit are dropped; the last lines then state their number, and that the file is full. The limit is
    on the size of the text, before compression.

    Args:
        path: The file; compressed if the name ends in ``.gz``.

    Raises:
        UsageError: It cannot be written, or exists already.
    """

    def __init__(self, path: Path, megabytes: float = DEFAULT_MEGABYTES, *, force: bool = False) -> None:
        self.path = path
        self.lines = 0
        self.dropped = 0
        self._left = max(0, round(megabytes * _MEGABYTE) - _END_BYTES)
        self._is_full = False
        if force:
            with explain_create_error(path):
                path.unlink(missing_ok=True)  # a new file: the old one may be readable by others, or be a link
        file = create_file(path)
        self._file: IO[bytes] = cast("IO[bytes]", _OwningGzip(file)) if path.suffix == ".gz" else file

    @property
    def is_full(self) -> bool:
        """True once a line did not fit; no more are accepted."""
        return self._is_full

    def write(self, lines: Sequence[str]) -> None:
        """Write *lines*, and flush them to the operating system.

        Raises:
            OSError: The disk is full or missing.
        """
        fitting = list(lines) if not self._is_full else []
        size = sum(len(line) + 1 for line in fitting)
        while fitting and size > self._left:
            size -= len(fitting.pop()) + 1
            self._is_full = True
        self.dropped += len(lines) - len(fitting)
        self._left -= size
        self.lines += len(fitting)
        self._file.write("".join(f"{line}\n" for line in fitting).encode())
        self._file.flush()

    def close(self) -> None:
        """Write the end if the file is full, and close it; remove a file of a run that did not begin.

        Raises:
            OSError: The disk is full or missing.
        """
        with self._file:
            if self._is_full:
                ends = (LostLines(count=self.dropped), RecordingEnd(reason="the file is full"))
                self._file.write("".join(f"{line_text(RecordingLine(0.0, end))}\n" for end in ends).encode())
        if not self.lines:
            self.path.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class LineSink(Protocol):
    """Adds lines without blocking the event loop."""

    @property
    def is_full(self) -> bool:
        """True once it accepts no more."""

    async def write(self, lines: Sequence[str]) -> None:
        """Write *lines*.

        Raises:
            OSError: They could not be written.
        """


@final
class FileSink:
    """Writes to a file in a thread."""

    def __init__(self, file: RecordingFile) -> None:
        self._file = file

    @property
    def is_full(self) -> bool:
        """True once the file accepts no more."""
        return self._file.is_full

    async def write(self, lines: Sequence[str]) -> None:
        """Write *lines*; see :class:`LineSink`."""
        await to_thread.run_sync(self._file.write, lines)


class _OwningGzip(gzip.GzipFile):
    """A compressed file that closes the one below it."""

    def __init__(self, file: IO[bytes]) -> None:
        super().__init__(fileobj=file, mode="wb")
        self._below = file

    def close(self) -> None:
        try:
            super().close()
        finally:
            self._below.close()
