"""Standard output and error without blocking, and without control sequences from outside.

A paused terminal, or a pipe without a reader, blocks writers after some kilobytes. An :class:`OutputQueue` has a thread
that waits instead. Lines keep their order; excess lines are dropped, counted, and reported in their place once the
reader continues.
"""

import atexit
import io
import os
import re
import select
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final, TextIO, cast, final

# Control characters, line and paragraph separators, and those that turn the direction of text.
CONTROL: Final = re.compile(r"[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
_CONTROL_BUT_LINES: Final = re.compile(CONTROL.pattern.replace(r"\x00-\x1f", r"\x00-\x09\x0b-\x1f"))

MAX_WAITING = 4 * 1024 * 1024
LAST_CHANCE = 0.5
"""Seconds for writing the rest at the end."""

_BATCH = 64 * 1024
_TICK = 0.1


def _loss_text(lines: int) -> str:
    return f"… {lines:,} lines were lost here, because they were not read in time\n"


@final
class OutputQueue:
    """Writes text to a file descriptor in its own thread.

    Up to 4 million characters may wait. Beyond that everything is dropped until half of them are written.

    Args:
        descriptor: The file descriptor, which is not closed.
        encoding: Text encoding; other characters are escaped.
        most: Most waiting characters.
        now: The monotonic clock, in seconds.

    Attributes:
        loss_text: Returns the text in place of so many missing lines.
    """

    def __init__(
        self,
        descriptor: int,
        encoding: str = "utf-8",
        *,
        most: int = MAX_WAITING,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.lost = 0
        self.loss_text: Callable[[int], str] = _loss_text
        self._descriptor = descriptor
        self._encoding = encoding
        self._most = most
        self._now = now
        self._waiting: deque[str] = deque()
        self._size = 0  # bytes queued and being written
        self._untold = 0
        self._is_idle = True
        self._is_gone = False  # the reader has closed the pipe
        # Reentrant, because a finalizer may log at any moment.
        self._changed = threading.Condition(threading.RLock())
        self._thread: threading.Thread | None = None

    def put(self, text: str) -> None:
        """Queue *text*; never waits, from any thread."""
        with self._changed:
            if self._is_gone:
                return
            if self._size + len(text) > self._most or (self._untold and self._size > self._most // 2):
                lines = max(1, text.count("\n"))
                self.lost += lines
                self._untold += lines
                return
            self._report_lost()
            self._add(text)
            self._is_idle = False
            if self._thread is None:
                self._thread = threading.Thread(target=self._write_all, name="output", daemon=True)
                self._thread.start()
            self._changed.notify_all()

    def drain(self, seconds: float) -> bool:
        """Wait until everything is written, for at most *seconds*; return whether it is.

        Any time in which the computer was suspended counts as 0.1 s, as the writing thread was suspended too.
        """
        left = seconds
        with self._changed:
            while not self._is_idle and left > 0:
                began = self._now()
                self._changed.wait(min(left, _TICK))
                left -= min(self._now() - began, _TICK)
            return self._is_idle

    def _add(self, text: str) -> None:
        self._waiting.append(text)
        self._size += len(text)

    def _report_lost(self) -> None:
        if self._untold:
            lines, self._untold = self._untold, 0
            self._add(self.loss_text(lines))

    def _write_all(self) -> None:
        while True:
            with self._changed:
                while not self._waiting:
                    if self._untold:
                        self._report_lost()
                        continue
                    self._is_idle = True
                    self._changed.notify_all()
                    self._changed.wait()
                texts = [self._waiting.popleft()]
                size = len(texts[0])
                while self._waiting and size < _BATCH:
                    texts.append(self._waiting.popleft())
                    size += len(texts[-1])
            is_gone = not self._write("".join(texts).encode(self._encoding, "backslashreplace"))
            with self._changed:
                self._size -= size
                if is_gone:
                    self._is_gone, self._untold, self._size = True, 0, 0
                    self._waiting.clear()

    def _write(self, data: bytes) -> bool:
        """Write *data*, blocking; return False if the reader is gone."""
        rest = memoryview(data)
        while rest:
            try:
                rest = rest[os.write(self._descriptor, rest) :]
            except BlockingIOError:  # another process made the shared descriptor non-blocking
                select.select([], [self._descriptor], [])
            except OSError:
                return False
        return True


class _TextOver(io.TextIOBase):
    """A text stream over another one."""

    def __init__(self, raw: TextIO) -> None:
        self.raw = raw

    @property
    def encoding(self) -> str:  # type: ignore[override]  # typeshed has an attribute
        """The encoding of the stream."""
        return self.raw.encoding

    def writable(self) -> bool:
        """Return True."""
        return True

    def isatty(self) -> bool:
        """Return whether it goes to a terminal."""
        return self.raw.isatty()

    def fileno(self) -> int:
        """Return the descriptor of the stream."""
        return self.raw.fileno()


class QueuedText(_TextOver):
    """A text stream over an :class:`OutputQueue`, in place of the *raw* one."""

    def __init__(self, queue: OutputQueue, raw: TextIO) -> None:
        super().__init__(raw)
        self.queue = queue

    def write(self, text: str) -> int:
        """Queue *text*; never waits."""
        self.queue.put(text)
        return len(text)


class CleanText(_TextOver):
    """A text stream that escapes control characters, except line ends, for the *raw* one."""

    def write(self, text: str) -> int:
        """Write *text* with control characters escaped as in JSON, Python and YAML."""
        self.raw.write(_CONTROL_BUT_LINES.sub(lambda found: f"\\u{ord(found[0]):04x}", text))
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        self.raw.flush()


def wants_colour(stream: TextIO) -> bool:
    """Return whether *stream* supports colours: a terminal, unless ``NO_COLOR`` is set.

    Source: https://no-color.org
    """
    return stream.isatty() and not os.environ.get("NO_COLOR")


def is_journal(stream: TextIO) -> bool:
    """Return whether *stream* leads to the journal of systemd, which adds the time to each line.

    Source: systemd 257, ``systemd.exec(5)``, ``$JOURNAL_STREAM``.
    """
    journal = os.environ.get("JOURNAL_STREAM")
    if not journal:
        return False
    with suppress(OSError, ValueError):  # it may have no descriptor
        status = os.fstat(stream.fileno())
        return journal == f"{status.st_dev}:{status.st_ino}"
    return False


@contextmanager
def clean_output() -> Iterator[None]:
    """Escape control characters in everything printed in the block.

    It stays in effect after an unexpected error, because Python then prints a traceback.
    """
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast("TextIO", CleanText(stream)) for stream in before)
    try:
        yield
    except (SystemExit, KeyboardInterrupt):
        sys.stdout, sys.stderr = before
        raise
    sys.stdout, sys.stderr = before


@contextmanager
def queued_output() -> Iterator[Callable[[], int]]:
    """Write standard output and error without blocking during the block; yield the counter of lost lines.

    At its end there is half a second for the rest. A stream without a file descriptor is unchanged.
    """
    before = sys.stdout, sys.stderr
    queues: dict[tuple[int, int, int], OutputQueue] = {}
    sys.stdout, sys.stderr = (_queue(stream, queues) for stream in before)

    def drain() -> None:
        for queue in queues.values():
            queue.drain(LAST_CHANCE)

    atexit.register(drain)  # for lines after the block
    try:
        yield lambda: sum(queue.lost for queue in queues.values())
    finally:
        sys.stdout, sys.stderr = before
        drain()


def _queue(stream: TextIO, queues: dict[tuple[int, int, int], OutputQueue]) -> TextIO:
    """Return *stream* over the queue of its file; both streams of a terminal share one, to keep their order."""
    if isinstance(stream, CleanText):
        return cast("TextIO", CleanText(_queue(stream.raw, queues)))
    try:
        stream.flush()
        descriptor = stream.fileno()
        status = os.fstat(descriptor)
    except (AttributeError, OSError, ValueError):
        return stream
    file = (status.st_dev, status.st_ino, status.st_rdev)
    queue = queues.setdefault(file, OutputQueue(descriptor, stream.encoding or "utf-8"))
    return cast("TextIO", QueuedText(queue, stream))
