"""A Thing Description all the way: onto the broker, through the gateway, and back to the thing; in virtual time."""

import json
from typing import Any

import pytest
from tests.gateways.mqtt.simple_house import simple_house

from homebot.wot.parse import CONTEXT

pytestmark = pytest.mark.virtual_time

CONVENTION = "homebot.wot.mqtt:ThingDescriptions"
TOPIC = "homebot/things/desk/td"
KEY = "thing:desk"


def description(**more: Any) -> str:
    brightness = {"@type": "BrightnessProperty", "type": "integer", "minimum": 0, "maximum": 254}
    on = {"@type": "OnOffProperty", "type": "boolean"}
    return json.dumps(
        {
            "@context": CONTEXT,
            "title": "Desk lamp",
            "@type": "Light",
            "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
            "security": "nosec_sc",
            "properties": {
                "on": on
                | {
                    "forms": [
                        {"href": "mqtt://b", "op": "observeproperty", "mqv:filter": "desk/on"},
                        {"href": "mqtt://b", "op": "writeproperty", "mqv:topic": "desk/on/set"},
                    ]
                },
                "brightness": brightness | {"forms": [{"href": "mqtt://b/desk/brightness"}]},
            },
        }
        | more
    )


async def test_an_imported_thing_is_sighted_heard_and_told() -> None:
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.listen("desk/on/set", "desk/brightness")
        await house.say(TOPIC, description(), retain=True)
        (sighting,) = house.sighted()
        assert (sighting.key, sighting.name, sighting.service_type, sighting.announced_on) == (
            KEY,
            "Desk lamp",
            "light",
            TOPIC,
        )

        await house.say("desk/on", "true")
        await house.say("desk/brightness", "127")
        assert house.told() == [(KEY, {".on_off": True}, False), (KEY, {".level": 50.0}, False)]
        await house.heard()

        assert (await house.command(KEY, "", "level", 20.0)).success
        assert (await house.command(KEY, "", "on_off", False)).success
        assert [(one.topic, one.payload) for one in await house.heard()] == [
            ("desk/brightness", b"51"),
            ("desk/on/set", b"true"),
            ("desk/on/set", b"false"),
        ]
        refused = await house.command(KEY, "", "color", (1.0, 1.0))
        assert (refused.problem, refused.message) == ("refused", "'color' was refused: this part takes on_off, level")


async def test_a_broken_description_affects_no_other_device() -> None:
    """What was described before stays; where too much is broken is told, and listened to a little at a time."""
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say(TOPIC, description(), retain=True)
        for number in range(600):
            await house.say(TOPIC, description(title=number))
        await house.say("homebot/things/other/td", description(title="Other"))
        assert [one.key for one in house.sighted() if one.kind == "appeared"] == [KEY, "thing:other"]
        health = await house.health()
        assert [one.offender for one in health.quarantined] == [TOPIC]
        assert "title: expected a text, got" in health.quarantined[0].why
