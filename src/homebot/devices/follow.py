"""Live queries: the devices that match now, and then every change."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, Generic, Protocol, Self, TypeVar

import anyio
import anyio.lowlevel

from homebot.devices.device import ChangeKind, Device, DeviceChange, StateChange
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.devices.query.facets import shared_facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import And, IsNear, Query, StateIs, leaves, split_near, type_is
from homebot.errors import ClosedError
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE

if TYPE_CHECKING:
    from homebot.devices.near_watch import NearWatch

ItemT = TypeVar("ItemT")

_TURN: Final = 100
"""Changes to yield before other tasks get their turn, in case the reader never waits."""

_ANY: Final = And(())
NO_LONGER: Final = "it no longer matches the query"


class LiveQuery(HouseWatcher, ABC, Generic[ItemT]):
    """Iterator over the changes of the house that one reader wants: for each device, the newest unread one.

    Args:
        node: The node that asks; the query ends with it.
        near: The query for devices near a robot, for the directory; None for none.
    """

    def __init__(self, node: Node, names: Query, text: str, near: Query | None = None) -> None:
        self._node = node
        self._names = names
        self._text = text
        self._asked_near = near
        self._near: NearWatch | None = None
        self._view: HouseView | None = None
        self._changed: dict[str, DeviceChange | StateChange] = {}
        self._ready: deque[ItemT] = deque()
        self._cause: DeviceChange | StateChange | None = None
        self._news = anyio.Event()
        self._is_closed = False
        self._turns = 0

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> ItemT:
        """Return the next change.

        Raises:
            StopAsyncIteration: The query or its node was closed.
        """
        view = self._view or self._begin()
        self._turns += 1
        if self._turns % _TURN == 0:
            await anyio.lowlevel.checkpoint()
        while not self._ready:
            if (cause := self._next_change()) is not None:
                self._cause = cause
                self._process(view, cause)
            elif self._is_closed:
                raise StopAsyncIteration
            else:
                await self._news.wait()
                self._news = anyio.Event()
        CURRENT_CAUSE.set(self._cause)
        return self._ready.popleft()

    def close(self) -> None:
        """End the query; idempotent."""
        self._is_closed = True
        self._changed.clear()
        self._ready.clear()
        self._news.set()
        if self._view is not None:
            self._view.remove(self)
            self._view.names.remove(self._text)
        if self._near is not None:
            self._near.close()

    def on_device(self, change: DeviceChange) -> None:
        """Store the newest change of a device for the reader."""
        if not self._changed:
            self._news.set()
        self._changed[change.device.id] = change
        if self._near is not None:
            self._near.ask()

    def on_values(self, change: StateChange) -> None:
        """Handle new values of a known device."""
        if self._near is not None:
            self._near.on_values(change)

    def _begin(self) -> HouseView:
        if self._is_closed:
            raise StopAsyncIteration
        try:
            self._view = view = HouseView.of(self._node)
            if self._asked_near is not None:
                from homebot.devices.near_watch import NearWatch  # noqa: PLC0415 - few queries ask for it

                self._near = NearWatch(self._node, view, self._asked_near, self._compare_near)
            view.add(self)
            names = self._names if self._asked_near is None else And((self._names, self._asked_near))
            if names != _ANY:
                view.names.add(names, self._text)
        except ClosedError:
            self.close()
            raise StopAsyncIteration from None
        return view

    def _is_near(self, device_id: str) -> bool:
        return self._near is None or device_id in self._near.ids

    def _compare_near(self, device_ids: Iterable[str]) -> None:
        for device_id in device_ids:
            known = self._view.get(device_id) if self._view is not None else None
            if known is not None:
                why = "it is near now" if self._is_near(device_id) else "it is no longer near"
                change = DeviceChange(kind="changed", device=known.current(), sequence=known.sequence, why=why)
                self._changed[device_id] = change
        self._news.set()

    def _next_change(self) -> DeviceChange | StateChange | None:
        """Remove and return the next change to process; None if there is none."""
        return self._changed.pop(next(iter(self._changed))) if self._changed else None

    @abstractmethod
    def _process(self, view: HouseView, change: DeviceChange | StateChange) -> None:
        """Append the items for the reader that follow from a change."""


class QueryInWords(Protocol):
    """A query that people wrote, with names of devices that come and go; see :mod:`homebot.words.house_queries`.

    Attributes:
        query: What it means by now.
    """

    text: str
    query: Query

    def record(self, device: Device, *, is_gone: bool = False) -> bool:
        """Record a new, changed or removed device; return whether the query means something else now."""


class Follow(LiveQuery[DeviceChange]):
    """A live query for devices: ``async for change in Follow(node, "lights")``.

    Known devices are reported at once. For each device, ``appeared`` comes first and ``removed`` last. A reader that
    falls behind misses intermediate changes of a device, but never the last one. The query waits for a directory that
    is not running yet; after a restart of the directory it yields the differences. Only one task may read.

    Args:
        node: The node that asks; the query ends with it.
        service_type: For example ``lights``; empty for every device. A device that no longer has it is ``removed``.
        query: A further condition: a device ``appeared`` when it begins to match, and is ``removed`` when it no longer
            does.
        words: The condition in words instead, such as ``on lights in kitchen``.
        text: What it is called in messages about names that the house lacks; by default its arguments.
    """

    def __init__(
        self,
        node: Node,
        service_type: str = "",
        query: Query | None = None,
        text: str = "",
        *,
        words: QueryInWords | None = None,
    ) -> None:
        self._type: tuple[Query, ...] = (type_is(service_type),) if service_type else ()
        self._words = words
        asked = query if words is None else words.query
        near, self._query = self._split(() if asked is None else (asked,))
        text = text or f"follow({(words and words.text) or query or service_type!r})"
        super().__init__(node, self._query, text, near)
        self._asks_for_values = any(isinstance(term, StateIs) for term in leaves(self._query))
        self._matching: set[str] = set()

    @property
    def query(self) -> Query:
        """The query, in which words that are exactly the name of a known device mean that device."""
        return self._query

    def on_device(self, change: DeviceChange) -> None:
        """Store the newest change of a device; the first or last one with a name may change what the query means."""
        super().on_device(change)
        if self._words is not None and self._words.record(change.device, is_gone=change.kind == "removed"):
            _, self._query = self._split((self._words.query,))
            for device in () if self._view is None else self._view.devices:
                if device.id not in self._changed:
                    self._changed[device.id] = change.model_copy(update={"kind": "changed", "device": device})

    def _split(self, queries: tuple[Query, ...]) -> tuple[IsNear | None, Query]:
        terms = (*self._type, *queries)
        return split_near(terms[0] if len(terms) == 1 else And(terms))

    def on_values(self, change: StateChange) -> None:
        """Record that the values of a device changed, if the query has conditions on values."""
        super().on_values(change)
        if self._asks_for_values and change.device not in self._changed:
            self._changed[change.device] = change
            self._news.set()

    def _process(self, view: HouseView, change: DeviceChange | StateChange) -> None:
        device_id = change.device if isinstance(change, StateChange) else change.device.id
        device = self._device_now(view, device_id)
        did_match, does_match = device_id in self._matching, device is not None and self._wants(device)
        (self._matching.add if does_match else self._matching.discard)(device_id)
        if isinstance(change, DeviceChange):
            if did_match or does_match:
                kind = _kind(change.kind, did_match=did_match, does_match=does_match)
                self._ready.append(change.model_copy(update={"kind": kind, "device": device or change.device}))
        elif device is not None and did_match != does_match:
            values = ", ".join(f"its {reading.capability} is {reading.value.plain()}" for reading in change.readings)
            what: ChangeKind = "appeared" if does_match else "removed"
            why = f"{values} now" if does_match else NO_LONGER
            self._ready.append(DeviceChange(kind=what, device=device, sequence=change.sequence, why=why))

    def _device_now(self, view: HouseView, device_id: str) -> Device | None:
        if (known := view.get(device_id)) is None:
            return None
        return known.settled() if self._asks_for_values else known.device

    def _wants(self, device: Device) -> bool:
        return self._is_near(device.id) and (self._query == _ANY or fits(self._query, shared_facets_of(device)))


def _kind(kind: ChangeKind, *, did_match: bool, does_match: bool) -> ChangeKind:
    """Return *kind* for the reader: each device appears first and is removed last."""
    if not does_match:
        return "removed"
    if not did_match:
        return "appeared"
    return "changed" if kind == "appeared" else kind
