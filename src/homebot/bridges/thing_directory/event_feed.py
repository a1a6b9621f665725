"""The changes of the list, as server-sent events.

A client is sent changes from its place in the list's history: nothing is queued for it. One that falls behind so far
that its place is gone is cut off, and counted; it reads the list again, as after any break.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, section 7.3.2.2; HTML Living Standard,
section 9.2 (server-sent events).
"""

import json
from collections.abc import Collection, Mapping
from typing import Final, Protocol

import anyio

from homebot.bridges.thing_directory.catalog import CatalogChange, ThingCatalog
from homebot.bridges.thing_directory.documents import at_base
from homebot.conventions.payload import compact_json

__all__ = ["EventFeed"]

KEEP_ALIVE: Final = 15.0
"""Seconds of silence after which a line is sent that says nothing, so that a client that is gone is noticed."""


class ByteStream(Protocol):
    """The way to a client."""

    async def send(self, piece: bytes) -> None:
        """Send a piece; raise ConnectionError if the client has left, or takes no bytes."""


class EventFeed:
    """The events of one run.

    Args:
        version: Identifies the catalog of this run.

    Attributes:
        clients: Number of clients that are sent events.
        overtaken: Number of clients that fell behind too far.
    """

    def __init__(self, catalog: ThingCatalog, version: str) -> None:
        self.clients = 0
        self.overtaken = 0
        self._catalog = catalog
        self._version = version
        self._changed = anyio.Event()
        self._ended = 0

    def notify(self) -> None:
        """Wake all clients: the catalog changed."""
        self._changed.set()
        self._changed = anyio.Event()

    def close(self) -> None:
        """End all streams that are open now."""
        self._ended += 1
        self.notify()

    async def run(self, stream: ByteStream, names: Collection[str], last_id: str = "", base: str = "") -> None:
        """Send events until the client falls behind too far, or the directory ends.

        Args:
            names: The kinds of changes that the client wants.
            last_id: The id of the last event that it had; empty for none.
            base: The address of the directory, as the client calls it; empty if it wants ids without descriptions.

        Raises:
            ConnectionError: The client has left, or takes no bytes.
        """
        place, ended = self._place_of(last_id), self._ended
        self.clients += 1
        try:
            await stream.send(b"retry: 2000\n\n")
            while self._ended == ended:
                changes = self._catalog.changes_after(place)
                if changes is None:
                    self.overtaken += 1
                    return
                for change in changes:
                    place = change.number
                    if change.name in names:
                        await stream.send(self._event(change, base))
                if place == self._catalog.version and self._ended == ended:
                    await self._wait(stream)
        finally:
            self.clients -= 1

    async def _wait(self, stream: ByteStream) -> None:
        changed = self._changed
        with anyio.move_on_after(KEEP_ALIVE) as scope:
            await changed.wait()
        if scope.cancelled_caught:
            await stream.send(b":\n\n")

    def _place_of(self, last_id: str) -> int:
        """Return the number of the event that a client had last; the newest where that is not known any more."""
        version, _, number = last_id.rpartition("-")
        if version == self._version and number.isascii() and number.isdigit() and len(number) < 20:
            place = int(number)
            if self._catalog.changes_after(place) is not None:
                return place
        return self._catalog.version

    def _event(self, change: CatalogChange, base: str) -> bytes:
        fields: Mapping[str, object] = {"id": change.id}
        data = compact_json(fields)
        if base and change.detail:
            if change.name == "thing_created":
                data = at_base(change.detail, f"{base}/")
            else:
                data = compact_json({**json.loads(change.detail), **fields})
        return f"id: {self._version}-{change.number}\nevent: {change.name}\ndata: {data}\n\n".encode()
