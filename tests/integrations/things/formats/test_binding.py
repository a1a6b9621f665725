"""Forms of protocols with requests: which can be used, and their addresses."""

from typing import Any

import pytest

from homebot.integrations.things.formats.binding import RequestBinding
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.formats.payload import decode_document, encode_document
from homebot.integrations.things.formats.thing import Thing

WEB = RequestBinding(frozenset({"http", "https"}), ("sse",))


def thing(on_forms: list[dict[str, Any]], source: str = "", **more: Any) -> Thing:
    description = {
        "@context": CONTEXT,
        "title": "Lamp",
        "securityDefinitions": {
            "nosec_sc": {"scheme": "nosec"},
            "key": {"scheme": "apikey", "in": "query", "name": "k"},
        },
        "security": "nosec_sc",
        "properties": {"on": {"type": "boolean", "forms": on_forms}},
    }
    return read_thing(description | more, source)


@pytest.mark.parametrize(
    ("source", "base", "href", "expected"),
    [
        ("http://lamp/.well-known/wot", "", "/on", "http://lamp/on"),
        ("http://lamp/things/1", "", "on", "http://lamp/things/on"),
        ("http://lamp/td", "https://other:8080/a/", "on", "https://other:8080/a/on"),
        ("coap://[fe80::1%25e0]:5683/td", "", "/on", "coap://[fe80::1%25e0]:5683/on"),
        ("coap+tcp://lamp/td", "", "../on?x=1", "coap+tcp://lamp/on?x=1"),
        ("", "coap://lamp", "on{?step,unit}", "coap://lamp/on"),
        ("", "", "/on", "/on"),
        ("http://lamp/td", "", "http://b/{id}", "http://b/{id}"),
        ("http://lamp/td", "", "//other/on", "http://other/on"),
    ],
)
def test_addresses_of_any_scheme_are_resolved(source: str, base: str, href: str, expected: str) -> None:
    (on,) = thing([{"href": href}], source, base=base).affordances
    assert on.forms[0].href == expected


def test_only_forms_that_the_protocol_can_use_count_and_the_best_comes_first() -> None:
    (on,) = thing(
        [
            {"href": "coap://lamp/on"},
            {"href": "http://lamp/{id}"},
            {"href": "http://lamp/on", "contentType": "application/exi"},
            {"href": "http://lamp/on", "op": "observeproperty", "subprotocol": "longpoll"},
            {"href": "http://lamp/events", "op": "observeproperty", "subprotocol": "sse"},
            {"href": "ws://lamp/on", "op": "observeproperty", "subprotocol": "webthing"},
            {"href": "http://lamp/on", "op": "observeproperty"},
            {"href": "http://lamp/on", "op": ["readproperty"], "response": {"contentType": "text/plain"}},
            {"href": "http://lamp/on/set", "op": "writeproperty", "htv:methodName": "post"},
        ]
    ).affordances
    assert [one.subprotocol for one in WEB.push_forms(on)] == ["sse"]
    assert [(one.href, one.response_type) for one in WEB.read_forms(on)] == [("http://lamp/on", "text/plain")]
    assert [(one.href, one.method) for one in WEB.write_forms(on)] == [("http://lamp/on/set", "POST")]
    assert WEB.observe_forms(on) == (*WEB.push_forms(on), *WEB.read_forms(on))


def test_unusable_forms_are_neither_read_nor_written() -> None:
    (part,) = parts_of(thing([{"href": "coap://lamp/on"}]), WEB)
    (on_off,) = part.part.capabilities
    assert (on_off.readable, on_off.settable, part.affordances[0].observed) == (False, False, None)


def test_security_is_that_of_the_form_or_else_of_the_thing() -> None:
    found = thing([{"href": "/a"}, {"href": "/b", "security": ["key"]}])
    assert [one.security for one in found.affordances[0].forms] == [("nosec_sc",), ("key",)]
    assert found.security["key"] == "apikey"


def test_many_forms_are_read_up_to_a_limit() -> None:
    """A server lists one per address, protocol and content type."""
    forms = [{"href": f"http://[fd00::{number:x}]/a", "op": "readproperty"} for number in range(300)]
    found = thing(forms)
    assert len(found.affordances[0].forms) == 100
    assert found.affordances[0].forms[40].href == "http://[fd00::28]/a"


def test_an_object_with_one_member_stands_for_that_member() -> None:
    """As many small servers spell a switch: {"value": true}."""
    schema = {"type": "object", "properties": {"value": {"type": "boolean"}}, "@type": "OnOffProperty"}
    forms = [{"href": "http://lamp/on"}]
    found = thing(forms, properties={"p": schema | {"forms": forms}})
    (part,) = parts_of(found, WEB)
    (on_off,) = part.affordances
    assert on_off.capability.name == "on_off"
    assert decode_document(on_off.capability, on_off.affordance, {"value": True, "n": "x"}) == (True,)
    assert decode_document(on_off.capability, on_off.affordance, {"n": "x"}) is None
    assert encode_document(on_off.capability, on_off.affordance, False) == {"value": False}
