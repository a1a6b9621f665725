"""Documents about the directory itself, and about requests that it refuses. Pure.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, sections 7.3.2.1 (Things API) and 7.3.2.2
(Events API); RFC 9457 (problem details); WHATWG Fetch Living Standard, section 3.3 (HTTP CORS protocol).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Final

from homebot.conventions.payload import clean_text, compact_json
from homebot.wot.parse import CONTEXT
from homebot.wot.thing import THING_CHANGES

__all__ = [
    "BEARER",
    "LD_TYPE",
    "MAX_PAGE",
    "PAGE",
    "PREFLIGHT",
    "PROBLEM_TYPE",
    "TD_TYPE",
    "DirectoryAnswer",
    "RequestError",
    "at_base",
    "directory_description",
    "page_of",
    "sharing_headers",
]

TD_TYPE: Final = "application/td+json"
LD_TYPE: Final = "application/ld+json"
PROBLEM_TYPE: Final = "application/problem+json"

PAGE: Final = 50
"""Descriptions of one page, where the client asks for no other number."""

MAX_PAGE: Final = 100
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
        self.answer = DirectoryAnswer(compact_json(problem).encode(), PROBLEM_TYPE, status.value, named)


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
    offset, limit = _whole(query, "offset", 0), _whole(query, "limit", PAGE)
    if limit == 0:
        raise RequestError(HTTPStatus.BAD_REQUEST, "limit is at least 1")
    return PageRequest(offset, min(limit, MAX_PAGE), order == "desc", form == "collection")


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
