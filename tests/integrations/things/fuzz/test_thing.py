"""Damaged Thing Descriptions: refused in our words, or understood."""

import json
from typing import Any

from tests.fuzz.conftest import Fuzz, fuzz_convention

from homebot.integrations.things.formats.mqtt import ThingDescriptions, ThingSettings
from homebot.integrations.things.formats.parse import CONTEXT


def prop(topic: str, **more: Any) -> dict[str, Any]:
    forms = [
        {"href": "mqtt://b", "op": ["observeproperty", "readproperty"], "mqv:filter": topic, "mqv:retain": True},
        {"href": "mqtt://b", "op": "writeproperty", "mqv:topic": f"{topic}/set", "mqv:qos": "1"},
    ]
    return {"title": "P", "forms": forms, **more}


def thing(properties: dict[str, Any], *types: str) -> dict[str, Any]:
    return {
        "@context": CONTEXT,
        "id": "urn:dev:mac:00158d0001abcdef",
        "title": "Thing",
        "@type": list(types),
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": ["nosec_sc"],
        "base": "mqtt://b/",
        "properties": properties,
        "actions": {"go": {"forms": [{"href": "mqtt://b", "op": "invokeaction", "mqv:topic": "t/go"}]}},
        "events": {"rang": {"data": {"type": "string"}, "forms": [{"href": "mqtt://b", "mqv:filter": "t/rang"}]}},
    }


THINGS = [
    thing({"on": prop("t/on", type="boolean", **{"@type": "OnOffProperty"})}, "Light", "OnOffSwitch"),
    thing(
        {
            "level": prop("t/level", type="integer", minimum=0, maximum=100, unit="percent"),
            "color": prop("t/color", type="string", **{"@type": "ColorProperty"}),
            "mode": prop("t/mode", type="string", enum=["a", "b"]),
        },
        "Light",
    ),
    thing({"temperature": prop("t/t", type="number", unit="degree celsius", readOnly=True)}, "TemperatureSensor"),
    thing({"state": prop("t/s", type="object", properties={"x": {"type": "number"}})}),
]
ROWS = [
    {"messages": [["homebot/things/lamp/td", json.dumps(one)]], "says": [["", "true"], ["", "0.5"], ["", '"a"']]}
    for one in THINGS
]


def test_damaged_descriptions_are_refused_or_read(fuzz: Fuzz) -> None:
    fuzz_convention(fuzz, "thing", lambda: ThingDescriptions(ThingSettings()), ROWS)
