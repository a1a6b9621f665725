"""Damaged documents of a directory of things: refused in our words, or understood."""

import json
from contextlib import suppress
from typing import Any

import pytest
from tests.fuzz.conftest import Fuzz

from homebot.conventions.long_json import parse_in_slices
from homebot.conventions.payload import parse_json
from homebot.errors import WireError
from homebot.gateways.event_stream import EventStreamParser
from homebot.integrations.things.directory.documents import (
    id_of,
    lifetime_of,
    members_of,
    next_page,
    read_event,
    text_of,
)
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.http.http_port import HTTP_BINDING
from homebot.integrations.things.http.thing_device import describe_thing

LIMIT = 200_000
WORDS = ("id", "members", "next", "rel", "forms", "href", "http://x", "registration", "ttl")
THING: dict[str, Any] = {
    "@context": [CONTEXT, "https://webthings.io/schemas"],
    "id": "urn:dev:mac:00158d0001abcdef",
    "title": "Lamp",
    "@type": "Light",
    "base": "http://10.0.0.7/",
    "registration": {"ttl": 3600, "created": "2026-01-01T00:00:00Z"},
    "securityDefinitions": {"key": {"scheme": "bearer"}},
    "security": "key",
    "properties": {
        "on": {
            "type": "boolean",
            "@type": "OnOffProperty",
            "forms": [{"href": "on"}, {"href": "on", "op": "observeproperty", "subprotocol": "sse"}],
        }
    },
    "actions": {"blink": {"forms": [{"href": "blink", "htv:methodName": "POST"}]}},
    "events": {"hot": {"data": {"type": "number"}, "forms": [{"href": "hot", "subprotocol": "sse"}]}},
}
PAGES = [json.dumps([THING]), json.dumps({"members": [THING, THING], "next": "/things?offset=2"})]
LINKS = ['</things?offset=50&limit=50>; rel="next"; title="a, b"', "</a>;rel=prev,</b>;rel=next"]


def test_damaged_documents_of_directories(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("thing_directory", WORDS):
        body = damage.damaged_json(rng.choice(PAGES))
        link = damage.damaged_text(rng.choice(LINKS))
        with suppress(WireError):
            page = parsed(body)
            next_page(page, {"link": link})
            for document in members_of(page):
                take(document)
        stream = f"id: 1\nevent: thing_created\ndata: {json.dumps(THING)}\n\n".encode()
        with suppress(WireError):
            for event in EventStreamParser(LIMIT).feed(damage.damaged_bytes(stream)):
                read_event(event.kind, event.data)


def parsed(body: bytes) -> object:
    """Return what *body* says, which is the same in slices and in one go."""
    slices = parse_in_slices(body, LIMIT)
    found: object = None
    try:
        while True:
            next(slices)
    except StopIteration as done:
        found = done.value
    except WireError:
        with pytest.raises(WireError):
            parse_json(body, LIMIT)
        raise
    assert repr(found) == repr(parse_json(body, LIMIT))
    return found


def take(document: object) -> None:
    with suppress(WireError):
        key = id_of(document)
        assert text_of(document)
        assert 0 <= lifetime_of(document, 0.0) <= 30 * 86_400
        describe_thing(read_thing(document, "http://10.0.0.2/"), key, HTTP_BINDING)
