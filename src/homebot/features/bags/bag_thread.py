"""Writing of a bag in a thread, behind a bounded queue: a slow disk delays no task, and its losses are counted."""

import threading
from queue import Empty, SimpleQueue
from typing import Final, Self, final

from homebot.errors import UsageError
from homebot.features.bags.bag_topic import BagMessage
from homebot.features.bags.bag_writer import BagWriter
from homebot.support.isolation import error_text

_MAX_BYTES: Final = 64 * 1024 * 1024
_EACH: Final = 200
"""Bytes that a waiting message takes beside its own."""

_FLUSHED_AFTER: Final = 5.0
"""Seconds without a message after which the last ones are given to the operating system."""


@final
class BagThread:
    """Writes into *writer*, and closes it at the end of the block.

    Messages beyond 64 MiB that wait are dropped, as is everything after an error.

    Attributes:
        dropped: The number of messages that were dropped.
        error: Why the bag ends early; None if it does not.
    """

    def __init__(self, writer: BagWriter, most_bytes: int = _MAX_BYTES) -> None:
        self.dropped = 0
        self.error: UsageError | None = None
        self._writer, self._most = writer, most_bytes
        self._queue: SimpleQueue[BagMessage | None] = SimpleQueue()
        self._waiting = 0
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="bag", daemon=True)

    def put(self, message: BagMessage) -> None:
        """Write *message* soon, or drop and count it."""
        size = len(message.data) + _EACH
        with self._lock:
            if self.error or self._waiting + size > self._most:
                self.dropped += 1
                return
            self._waiting += size
        self._queue.put(message)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._queue.put(None)
        self._thread.join()
        while not self._queue.empty():
            self.dropped += self._queue.get() is not None
        try:
            self._writer.close()
        except Exception as exc:  # noqa: BLE001 - as below
            self.error = self.error or self._explain(exc)

    def _run(self) -> None:
        try:
            while (message := self._next()) is not None:
                self._writer.write(message)
                with self._lock:
                    self._waiting -= len(message.data) + _EACH
        except Exception as exc:  # noqa: BLE001 - no task awaits this thread
            with self._lock:
                self.error = self._explain(exc)
                self.dropped += 1

    def _explain(self, exc: Exception) -> UsageError:
        why = exc if isinstance(exc, UsageError) else getattr(exc, "strerror", None) or error_text(exc)
        path = self._writer.path
        error = UsageError(f"{path} ends early: {why}; `homebot bag recover {path} NEW` keeps what is whole")
        error.__cause__ = exc
        return error

    def _next(self) -> BagMessage | None:
        while True:
            try:
                return self._queue.get(timeout=_FLUSHED_AFTER)
            except Empty:
                self._writer.flush()
