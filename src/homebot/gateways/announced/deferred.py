"""Messages that wait until there is work to spare for them. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from homebot.gateways.announced.work_budget import MESSAGE_WORK
from homebot.support.byte_account import ByteAccount

__all__ = ["DeferredMessages"]

MessageT = TypeVar("MessageT")

MAX_BYTES = 16 * 1024 * 1024
"""Bytes of all that wait, each message counted with those that it costs beside its payload."""

MAX_WORK_EACH = 512 * 1024
"""Work that may wait of one source: half a second of its budget."""

_OVERHEAD = 1024


@dataclass(slots=True)
class _Source(Generic[MessageT]):
    payer: str
    messages: list[tuple[MessageT, int, bool]] = field(default_factory=list)
    work: int = 0


@dataclass(slots=True)
class _Payer(Generic[MessageT]):
    sources: OrderedDict[str, _Source[MessageT]] = field(default_factory=OrderedDict)
    bytes: int = 0


class DeferredMessages(Generic[MessageT]):
    """The messages that wait for a budget: the newest of each source, in their order.

    If one source has too many, those that do not look like its accepted messages go first, the oldest of them first: an
    honest sender is heard among strangers that flood its topic. If there are too many in all, the budget with the most
    loses those of the source that was quiet the longest.
    """

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self.dropped = 0
        self._sources: dict[str, _Source[MessageT]] = {}
        self._payers: dict[str, _Payer[MessageT]] = {}
        self._account = ByteAccount[str](max_bytes, lambda: tuple(self._payers), self._bytes_of, self._drop_oldest)

    @property
    def bytes(self) -> int:
        """Bytes of all that wait."""
        return self._account.used

    def __contains__(self, source: str) -> bool:
        return source in self._sources

    def __bool__(self) -> bool:
        return bool(self._sources)

    def add(self, message: MessageT, source: str, length: int, payer: str, *, is_like: bool) -> None:
        """Defer *message* of *length* bytes until the budget of *payer* has room.

        Args:
            is_like: Whether it looks like the accepted messages of its source.
        """
        known = self._sources.get(source)
        if known is None:
            known = self._sources[source] = _Source(payer)
        budget = self._payers.setdefault(known.payer, _Payer())
        budget.sources[source] = known
        budget.sources.move_to_end(source)
        known.messages.append((message, length, is_like))
        self._count(source, known, length, 1)
        while known.work > MAX_WORK_EACH and len(known.messages) > 1:
            unlike = next((index for index, one in enumerate(known.messages) if not one[2]), 0)
            self._pop(source, unlike)
            self.dropped += 1

    def drop(self, source: str) -> None:
        """Drop all messages of *source*."""
        while source in self._sources:
            self._pop(source)

    def release(self, admits: Callable[[str], bool]) -> Iterator[MessageT]:
        """Take out the messages that need not wait, one of each budget in turn until none *admits* one more.

        Those of a source come in their order; of the sources that share a budget the newest comes first, so that
        a new source is not behind a flood.
        """
        is_done = False
        while not is_done:
            is_done = True
            for payer in tuple(self._payers):
                budget = self._payers.get(payer)
                if budget is not None and admits(payer):
                    is_done = False
                    yield self._pop(next(reversed(budget.sources)))

    def _pop(self, name: str, index: int = 0) -> MessageT:
        source = self._sources[name]
        message, length, _ = source.messages.pop(index)
        self._count(name, source, length, -1)
        if not source.messages:
            del self._sources[name]
            sources = self._payers[source.payer].sources
            del sources[name]
            if not sources:
                del self._payers[source.payer]
        return message

    def _count(self, name: str, source: _Source[MessageT], length: int, sign: int) -> None:
        size = sign * (_OVERHEAD + len(name) + length)
        source.work += sign * (MESSAGE_WORK + length)
        self._payers[source.payer].bytes += size
        self._account.add(size)

    def _bytes_of(self, payer: str) -> int:
        found = self._payers.get(payer)
        return 0 if found is None else found.bytes

    def _drop_oldest(self, payer: str) -> None:
        self._pop(next(iter(self._payers[payer].sources)))
        self.dropped += 1
