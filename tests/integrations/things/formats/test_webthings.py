"""Descriptions of the Web Thing API, as its libraries serve them."""

from typing import Any

import pytest

from homebot.errors import WireError
from homebot.integrations.things.formats.binding import RequestBinding
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.parse import read_thing
from homebot.integrations.things.formats.payload import decode_document, encode_document

HTTP = RequestBinding(frozenset({"http"}))


def lamp(**changes: Any) -> dict[str, Any]:
    return {
        "id": "urn:dev:ops:lamp",
        "title": "Lamp",
        "@context": "https://iot.mozilla.org/schemas",
        "@type": ["OnOffSwitch", "Light"],
        "properties": {
            "on": {
                "@type": "OnOffProperty",
                "type": "boolean",
                "links": [{"rel": "property", "href": "/properties/on"}],
            },
            "heat": {
                "type": "number",
                "unit": "degree celsius",
                "readOnly": True,
                "links": [{"href": "/properties/heat"}],
            },
            "map": {"type": "string", "links": [{"rel": "alternate", "href": "/map.png"}]},
            "odd": {"type": "string", "links": 5},
        },
        "actions": {"fade": {"links": [{"rel": "action", "href": "/actions/fade"}]}},
        "events": {"hot": {"type": "number", "links": [{"rel": "event", "href": "/events/hot"}]}},
        "links": [{"rel": "properties", "href": "/properties"}, {"rel": "alternate", "href": "ws://h/"}],
        **changes,
    }


@pytest.mark.parametrize("context", ["https://iot.mozilla.org/schemas", "https://webthings.io/schemas/"])
def test_a_web_thing_is_read_as_a_thing(context: str) -> None:
    thing = read_thing(lamp(**{"@context": context}), "http://h:8888/")
    assert thing.title == "Lamp"
    assert [(form.href, form.ops) for form in thing.forms] == [("http://h:8888/properties", ("readallproperties",))]
    light, heat = parts_of(thing, HTTP)
    assert (light.part.service_type, heat.part.service_type) == ("light", "temperature_sensor")
    (on,) = light.affordances
    assert on.written is not None
    assert on.written.href == "http://h:8888/properties/on"
    assert encode_document(on.capability, on.affordance, False) == {"on": False}
    assert decode_document(on.capability, on.affordance, {"on": True}) == (True,)
    assert decode_document(on.capability, on.affordance, True) == (True,)  # as all properties at once have it


@pytest.mark.parametrize(
    ("types", "service_type", "capability"),
    [
        (["MultiLevelSensor"], "x_sensor", "measurement"),
        (["MultiLevelSensor", "TemperatureSensor"], "x_sensor", "measurement"),
        (["WindowCovering"], "window_covering", "position"),
    ],
)
def test_a_level_that_is_only_read_is_no_blind_without_its_type(
    types: list[str], service_type: str, capability: str
) -> None:
    """As that of the humidity sensor in the examples of the libraries."""
    level = {"@type": "LevelProperty", "type": "number", "unit": "percent", "readOnly": True, "links": [{"href": "/l"}]}
    (found,) = parts_of(read_thing(lamp(**{"@type": types, "properties": {"level": level}}), "http://h/"), HTTP)
    assert (found.part.service_type, [one.name for one in found.part.capabilities]) == (service_type, [capability])


def test_the_name_of_the_first_libraries_is_a_title() -> None:
    old = lamp(name="Old lamp")
    del old["title"]
    assert read_thing(old).title == "Old lamp"


@pytest.mark.parametrize(
    "security", [{}, {"securityDefinitions": '{"nosec_sc": {"scheme": "nosec"}}', "security": "nosec_sc"}]
)
def test_the_library_for_arduino_lists_its_only_thing(security: dict[str, Any]) -> None:
    """Its ids are no URIs: two houses have a ``led``."""
    thing = read_thing([lamp(id="led", **security)])
    assert (thing.title, thing.id, len(parts_of(thing, HTTP))) == ("Lamp", "", 2)


def test_a_description_with_forms_is_no_older_one() -> None:
    contexts = ["https://www.w3.org/2022/wot/td/v1.1", "https://webthings.io/schemas"]
    with pytest.raises(WireError, match="security"):
        read_thing(lamp(**{"@context": contexts}))
