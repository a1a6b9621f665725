"""Thing Descriptions as a convention: what is heard of them, and how their parts speak and listen."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError
from tests.integrations.announced_parts import device_in

from homebot.conventions.description import DeviceAnnounced, DeviceWithdrawn, Publication
from homebot.devices import Device, DevicePart, Endpoint, Route
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.things.formats.documents import to_thing
from homebot.integrations.things.formats.mqtt import ThingDescriptions, ThingSettings
from homebot.integrations.things.formats.parse import CONTEXT
from homebot.integrations.things.formats.thing import NO_SECURITY
from homebot.messages import Time

TOPIC = "homebot/things/lamp/td"


def thing(properties: dict[str, Any], *types: str, **more: Any) -> dict[str, Any]:
    return {"@context": CONTEXT, "title": "Lamp", "@type": list(types), **NO_SECURITY, "properties": properties} | more


def prop(topic: str, kind: str = "boolean", **more: Any) -> dict[str, Any]:
    """A property that is read on *topic* and told on *topic*/set."""
    forms = [
        {"href": "mqtt://b", "op": "observeproperty", "mqv:filter": topic},
        {"href": "mqtt://b", "op": "writeproperty", "mqv:topic": f"{topic}/set", "mqv:qos": "1"},
    ]
    return {"type": kind, "forms": forms} | more


def take(description: object) -> DeviceAnnounced:
    payload = json.dumps(description).encode()
    return device_in(ThingDescriptions(ThingSettings()).read_message(TOPIC, payload, retained=True))


def test_the_description_in_the_guide_is_a_thermometer() -> None:
    guide = (Path(__file__).parents[5] / "docs" / "devices.md").read_text("utf-8")
    (shown,) = re.findall(r"```json\n(.*?)```", guide, re.DOTALL)
    (part,) = take(json.loads(shown)).parts
    assert (part.part.service_type, part.part.reads) == ("temperature_sensor", ("garage/temperature",))


def test_a_description_is_a_device() -> None:
    description = thing(
        {"on": prop("lamp/on")},
        "Light",
        id="urn:dev:mac:00158d0001abcdef",
        description="On the desk\n",
        **{"homebot:area": "Study", "homebot:facts": {"model": "X1"}, "homebot:identifiers": ["mac:aabbccddeeff", "x"]},
    )
    heard = take(description)
    assert (heard.key, heard.convention, heard.topic, heard.name, heard.area) == (
        "lamp",
        "thing",
        TOPIC,
        "Lamp",
        "Study",
    )
    assert heard.identifiers == (
        "mac:aabbccddeeff",
        "eui64:00158d0001abcdef",
        "id:x",
        "id:urn:dev:mac:00158d0001abcdef",
    )
    assert heard.implies_alive
    assert heard.facts == {"model": "X1", "description": "On the desk"}
    (lamp,) = heard.parts
    assert (lamp.part.service_type, lamp.part.reads, lamp.part.writes) == ("light", ("lamp/on",), ("lamp/on/set",))


def test_the_empty_payload_withdraws_a_description() -> None:
    convention = ThingDescriptions(ThingSettings())
    assert convention.read_message(TOPIC, b"", retained=False) == (
        DeviceWithdrawn("lamp", "its description was withdrawn"),
    )
    assert convention.read_message("homebot/things/a/b/td", b"{", retained=False) == ()
    assert convention.read_message("homebot/things/td", b"{", retained=False) == ()


def test_prefixes_can_be_chosen() -> None:
    convention = ThingDescriptions(ThingSettings(prefixes=("wot", "other/things")))
    assert convention.filters() == ("wot/+/td", "other/things/+/td")
    assert convention.birth_messages() == ()
    assert isinstance(convention.read_message("other/things/x/td", b"", retained=True)[0], DeviceWithdrawn)
    with pytest.raises(ValidationError):
        ThingSettings(prefixes=("wot/#",))


@pytest.mark.parametrize(
    ("schema", "types", "payload", "told"),
    [
        (prop("t"), "OnOffProperty", b"true", {"on_off": True}),
        (prop("t"), "OnOffProperty", b"0", {"on_off": False}),
        (prop("t"), "OnOffProperty", b"ON", {"on_off": True}),
        (prop("t"), "OnOffProperty", b"perhaps", {}),
        (prop("t"), "OnOffProperty", b"null", {"on_off": None}),
        (prop("t", "string", enum=["AN", "AUS"]), "OnOffProperty", b'"AUS"', {"on_off": True}),
        (prop("t", "string", enum=["OFF", "ON"]), "OnOffProperty", b"OFF", {"on_off": False}),
        (prop("t", "integer", minimum=0, maximum=254), "BrightnessProperty", b"127", {"level": 50.0}),
        (prop("t", "integer", minimum=0, maximum=254), "BrightnessProperty", b"999", {"level": 100.0}),
        (prop("t", "number"), "BrightnessProperty", b"40", {"level": 40.0}),
        (prop("t", "number"), "BrightnessProperty", b"1e999", {"level": None}),
        (prop("t", "integer", unit="mired"), "ColorTemperatureProperty", b"370", {"color_temperature": 2703.0}),
        (prop("t", "integer", unit="mired"), "ColorTemperatureProperty", b"0", {}),
        (prop("t", "integer", unit="kelvin"), "ColorTemperatureProperty", b"2700", {"color_temperature": 2700.0}),
        (prop("t", "string"), "ColorProperty", b'"#00ff00"', {"color": (120.0, 100.0)}),
        (prop("t", "string"), "ColorProperty", b'"green"', {}),
        (prop("t", "number", unit="degree fahrenheit"), "TemperatureProperty", b"68", {"temperature": 20.0}),
        (prop("t", "number", minimum=0, maximum=1), "HumidityProperty", b"0.5", {"humidity": 50.0}),
        (prop("t", "number", minimum=10, maximum=90), "HumidityProperty", b"50", {"humidity": 50.0}),
        (prop("t", "string", enum=["locked", "unlocked", "jammed"]), "LockedProperty", b'"JAMMED"', {"lock": "jammed"}),
        (prop("t"), "LockedProperty", b"false", {"lock": "unlocked"}),
        (prop("t", "string"), "", b'"hi \\u0007there"', {"text": "hi there"}),
        (prop("t", "object"), "", b'{"a": [1]}', {"raw": '{"a": [1]}'}),
        (prop("t", "object"), "", b"\xff\xfe", {"raw": "\ufffd\ufffd"}),
        (prop("t", "number"), "", b"[" * 100_000, {}),
        (prop("t", "string"), "", b'"' + b"x" * 300_000 + b'"', {}),
    ],
)
def test_values_of_a_thing_are_read_in_the_vocabularys_units(
    schema: dict[str, Any], types: str, payload: bytes, told: dict[str, PlainValue]
) -> None:
    """JSON as its schema says, or bare words; what cannot be meant says nothing."""
    (part,) = take(thing({"p": schema | {"@type": types}})).parts
    assert dict(part.codec.read("t", payload, retained=False)) == told
    assert dict(part.codec.read("other", payload, retained=False)) == {}


@pytest.mark.parametrize(
    ("schema", "types", "capability", "value", "payload"),
    [
        (prop("t"), "OnOffProperty", "on_off", True, b"true"),
        (prop("t", "string", enum=["OFF", "ON"]), "OnOffProperty", "on_off", False, b'"OFF"'),
        (prop("t", "integer", minimum=0, maximum=254), "BrightnessProperty", "level", 50.0, b"127"),
        (prop("t", "number", minimum=0, maximum=1), "BrightnessProperty", "level", 12.5, b"0.125"),
        (prop("t", "integer", unit="mired"), "ColorTemperatureProperty", "color_temperature", 2700.0, b"370"),
        (prop("t", "string"), "ColorProperty", "color", (240.0, 100.0), b'"#0000ff"'),
        (prop("t", "number", unit="°F"), "TargetTemperatureProperty", "heating_setpoint", 20.0, b"68"),
        (prop("t", "string", enum=["locked", "unlocked"]), "LockedProperty", "lock", "locked", b'"locked"'),
        (prop("t"), "LockedProperty", "lock", "unlocked", b"false"),
        (prop("t", "string", enum=["eco", "max"]), "", "option", "eco", b'"eco"'),
        (prop("t", "integer"), "", "number", 7.0, b"7"),
        (prop("t", "string"), "", "text", "ä", '"ä"'.encode()),
    ],
)
def test_a_command_is_encoded_by_the_schema(
    schema: dict[str, Any], types: str, capability: str, value: PlainValue, payload: bytes
) -> None:
    (part,) = take(thing({"p": schema | {"@type": types}})).parts
    assert part.codec.write(capability, value, transition=3) == (Publication("t/set", payload, 1),)


@pytest.mark.parametrize(
    ("schema", "types", "capability", "value", "problem"),
    [
        (prop("t"), "OnOffProperty", "on_off", "on", "it takes true or false"),
        (prop("t"), "OnOffProperty", "level", 5.0, "this part takes on_off"),
        (prop("t", "number"), "BrightnessProperty", "level", 101.0, "it takes a number from 0 to 100"),
        (prop("t", "number", minimum=5, maximum=30), "", "number", 31.0, "it takes a number from 5 to 30"),
        (prop("t", "number"), "", "number", float("nan"), "it takes a number"),
        (prop("t", "string"), "ColorProperty", "color", (400.0, 0.0), "it takes numbers from 0 to 360"),
        (prop("t"), "LockedProperty", "lock", "open", "it takes locked, unlocked"),
        (prop("t", "string", enum=["eco", "max"]), "", "option", "party", "it takes eco, max"),
    ],
)
def test_an_invalid_value_of_a_part_is_refused(
    schema: dict[str, Any], types: str, capability: str, value: PlainValue, problem: str
) -> None:
    (part,) = take(thing({"p": schema | {"@type": types}})).parts
    with pytest.raises(RefusedError, match=problem):
        part.codec.write(capability, value)


def test_plain_text_is_sent_unchanged() -> None:
    schema = prop("t", "string", enum=["on", "off"], **{"@type": "OnOffProperty"})
    for form in schema["forms"]:
        form["contentType"] = "text/plain"
    (part,) = take(thing({"p": schema})).parts
    assert part.codec.write("on_off", True) == (Publication("t/set", b"on", 1),)
    assert part.codec.read("t", b"off", retained=True) == {"on_off": False}


@pytest.mark.parametrize(
    ("capability", "value", "written"),
    [
        ("level", 40.0, (("dim/set", b"40"), ("on/set", b"true"))),
        ("level", 0.0, (("on/set", b"false"),)),
        ("color", (240.0, 100.0), (("hue/set", b'"#0000ff"'), ("on/set", b"true"))),
        ("on_off", False, (("on/set", b"false"),)),
    ],
)
def test_a_lamp_with_a_switch_of_its_own_is_also_switched_on(
    capability: str, value: PlainValue, written: tuple[tuple[str, bytes], ...]
) -> None:
    """Its brightness is another property, and changes while the lamp is off and stays so."""
    lamp = {
        "on": prop("on") | {"@type": "OnOffProperty"},
        "dim": prop("dim", "number") | {"@type": "BrightnessProperty"},
        "hue": prop("hue", "string") | {"@type": "ColorProperty"},
    }
    (part,) = take(thing(lamp)).parts
    assert part.codec.write(capability, value) == tuple(Publication(topic, payload, 1) for topic, payload in written)


def test_actions_are_pushed_and_kept_events_are_none() -> None:
    heard = take(
        thing(
            {},
            actions={"blink": {"forms": [{"href": "mqtt://b/lamp/blink"}]}},
            events={"hot": {"data": {"type": "string"}, "forms": [{"href": "mqtt://b", "mqv:filter": "lamp/+/hot"}]}},
        )
    )
    blink, hot = heard.parts
    assert blink.codec.write("push", True) == (Publication("lamp/blink", b""),)
    with pytest.raises(RefusedError, match="it takes only true"):
        blink.codec.write("push", False)
    assert hot.codec.read("lamp/1/hot", b'"very"', retained=False) == {"press": "very"}
    assert hot.codec.read("lamp/1/hot", b'"very"', retained=True) == {}


def test_parts_of_other_protocols_or_payloads_are_neither_read_nor_set() -> None:
    """A house's own lamp, exported and imported elsewhere, is not told what its own convention would spell."""
    part = Part(
        id="",
        service_type="light",
        capabilities=(Capability(name="on_off", settable=True),),
        reads=("zigbee2mqtt/lamp",),
        writes=("zigbee2mqtt/lamp/set",),
    )
    route = Route(gateway="mqtt", key="k", part="", convention="zigbee2mqtt")
    now = Time(sec=0, nanosec=0)
    device = Device(
        id="lamp",
        name="Lamp",
        service_type="light",
        endpoints=(Endpoint(gateway="mqtt", key="k", address="", command_address=""),),
        metadata=(),
        first_seen=now,
        last_seen=now,
        expires=now,
        freshness="fresh",
        parts=(DevicePart(id="", part=part, routes=(route,)),),
    )
    web = {"type": "boolean", "@type": "OnOffProperty", "forms": [{"href": "https://lamp.local/on"}]}
    for description in (to_thing(device, {}), thing({"on": web}, "Light")):
        (found,) = take(description).parts
        assert found.part.service_type == "light"
        (on_off,) = found.part.capabilities
        assert (on_off.readable, on_off.settable, found.part.reads, found.part.writes) == (False, False, (), ())
        assert found.codec.topics() == ()
        with pytest.raises(RefusedError, match="this part takes nothing"):
            found.codec.write("on_off", True)


@pytest.mark.parametrize(
    ("description", "problem"),
    [
        (b"{", "is not JSON"),
        (b"[" * 100_000, "nested deeper than 64 levels"),
        (b" " * 600_000, "a payload of 600000 bytes is longer than"),
        (b"5", "is not a JSON object"),
        (thing({"on": prop("#")}), "the topic of on: '#' names more than one Thing"),
        (thing({"on": prop("$SYS/x")}), "names more than one Thing"),
        (thing({"on": prop("a/#/b")}), "the topic of on: "),
        (
            thing({"on": {"type": "boolean", "forms": [{"href": "mqtt://b", "mqv:topic": "a/+/set"}]}}),
            "the topic of on: ",
        ),
    ],
)
def test_a_broken_description_is_refused_and_counted(description: Any, problem: str) -> None:
    convention = ThingDescriptions(ThingSettings())
    payload = description if isinstance(description, bytes) else json.dumps(description).encode()
    with pytest.raises(WireError, match="(?s).*" + problem.replace("$", r"\$")):
        convention.read_message(TOPIC, payload, retained=True)
    assert convention.rejected == 1
