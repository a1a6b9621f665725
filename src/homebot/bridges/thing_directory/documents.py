"""Documents of the directory: the listed ones, their changes, and those about itself and refused requests. Pure.

Of the changes the last 1,000 are kept, and no more than 4 MiB; a reader that is further behind has to read the list
again.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, sections 7.3.2.1 (Things API) and 7.3.2.2
(Events API); RFC 9457 (problem details); WHATWG Fetch Living Standard, section 3.3 (HTTP CORS protocol).
"""

import json
from bisect import bisect_left, insort
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import blake2b
from http import HTTPStatus
from typing import Final

from homebot.conventions.payload import clean_text, compact_json
from homebot.wot.parse import CONTEXT
from homebot.wot.thing import THING_CHANGES, ThingChange

__all__ = [
    "BEARER",
    "LD_TYPE",
    "PREFLIGHT",
    "TD_TYPE",
    "CatalogChange",
    "DirectoryAnswer",
    "RequestError",
    "ThingCatalog",
    "at_base",
    "directory_description",
    "merge_patch",
    "page_of",
    "sharing_headers",
]

TD_TYPE: Final = "application/td+json"
LD_TYPE: Final = "application/ld+json"
_PROBLEM_TYPE: Final = "application/problem+json"

_PAGE: Final = 50
"""Descriptions of one page, where the client asks for no other number."""

_MAX_PAGE: Final = 100
"""Most descriptions of one page."""

BEARER: Final[Mapping[str, object]] = {
    "securityDefinitions": {"bearer_sc": {"scheme": "bearer", "in": "header", "format": "opaque"}},
    "security": "bearer_sc",
}

_DISCOVERY_CONTEXT: Final = "https://www.w3.org/2022/wot/discovery"
_LONGEST = 300
_MOST_DIGITS = 9


@dataclass(frozen=True, slots=True)
class DirectoryAnswer:
    """An answer; without a body it has no content type."""

    body: bytes = b""
    content_type: str = ""
    status: int = 200
    headers: Mapping[str, str] = field(default_factory=dict)


PREFLIGHT: Final = DirectoryAnswer(
    status=HTTPStatus.NO_CONTENT,
    headers={
        "Access-Control-Allow-Methods": "GET, HEAD, PUT",
        "Access-Control-Allow-Headers": "Authorization, Content-Type, If-None-Match, Last-Event-ID",
        "Access-Control-Max-Age": "600",
    },
)
"""The answer to a browser's preflight request, which comes without a token."""


def sharing_headers(origins: Sequence[str]) -> Mapping[str, str]:
    """Return the header fields that let the page of *origins* read the answer; it must have been admitted before.

    Nothing is shared with anything else: a program that is no page sends no origin.
    """
    if len(origins) != 1 or not (origins[0].isascii() and origins[0].isprintable()):
        return {}
    return {
        "Access-Control-Allow-Origin": origins[0],
        "Access-Control-Expose-Headers": "Allow, ETag, Link, Retry-After",
        "Vary": "Origin",
    }


class RequestError(Exception):
    """A request is not carried out."""

    def __init__(self, status: HTTPStatus, detail: str, **headers: str) -> None:
        super().__init__(detail)
        problem = {"title": status.phrase, "status": status.value, "detail": clean_text(detail, _LONGEST)}
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        self.answer = DirectoryAnswer(compact_json(problem).encode(), _PROBLEM_TYPE, status.value, named)


@dataclass(frozen=True, slots=True)
class PageRequest:
    """A page of the list that is asked for: at most *limit* descriptions after *offset*, as a list or a collection."""

    offset: int
    limit: int
    is_descending: bool
    is_collection: bool

    def address(self, offset: int) -> str:
        """Return the address of the same page at another offset."""
        order = "&sort_order=desc" if self.is_descending else ""
        form = "&format=collection" if self.is_collection else ""
        return f"/things?offset={offset}&limit={self.limit}{order}{form}"


def page_of(query: Mapping[str, str]) -> PageRequest:
    """Return the page that a *query* asks for; raise RequestError if it cannot be."""
    order, form = query.get("sort_order", "asc"), query.get("format", "array")
    if query.get("sort_by", "id") != "id":
        raise RequestError(HTTPStatus.NOT_IMPLEMENTED, "the list is sorted by id alone")
    if order not in {"asc", "desc"}:
        raise RequestError(HTTPStatus.BAD_REQUEST, "sort_order is asc or desc")
    if form not in {"array", "collection"}:
        raise RequestError(HTTPStatus.BAD_REQUEST, "format is array or collection")
    offset, limit = _whole(query, "offset", 0), _whole(query, "limit", _PAGE)
    if limit == 0:
        raise RequestError(HTTPStatus.BAD_REQUEST, "limit is at least 1")
    return PageRequest(offset, min(limit, _MAX_PAGE), order == "desc", form == "collection")


def at_base(text: str, base: str) -> str:
    """Return the description *text*, a non-empty JSON object, with relative addresses resolved against *base*."""
    return f'{{"base":{compact_json(base)},{text[1:]}'


def directory_description(title: str, thing_id: str, security: Mapping[str, object]) -> dict[str, object]:
    """Return the description of the directory itself."""
    page = {name: {"type": "integer", "minimum": least} for name, least in (("offset", 0), ("limit", 1))}
    page |= {"sort_order": {"enum": ["asc", "desc"]}, "format": {"enum": ["array", "collection"]}}
    things = {
        "description": "all descriptions, in pages",
        "type": "array",
        "readOnly": True,
        "uriVariables": page,
        "forms": _forms("/things{?offset,limit,sort_order,format}", "readproperty", contentType=LD_TYPE),
    }
    retrieve = {
        "description": "the description of one thing",
        "safe": True,
        "idempotent": True,
        "uriVariables": {"id": {"type": "string", "format": "iri-reference"}},
        "output": {"type": "object"},
        "forms": _forms("/things/{id}", "invokeaction", response={"contentType": TD_TYPE}),
    }
    return {
        "@context": [CONTEXT, _DISCOVERY_CONTEXT],
        "@type": "ThingDirectory",
        "id": thing_id,
        "title": title,
        **security,
        "properties": {"things": things},
        "actions": {"retrieveThing": retrieve},
        "events": {f"thing{name.removeprefix('thing_').capitalize()}": _event(name) for name in THING_CHANGES},
    }


def _event(name: str) -> dict[str, object]:
    stream = {"subprotocol": "sse", "contentType": "text/event-stream"}
    return {
        "uriVariables": {"diff": {"type": "boolean"}},
        "data": {"type": "object"},
        "forms": _forms(f"/events/{name}{{?diff}}", "subscribeevent", **stream),
    }


def _forms(href: str, op: str, **more: object) -> list[dict[str, object]]:
    return [{"href": href, "op": op, "htv:methodName": "GET", **more}]


def _whole(query: Mapping[str, str], name: str, default: int) -> int:
    text = query.get(name, "")
    if not text:
        return default
    if not (text.isascii() and text.isdigit()) or len(text) > _MOST_DIGITS:
        raise RequestError(HTTPStatus.BAD_REQUEST, f"{name} is a whole number")
    return int(text)


MAX_CHANGES: Final = 1000
MAX_CHANGE_BYTES: Final = 4 * 1024 * 1024


@dataclass(frozen=True, slots=True)
class _ListedDescription:
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
        self._listed: dict[str, _ListedDescription] = {}
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

    def get(self, thing_id: str) -> _ListedDescription | None:
        """Return the description of a thing; None where there is none."""
        return self._listed.get(thing_id)

    def page(self, offset: int, limit: int, *, is_descending: bool = False) -> list[_ListedDescription]:
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
        self._listed[thing_id] = _ListedDescription(thing_id, text, blake2b(text.encode(), digest_size=8).hexdigest())
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
