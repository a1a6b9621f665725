"""The port to readers of tags: each blocks a thread of its own, and reaches the gateway by a :class:`ReaderDesk`."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass, field
from threading import Event, Lock
from typing import Protocol, TypeAlias

import anyio
import anyio.lowlevel
from anyio import from_thread, to_thread

from homebot.conventions.nfc.ndef_message import TagContent, TagError
from homebot.errors import LinkError


class PresentTag(Protocol):
    """A tag that is at a reader now. Its methods block; only the reader's thread calls them."""

    @property
    def uid(self) -> str:
        """Its number in hexadecimal digits."""

    @property
    def tag_type(self) -> str:
        """Its type, as text."""

    def read(self) -> TagContent:
        """Return its content; raise TagError if it is not formatted for NDEF, or was taken away."""

    def write(self, message: bytes) -> None:
        """Replace its content by an NDEF message; raise TagError if it refuses that, or was taken away."""


@dataclass(frozen=True, slots=True)
class ReaderFound:
    """A reader that is connected now."""

    reader: str


@dataclass(frozen=True, slots=True)
class TagSeen:
    """A tag that was held to a reader, or written there.

    Attributes:
        uid: Its number; empty if that could not be read.
        content: Its content; None if that could not be read.
        problem: The reason why it could not be read.
    """

    reader: str
    uid: str
    tag_type: str
    content: TagContent | None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class TagLeft:
    """A tag that was taken away from a reader."""

    uid: str


ReaderNews: TypeAlias = ReaderFound | TagSeen | TagLeft


@dataclass(slots=True, eq=False)
class WriteOrder:
    """An order to write the tag that is at a reader, or the next one.

    Attributes:
        reader: A part of the reader's name; empty for any.
        done: Set after the attempt to write.
        error: The error; None if it was written.
    """

    message: bytes
    reader: str = ""
    done: asyncio.Event = field(default_factory=asyncio.Event)
    tag: str = ""
    used_reader: str = ""
    error: TagError | None = None
    _claim: Lock = field(default_factory=Lock)

    def claim(self) -> bool:
        """Return true to the first caller alone, which then carries it out: several readers may have the order."""
        return self._claim.acquire(blocking=False)


class ReaderDesk:
    """The place where threads of readers and the gateway meet: a thread waits until *report* has handled its report."""

    def __init__(self, report: Callable[[ReaderNews], Coroutine[object, object, None]]) -> None:
        self._report = report
        self._stopped = Event()
        self._lock = Lock()
        self._order: WriteOrder | None = None

    @property
    def is_stopped(self) -> bool:
        """True when the readers should end."""
        return self._stopped.is_set()

    def stop(self) -> None:
        """Ask the readers to end."""
        self._stopped.set()

    def wait(self, seconds: float) -> bool:
        """Wait in a reader's thread; return whether it should end."""
        return self._stopped.wait(seconds)

    def place(self, order: WriteOrder) -> None:
        """Place an order with the reader; it has one at a time."""
        with self._lock:
            self._order = order

    def withdraw(self, order: WriteOrder) -> None:
        """Cancel an order."""
        with self._lock:
            if self._order is order:
                self._order = None

    def found(self, reader: str) -> None:
        """Report that *reader* is connected, from its thread."""
        self._post(ReaderFound(reader))

    def arrived(self, reader: str, tag: PresentTag) -> None:
        """Report a tag that was held to *reader*; write it if that was ordered."""
        if not self.stayed(reader, tag):
            self._post(_seen(reader, tag))

    def unreadable(self, reader: str, problem: str) -> None:
        """Report a tag at *reader* without a readable number."""
        self._post(TagSeen(reader, "", "", None, problem))

    def stayed(self, reader: str, tag: PresentTag) -> bool:
        """Write a tag that is still at *reader*, if that was ordered; return whether it was."""
        order = self._claim_order(reader)
        if order is None:
            return False
        error: TagError | None = None
        try:
            tag.write(order.message)
            if tag.read().message != order.message:
                error = TagError("lost", "what was read back differs from what was written")
        except TagError as exc:
            error = exc
        self._post(_seen(reader, tag))
        from_thread.run_sync(_finish, order, reader, tag.uid, error)
        return True

    def left(self, uid: str) -> None:
        """Report that a tag was taken away."""
        self._post(TagLeft(uid))

    def _claim_order(self, reader: str) -> WriteOrder | None:
        with self._lock:
            order = self._order
            if order is None or order.reader.casefold() not in reader.casefold():
                return None
            self._order = None
            return order if order.claim() else None

    def _post(self, news: ReaderNews) -> None:
        with suppress(CancelledError):  # then it is stopped
            if not self.is_stopped:
                from_thread.run(self._report, news)


class TagReader(ABC):
    """A reader that a library drives by blocking calls."""

    @abstractmethod
    def run(self, desk: ReaderDesk) -> None:
        """Read tags until the *desk* is stopped, in a thread of its own; raise LinkError if the reader is not there."""


@dataclass(frozen=True, slots=True)
class TagReaders:
    """Readers that a host gives the gateway instead of those in its settings."""

    readers: tuple[TagReader, ...]


async def read_tags(reader: TagReader, desk: ReaderDesk) -> None:
    """Run *reader* until it fails with a LinkError, or this is cancelled; then its thread has ended."""

    async def stop_when_cancelled() -> None:
        try:
            await anyio.sleep_forever()
        finally:
            desk.stop()

    failure: LinkError | None = None
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(stop_when_cancelled)
        try:
            await to_thread.run_sync(reader.run, desk, limiter=anyio.CapacityLimiter(1))
        except LinkError as exc:  # the group would wrap it
            failure = exc
        tasks.cancel_scope.cancel()
    await anyio.lowlevel.checkpoint_if_cancelled()  # then the reader has ended because of that
    if failure is not None:
        raise failure


def _seen(reader: str, tag: PresentTag) -> TagSeen:
    content: TagContent | None = None
    problem = ""
    try:
        content = tag.read()
    except TagError as exc:
        problem = str(exc)
    return TagSeen(reader, tag.uid, tag.tag_type, content, problem)


def _finish(order: WriteOrder, reader: str, uid: str, error: TagError | None) -> None:
    order.used_reader, order.tag, order.error = reader, uid, error
    order.done.set()
