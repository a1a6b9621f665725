"""The pages of a list that were read, so that one that has not changed is not sent again. Pure.

Source: RFC 9110, sections 8.8.3 (ETag) and 13.1.2 (If-None-Match).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["DirectoryPage", "ReadPage", "etag_of"]

_ETAG = re.compile(r'(?:W/)?"[\x21\x23-\x7e]{0,200}"')


@dataclass(frozen=True, slots=True)
class ReadPage:
    """A page as it was when it was read.

    Attributes:
        etag: Its entity tag.
        keys: The keys of the things on it.
        following: The address of the next page; empty for none.
    """

    etag: str
    keys: frozenset[str]
    following: str


@dataclass(slots=True)
class DirectoryPage:
    """A page of the list.

    Attributes:
        members: The descriptions on it; none where it has not changed.
        keys: The keys of the things on it; the reader of a page that has members adds them.
    """

    members: list[object] = field(default_factory=list)
    keys: set[str] = field(default_factory=set)


def etag_of(headers: Mapping[str, str]) -> str:
    """Return the entity tag in header fields, names in lower case; empty where there is none that can be sent back."""
    etag = headers.get("etag", "")
    return etag if _ETAG.fullmatch(etag) else ""
