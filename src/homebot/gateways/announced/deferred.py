"""Messages that wait until there is work to spare for them. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Generic, NamedTuple, TypeVar

from homebot.gateways.announced.work_budget import MESSAGE_WORK

__all__ = ["DeferredMessages"]

MessageT = TypeVar("MessageT")

MAX_BYTES = 16 * 1024 * 1024
"""Bytes of all that wait, each message counted with those that it costs beside its payload."""

MAX_WORK_EACH = 512 * 1024
"""Work that may wait of one source: half a second of its budget."""

_OVERHEAD = 1024


class _DeferredMessage(NamedTuple, Generic[MessageT]):
    message: MessageT
    length: int
    is_like: bool


@dataclass(slots=True)
class _Source(Generic[MessageT]):
    name: str
    payer: str
    messages: list[_DeferredMessage[MessageT]] = field(default_factory=list)
    work: int = 0


class DeferredMessages(Generic[MessageT]):
    """The messages that wait for a budget: the newest of each source, in their order.

    If one source has too many, those that do not look like its accepted messages go first, the oldest of them first.
    If there are too many in all, those of sources without a registered device go first, the oldest of them first.

    Args:
        max_bytes: Bytes of all of them.

    Attributes:
        dropped: Messages that were dropped.
        bytes: Bytes of all that wait.
    """

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self.dropped = 0
        self.bytes = 0
        self._max_bytes = max_bytes
        self._sources: dict[str, _Source[MessageT]] = {}
        self._own: dict[str, OrderedDict[str, _Source[MessageT]]] = {}
        self._shared: dict[str, OrderedDict[str, _Source[MessageT]]] = {}

    def __contains__(self, source: str) -> bool:
        return source in self._sources

    def __bool__(self) -> bool:
        return bool(self._sources)

    def add(self, message: MessageT, source: str, length: int, payer: str, *, is_like: bool) -> None:
        """Let *message* wait for the budget of *payer*.

        Args:
            message: The message.
            source: Where it came from.
            length: Its bytes.
            payer: The name of the budget that pays for it.
            is_like: Whether it looks like the accepted messages of its source.
        """
        known = self._sources.get(source)
        if known is None:
            known = self._sources[source] = _Source(source, payer)
        groups = self._own if known.payer == source else self._shared
        group = groups.setdefault(known.payer, OrderedDict())
        group[source] = known
        group.move_to_end(source)
        known.messages.append(_DeferredMessage(message, length, is_like))
        known.work += MESSAGE_WORK + length
        self.bytes += _OVERHEAD + len(source) + length
        while known.work > MAX_WORK_EACH and len(known.messages) > 1:
            self._drop_one(known)
        while self.bytes > self._max_bytes and len(self._sources) > 1:
            self._drop_oldest(group)

    def drop(self, source: str) -> None:
        """Let nothing of *source* wait any more."""
        while source in self._sources:
            self._pop(source, 0)

    def take(self, admits: Callable[[str], bool]) -> Iterator[MessageT]:
        """Take out the messages that need not wait, one of each budget in turn until none *admits* one more.

        Those of a source come in their order; of the sources that share a budget the newest comes first, so that
        a new source is not behind a flood.
        """
        is_done = False
        while not is_done:
            is_done = True
            for groups in (self._own, self._shared):
                for payer in tuple(groups):
                    if payer in groups and admits(payer):
                        is_done = False
                        yield self._pop(next(reversed(groups[payer])), 0)

    def _pop(self, name: str, index: int) -> MessageT:
        source = self._sources[name]
        message, length, _ = source.messages.pop(index)
        source.work -= MESSAGE_WORK + length
        self.bytes -= _OVERHEAD + len(name) + length
        if not source.messages:
            del self._sources[name]
            groups = self._own if source.payer == name else self._shared
            del groups[source.payer][name]
            if not groups[source.payer]:
                del groups[source.payer]
        return message

    def _drop_one(self, source: _Source[MessageT]) -> None:
        """Drop the oldest message that looks like nothing known, else the oldest."""
        unlike = next((index for index, one in enumerate(source.messages) if not one.is_like), 0)
        self._pop(source.name, unlike)
        self.dropped += 1

    def _drop_oldest(self, newest: OrderedDict[str, _Source[MessageT]]) -> None:
        group = next(iter(self._shared.values()), None) or next(
            (one for one in self._own.values() if one is not newest), newest
        )
        self._pop(next(iter(group)), 0)
        self.dropped += 1
