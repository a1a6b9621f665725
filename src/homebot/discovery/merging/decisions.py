"""The owner's decisions on which announcements are one device; they outrank the evidence. Pure."""

import json
from collections.abc import Iterable
from typing import final

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.discovery.source_record import SourceKey
from homebot.errors import RefusedError, WireError

OWNER = "owner:"
"""Prefix of identifiers given by the owner."""

MAX_DECISIONS = 10_000
"""Most identifiers declared to be no evidence, and announcements merged by hand; further ones are refused."""


class _Record(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    ignored: tuple[str, ...] = ()
    merged: tuple[tuple[str, str, str], ...] = ()


@final
class MergeDecisions:
    """The owner's decisions: which identifiers are no evidence, and which announcements are one device.

    Too many decisions raise RefusedError.

    Attributes:
        merged: The identifiers that the owner gave to announcements.
        is_unsaved: Whether some decisions are not in the index file.
    """

    def __init__(self) -> None:
        self.ignored: set[str] = set()
        self.is_unsaved = False
        self.merged: dict[SourceKey, str] = {}

    def split(self, identifiers: Iterable[str], keys: Iterable[SourceKey]) -> None:
        """Decide that *identifiers* are no evidence, and withdraw the merging of *keys*."""
        ignored = {identifier for identifier in identifiers if not identifier.startswith(OWNER)} | self.ignored
        self._check("a split", len(ignored))
        self.ignored = ignored
        for key in keys:
            self.merged.pop(key, None)
        self.is_unsaved = True

    def merge(self, keys: Iterable[SourceKey]) -> None:
        """Decide that the announcements *keys* describe one device."""
        announcements = tuple(keys)
        self._check("a merge", len(self.merged) + len(announcements))
        known = {given for key in announcements if (given := self.merged.get(key)) is not None}
        name = min(known) if known else f"{OWNER}{'/'.join(min(announcements))}"
        for key, given in self.merged.items():
            if given in known:
                self.merged[key] = name
        self.merged.update(dict.fromkeys(announcements, name))
        self.is_unsaved = True

    def merged_with(self, keys: Iterable[SourceKey]) -> tuple[SourceKey, ...]:
        """Return *keys* and the announcements merged with them by hand."""
        given = {self.merged[key] for key in keys if key in self.merged}
        return tuple(key for key, name in self.merged.items() if name in given)

    def record(self) -> str:
        """Return the decisions as text, for the index file."""
        merged = [[*key, name] for key, name in sorted(self.merged.items())]
        return json.dumps({"ignored": sorted(self.ignored), "merged": merged})

    def restore(self, record: str) -> None:
        """Restore the records that :meth:`record` returned.

        Raises:
            WireError: It is invalid.
        """
        try:
            read = _Record.model_validate_json(record)
        except ValidationError as exc:
            raise WireError(f"no decisions: {exc.errors()[0]['msg']}", record[:100].encode(errors="replace")) from exc
        self.ignored = set(read.ignored[:MAX_DECISIONS])
        self.merged = {(gateway, key): name for gateway, key, name in read.merged[:MAX_DECISIONS]}

    def _check(self, what: str, count: int) -> None:
        if count > MAX_DECISIONS:
            raise RefusedError(what, f"there are {MAX_DECISIONS:,} decisions already; undo some")
