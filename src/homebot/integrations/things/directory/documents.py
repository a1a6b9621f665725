"""The documents of a directory of things: pages of its list, and events. Pure.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, sections 7.3.2.1 (Things API), 7.3.2.2
(Events API); RFC 8288, section 3 (the header field Link).
"""

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from homebot.conventions.payload import as_fields, parse_object, shown
from homebot.errors import WireError
from homebot.integrations.things.formats.thing import THING_CHANGES, ThingChange
from homebot.support.numbers import to_number

_MAX_ID_CHARACTERS = 500
_MAX_HEADER_CHARACTERS = 4000
_LINK = re.compile(r'<([^<>]{0,2000})>((?:[^<>,"]|"[^"]*")*)')
_NEXT = re.compile(r';\s*rel\s*=\s*(?:"(?:[^"]*\s)?next(?:\s[^"]*)?"|next)\s*(?:;|$)', re.IGNORECASE)
_MIN_LIFETIME_S, _MAX_LIFETIME_S = 60.0, 30 * 86_400.0


@dataclass(frozen=True, slots=True)
class DirectoryEvent:
    """A change in the directory."""

    change: ThingChange
    id: str


def members_of(page: object) -> list[object]:
    """Return the members of a page, an array or a collection; raise WireError for anything else."""
    members = as_fields(page).get("members") if isinstance(page, dict) else page
    if not isinstance(members, list):
        raise WireError(f"{shown(page)} is no page of a list of things")
    return members


def next_page(page: object, headers: Mapping[str, str]) -> str:
    """Return the unresolved address of the next page; empty for none."""
    for link in _LINK.finditer(headers.get("link", "")[:_MAX_HEADER_CHARACTERS]):
        if _NEXT.search(link[2]):
            return link[1]
    following = as_fields(page).get("next")
    return following if isinstance(following, str) else ""


def read_event(kind: str, data: str) -> DirectoryEvent | None:
    """Return the event in a message, None for another kind of event; raise WireError without the id of a thing."""
    change = next((known for known in THING_CHANGES if known == kind), None)
    if change is None:
        return None
    return DirectoryEvent(change, id_of(parse_object(data)))


def id_of(document: object) -> str:
    """Return the id of a described thing; raise WireError if it is missing or cannot be a name."""
    thing_id = as_fields(document).get("id")
    if (
        not isinstance(thing_id, str)
        or not 0 < len(thing_id) <= _MAX_ID_CHARACTERS
        or not thing_id.isprintable()
        or " " in thing_id
    ):
        raise WireError(
            f"a thing has the id {shown(thing_id)}; a URI of at most {_MAX_ID_CHARACTERS} characters is expected"
        )
    return thing_id


def text_of(document: object) -> bytes:
    """Return the text of a description for comparison, without times of registration and retrieval."""
    fields = {name: value for name, value in as_fields(document).items() if name != "registration"}
    return json.dumps(fields, sort_keys=True, ensure_ascii=True).encode()


def lifetime_of(document: object, now: float) -> float:
    """Return the lifetime of a registration in seconds, between 60 and 30 days; 0 if it has no end.

    Args:
        now: Seconds since the Unix epoch, for a registration with an end instead of a ``ttl``.
    """
    registration = as_fields(as_fields(document).get("registration"))
    given = to_number(registration.get("ttl"))
    if given is None:
        given = _end_of(registration.get("expires")) - now
    elif not given > 0:
        return 0.0
    return 0.0 if given == math.inf else min(max(given, _MIN_LIFETIME_S), _MAX_LIFETIME_S)


def _end_of(expires: object) -> float:
    """Return the time in *expires*, in seconds since the Unix epoch; infinite if there is none."""
    if not isinstance(expires, str):
        return math.inf
    try:
        end = datetime.fromisoformat(expires)
        return end.replace(tzinfo=end.tzinfo or UTC).timestamp()
    except (ValueError, OverflowError):
        return math.inf
