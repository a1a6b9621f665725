"""The descriptions that the directory lists, and the changes of the list. Pure.

Of the changes the last 1,000 are kept, and no more than 4 MiB; a reader that is further behind has to read the list
again.
"""

import json
from bisect import bisect_left, insort
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import blake2b
from typing import Final

from homebot.conventions.payload import compact_json
from homebot.wot.thing import ThingChange

__all__ = ["CatalogChange", "ListedDescription", "ThingCatalog", "merge_patch"]

MAX_CHANGES: Final = 1000
MAX_CHANGE_BYTES: Final = 4 * 1024 * 1024


@dataclass(frozen=True, slots=True)
class ListedDescription:
    """A description in the list, with another ETag for each other text."""

    id: str
    text: str
    etag: str


@dataclass(frozen=True, slots=True)
class CatalogChange:
    """A change of the list.

    Attributes:
        number: Its place among the changes; the first is 1.
        detail: The JSON of a new thing, or a merge patch (RFC 7396) of a known one; empty for a removed one.
    """

    number: int
    name: ThingChange
    id: str
    detail: str


class ThingCatalog:
    """The descriptions, sorted by id."""

    def __init__(self) -> None:
        self._listed: dict[str, ListedDescription] = {}
        self._ids: list[str] = []
        self._changes: deque[CatalogChange] = deque()
        self._change_bytes = 0
        self._last = 0

    def __len__(self) -> int:
        """Return the number of descriptions."""
        return len(self._listed)

    @property
    def version(self) -> int:
        """The number of the last change."""
        return self._last

    def get(self, thing_id: str) -> ListedDescription | None:
        """Return the description of a thing; None where there is none."""
        return self._listed.get(thing_id)

    def page(self, offset: int, limit: int, *, is_descending: bool = False) -> list[ListedDescription]:
        """Return at most *limit* descriptions behind the first *offset* ones."""
        ids = self._ids[::-1] if is_descending else self._ids
        return [self._listed[one] for one in ids[offset : offset + limit]]

    def put(self, thing_id: str, fields: Mapping[str, object], now: str) -> None:
        """List a description, in place of an older one of the thing, at the time *now*; an equal one is no change."""
        before = self._listed.get(thing_id)
        old: dict[str, object] = {} if before is None else json.loads(before.text)
        registered = old.pop("registration", {})
        if before is not None and old == json.loads(compact_json(fields)):
            return
        created = registered.get("created", now) if isinstance(registered, dict) else now
        text = compact_json({**fields, "registration": {"created": created, "modified": now}})
        self._listed[thing_id] = ListedDescription(thing_id, text, blake2b(text.encode(), digest_size=8).hexdigest())
        if before is None:
            insort(self._ids, thing_id)
            self._record("thing_created", thing_id, text)
        else:
            self._record(
                "thing_updated", thing_id, compact_json(merge_patch(json.loads(before.text), json.loads(text)))
            )

    def remove(self, thing_id: str) -> None:
        """Remove a description from the list; none is fine."""
        if self._listed.pop(thing_id, None) is not None:
            del self._ids[bisect_left(self._ids, thing_id)]
            self._record("thing_deleted", thing_id, "")

    def changes_after(self, number: int) -> list[CatalogChange] | None:
        """Return the changes after that number, oldest first; None where some of them are kept no longer."""
        missing = self._last - number
        if missing < 0 or missing > len(self._changes):
            return None
        return [self._changes[place] for place in range(len(self._changes) - missing, len(self._changes))]

    def _record(self, name: ThingChange, thing_id: str, detail: str) -> None:
        self._last += 1
        self._changes.append(CatalogChange(self._last, name, thing_id, detail))
        self._change_bytes += len(detail)
        while len(self._changes) > MAX_CHANGES or self._change_bytes > MAX_CHANGE_BYTES:
            self._change_bytes -= len(self._changes.popleft().detail)


def merge_patch(before: object, after: object) -> object:
    """Return the merge patch (RFC 7396) from *before* to *after*, both JSON."""
    if not isinstance(before, dict) or not isinstance(after, dict):
        return after
    patch: dict[str, object] = {name: None for name in before if name not in after}
    for name, value in after.items():
        if name not in before:
            patch[name] = value
        elif before[name] != value:
            patch[name] = merge_patch(before[name], value)
    return patch
