"""Damaged link format, CBOR and Thing Descriptions of CoAP: refused in our words, or understood."""

import json
from contextlib import suppress

from tests.fuzz.conftest import Fuzz, Mutator

from homebot.conventions.cbor import decode_cbor, encode_cbor
from homebot.conventions.coap.endpoint import endpoint_of_link
from homebot.conventions.coap.link_format import parse_links
from homebot.errors import RefusedError, WireError
from homebot.integrations.things.coap_session import COAP_BINDING
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.content_formats import coap_formats
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.formats.payload import decode_document, encode_document
from homebot.integrations.things.formats.resource_types import thing_of_links
from homebot.integrations.things.formats.thing import Thing

LINKS = (
    b'</3306/0/5850>;rt="light";if="core.a core.ll";obs;ct="50 60",'
    b'</3311/0/5851>,</3303/0/5700>;obs,</time>;obs;title="Clock \\"1\\"",</.well-known/wot>;ct=432'
)
ENDPOINTS = b'</reg/1/>;ep="lamp";d="home";base="coap://[2001:db8::1]:61616";lt=60,</reg/2/>;ep=x;con="coap://h"'
THING = {
    "@context": CONTEXT,
    "title": "Lamp",
    "securityDefinitions": {"psk_sc": {"scheme": "psk"}},
    "security": "psk_sc",
    "base": "coap://h:5683/things/",
    "properties": {
        "on": {
            "type": "object",
            "properties": {"value": {"type": "boolean"}},
            "forms": [
                {"href": "on{?x}", "cov:method": "GET", "op": "readproperty", "contentType": "application/cbor"},
                {"href": "/on", "op": ["observeproperty"], "subprotocol": "cov:observe"},
                {"href": "/on", "op": "writeproperty", "cov:method": "PUT", "response": {"contentType": "text/plain"}},
            ],
        },
        "level": {"type": "integer", "minimum": 0, "maximum": 254, "forms": [{"href": "//h2/level", "security": []}]},
    },
}
DOCUMENTS = (
    {"value": True, "n": "x", "range": [0, 100]},
    [{0: "c", 4: False, 8: "x"}],
    21.5,
)
WORDS = ("coap", "coap://h/x", "cov:observe", "readproperty", "application/cbor", "..", "//[")
TYPES = ("application/cbor", "application/json", "text/plain")


def test_damaged_links_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("coap links"):
        damaged = mutate.damaged_bytes(rng.choice((LINKS, ENDPOINTS)))
        with suppress(WireError):
            links = parse_links(damaged)
            check_parts(mutate, thing_of_links(links, {one.target: f"coap://h/{one.target}" for one in links}, "x"))
            for link in links:
                with suppress(WireError):
                    assert endpoint_of_link(link).base.isprintable()


def test_damaged_payloads_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("coap payloads"):
        document = rng.choice(DOCUMENTS)
        encoded = encode_cbor(document) if rng.random() < 0.7 else json.dumps(document, default=str).encode()
        damaged = mutate.damaged_bytes(encoded)
        found = coap_formats(rng.choice(TYPES))
        assert found is not None
        with suppress(WireError):
            found.parse(damaged)
        with suppress(WireError):
            json.dumps(decode_cbor(damaged), default=str)


def test_damaged_descriptions_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, _ in fuzz("coap things", WORDS):
        try:
            thing = read_thing(json.loads(mutate.damaged_json(json.dumps(THING))), "coap://h/.well-known/wot")
        except (WireError, ValueError):
            continue
        check_parts(mutate, thing)


def check_parts(mutate: Mutator, thing: Thing) -> None:
    for part in parts_of(thing, COAP_BINDING):
        for one in part.affordances:
            decode_document(one.capability, one.affordance, mutate.value())
            with suppress(RefusedError):
                format_ = coap_formats(one.written.content_type) if one.written is not None else None
                document = encode_document(one.capability, one.affordance, mutate.plain())
                if format_ is not None:
                    format_.encode(document)
