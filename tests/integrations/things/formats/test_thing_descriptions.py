"""Thing Descriptions: what is read of them, what is refused, and that devices survive the way out and back."""

import copy
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices import Device, DevicePart, Endpoint
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.names import text_address
from homebot.devices.part import Capability, Part
from homebot.errors import WireError
from homebot.integrations.things.formats.binding import ClassifiedPart
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.documents import to_thing
from homebot.integrations.things.formats.mqtt.reader import MqttBinding
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.formats.payload import PayloadFormat, basic_formats
from homebot.messages import Time

NOW = Time(sec=1_800_000_000, nanosec=0)


def any_format(content_type: str) -> PayloadFormat | None:
    """Understand what conventions spell as well."""
    return basic_formats(content_type) or basic_formats("text/plain")


MQTT = MqttBinding(any_format)
BROKERS = {"mqtt": "mqtt://broker:1883"}


def device(*parts: DevicePart, **more: Any) -> Device:
    made = Device(
        id="kitchen/lamp 1",
        name="Kitchen lamp",
        service_type="light",
        endpoints=(Endpoint(gateway="mqtt", key="k", address="home/l/out", command_address="home/l/in"),),
        metadata=(),
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness="fresh",
        parts=parts,
    )
    return made.model_copy(update=more)


def test_an_id_is_spelt_for_an_address() -> None:
    assert to_thing(device(), BROKERS)["id"] == "urn:homebot:kitchen%2Flamp%201"


@pytest.mark.parametrize(
    ("topic", "path"),
    [
        ("home/l/out", "/home/l/out"),
        ("Küche 1/?#%", "/K%C3%BCche%201/%3F%23%25"),
        ("/absolute//twice/", "//absolute//twice/"),
        ("a+b/$x", "/a+b/$x"),
    ],
)
def test_the_topic_is_in_the_path_of_the_address_too_for_consumers_that_look_there_alone(topic: str, path: str) -> None:
    """Node-wot 0.9 is one: without a path it subscribes to an empty filter, for which a broker ends the connection."""
    endpoint = Endpoint(gateway="mqtt", key="k", address=topic, command_address="")
    made = to_thing(device(endpoints=(endpoint,)), {"mqtt": "mqtt://broker:1883/"})
    (affordance,) = json.loads(json.dumps(made))["properties"].values()
    (form,) = affordance["forms"]
    assert (form["href"], form["mqv:filter"]) == (f"mqtt://broker:1883{path}", topic)
    del form["mqv:filter"]
    (meant,) = parts_of(read_thing(made | {"properties": {"state": affordance}}), MQTT)
    assert meant.part.reads == (topic,)


def test_a_device_without_parts_is_described_by_its_words() -> None:
    """Plain text, on the two topics of the thesis; an address of homebot's own is no topic."""
    made = to_thing(device(), {})
    (meant,) = parts_of(read_thing(made), MQTT)
    assert (meant.part.reads, meant.part.writes) == (("home/l/out",), ("home/l/in",))
    words = text_address("k", "p")
    endpoint = Endpoint(gateway="mqtt", key="k", address=words, command_address=words)
    assert to_thing(device(endpoints=(endpoint,)), {})["properties"] == {}


def _topics() -> st.SearchStrategy[tuple[str, ...]]:
    return st.lists(st.sampled_from(["a/b", "home/x", "z/1/state", "ä/ö"]), min_size=1, max_size=2, unique=True).map(
        tuple
    )


_texts = st.text(st.characters(codec="utf-8", categories=["L", "N"]), max_size=8)
_numbers = st.floats(-1000, 1000).map(lambda one: round(one, 3))


@st.composite
def _capabilities(draw: st.DrawFn) -> Capability:
    name = draw(st.sampled_from(sorted(CAPABILITIES)))
    kind = CAPABILITIES[name].kind
    readable = draw(st.booleans())
    return Capability(
        name=name,
        readable=readable,
        settable=not readable or draw(st.booleans()),
        unit=draw(st.sampled_from(["", "lqi", "°C"])) if kind == "number" and not CAPABILITIES[name].unit else "",
        bounds=tuple(sorted(draw(st.tuples(_numbers, _numbers)))) if kind == "number" and draw(st.booleans()) else (),
        options=tuple(draw(st.lists(_texts.filter(bool), unique=True, max_size=3))) if kind == "text" else (),
    )


@st.composite
def _parts(draw: st.DrawFn) -> tuple[DevicePart, ...]:
    parts = []
    for part_id in draw(st.lists(_texts, unique=True, min_size=1, max_size=4)):
        capabilities = tuple(draw(st.lists(_capabilities(), min_size=1, max_size=4, unique_by=lambda one: one.name)))
        part = Part(
            id=part_id,
            name=draw(_texts),
            service_type=draw(st.sampled_from(sorted(DEVICE_TYPES))),
            advertised=draw(_texts),
            tag=draw(_texts),
            category=draw(st.sampled_from(["", "config", "diagnostic"])),
            guessed=draw(st.booleans()),
            capabilities=capabilities,
            reads=draw(_topics()) if any(one.readable for one in capabilities) else (),
            writes=draw(_topics()) if any(one.settable for one in capabilities) else (),
        )
        parts.append(DevicePart(id=part_id, part=part, routes=()))
    return tuple(parts)


def _without_defaults(part: Part) -> Part:
    """Bounds and options that the vocabulary has anyway need not be said."""
    capabilities = [
        one.model_copy(
            update={
                "bounds": () if one.bounds == CAPABILITIES[one.name].bounds else one.bounds,
                "options": () if one.options == CAPABILITIES[one.name].options else one.options,
            }
        )
        for one in part.capabilities
    ]
    return part.model_copy(update={"capabilities": tuple(capabilities), "payloads": ""})


@given(_parts(), _texts)
def test_every_device_survives_the_way_out_and_back(parts: tuple[DevicePart, ...], area: str) -> None:
    """As JSON text in between; and what comes out keeps the rules that are asked of others."""
    made = json.loads(json.dumps(to_thing(device(*parts, area=area, identifiers=("mac:aabbccddeeff",)), BROKERS)))
    thing = read_thing(made)
    assert (thing.title, thing.area, thing.identifiers) == ("Kitchen lamp", area, ("mac:aabbccddeeff",))
    found = [meant.part.model_copy(update={"payloads": ""}) for meant in parts_of(thing, MQTT)]
    assert found == [_without_defaults(one.part) for one in parts]


def lamp() -> dict[str, Any]:
    """A description as somebody else writes it, with everything that TD 1.1 has for MQTT."""
    return {
        "@context": [CONTEXT, {"iot": "http://iotschema.org/"}],
        "id": "urn:dev:ops:32473-lamp",
        "title": "Desk lamp",
        "@type": ["OnOffSwitch", "Light"],
        "description": "A lamp on a desk.",
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": ["nosec_sc"],
        "base": "mqtt://broker:1883/",
        "properties": {
            "on": {
                "@type": "OnOffProperty",
                "type": "boolean",
                "forms": [
                    {
                        "href": "",
                        "op": ["readproperty", "observeproperty"],
                        "mqv:filter": "lamp/on",
                        "mqv:retain": True,
                    },
                    {"href": "mqtt://broker:1883", "op": "writeproperty", "mqv:topic": "lamp/on/set", "mqv:qos": "1"},
                ],
            },
            "brightness": {
                "@type": "iot:BrightnessProperty",
                "type": "integer",
                "minimum": 0,
                "maximum": 254,
                "forms": [{"href": "mqtt://broker/lamp/brightness"}],
            },
            "powerOn": {"type": "boolean", "forms": [{"href": "https://lamp.local/powerOn"}]},
            "roomTemperature": {"type": "number", "readOnly": True, "forms": [{"href": "mqtt://broker/lamp/t"}]},
        },
        "actions": {"blink": {"input": {"type": "integer"}, "forms": [{"href": "mqtt://broker/lamp/blink"}]}},
        "events": {
            "overheated": {"data": {"type": "number"}, "forms": [{"href": "mqtt://b", "mqv:filter": "lamp/hot"}]}
        },
    }


def of(parts: tuple[ClassifiedPart, ...]) -> dict[str, tuple[str, list[str]]]:
    return {one.part.id: (one.part.service_type, [each.name for each in one.part.capabilities]) for one in parts}


def test_semantic_types_come_first_then_names_then_types_of_values() -> None:
    """What is known of nothing has a capability of general meaning, and says that it is a guess."""
    parts = parts_of(read_thing(lamp()), MQTT)
    assert of(parts) == {
        "": ("light", ["on_off", "level"]),
        "powerOn": ("x_binary_sensor", ["state"]),
        "roomTemperature": ("x_sensor", ["measurement"]),
        "blink": ("generic_switch", ["number"]),
        "overheated": ("generic_switch", ["press"]),
    }
    main = parts[0].part
    assert (main.reads, main.writes) == (("lamp/on", "lamp/brightness"), ("lamp/on/set", "lamp/brightness"))
    assert (main.advertised, main.guessed) == ("OnOffSwitch", False)
    assert [one.part.guessed for one in parts[1:3]] == [True, True]


@pytest.mark.parametrize(
    ("types", "properties", "expected"),
    [
        ([], {"on": "boolean", "level": "number"}, {"": ("light", ["on_off", "level"])}),
        ([], {"switch": "boolean"}, {"": ("switch", ["on_off"])}),
        (["SmartPlug"], {"on": "boolean", "voltage": "number"},
         {"": ("plug", ["on_off"]), "voltage": ("electrical_meter", ["voltage"])}),
        (["Thermostat"], {"temperature": "number", "targetTemperature": "number"},
         {"": ("thermostat", ["local_temperature", "heating_setpoint"])}),
        (["iot:Lock"], {"locked": "string"}, {"": ("door_lock", ["lock"])}),
        (["WindowCovering"], {"position": "integer"}, {"": ("window_covering", ["position"])}),
        ([], {"temperature": "number", "humidity": "number"},
         {"temperature": ("temperature_sensor", ["temperature"]), "humidity": ("humidity_sensor", ["humidity"])}),
        ([], {"sht/temperature": "number"}, {"sht/temperature": ("temperature_sensor", ["temperature"])}),
        ([], {"colour": "string", "brightness": "number", "on": "boolean"},
         {"": ("light", ["color", "level", "on_off"])}),
    ],
)  # fmt: skip
def test_a_thing_has_the_type_of_its_types_or_properties(
    types: list[str], properties: dict[str, str], expected: dict[str, tuple[str, list[str]]]
) -> None:
    thing = lamp() | {"@type": types, "actions": {}, "events": {}}
    thing["properties"] = {
        name: {"type": kind, "forms": [{"href": f"mqtt://b/{name}"}]} for name, kind in properties.items()
    }
    assert of(parts_of(read_thing(thing), MQTT)) == expected


@pytest.mark.parametrize(
    ("form", "expected"),
    [
        ({"href": "mqtt://b", "mqv:topic": "t"}, ("t", "t", 0, False)),
        ({"href": "mqtt://b", "mqv:topic": "t", "mqv:controlPacket": "mqv:subscribe"}, ("t", "", 0, False)),
        ({"href": "mqtt://b", "mqv:topic": "t", "mqv:controlPacket": "publish"}, ("", "t", 0, False)),
        ({"href": "mqtt://b:1884", "mqv:filter": ["f", "g"], "mqv:qos": "quality:2"}, ("f", "", 2, False)),
        ({"href": "mqtts://b/a%20b/c", "mqv:retain": "true", "mqv:qos": 1}, ("a b/c", "a b/c", 1, True)),
        (
            {"href": "mqtts://b/a", "mqv:filter": "f", "op": "observeproperty", "mqv:retain": "false"},
            ("f", "", 0, False),
        ),
        ({"href": "mqtt://b"}, ("", "", 0, False)),
        ({"href": "/a", "op": "writeproperty"}, ("", "a", 0, False)),
    ],
)
def test_topics_are_where_descriptions_in_the_wild_have_them(
    form: dict[str, Any], expected: tuple[str, str, int, bool]
) -> None:
    """In the terms of this draft of the binding, of older ones, or in the path of the address."""
    (on, *_) = read_thing(changed("properties/on/forms", [form])).affordances
    (found,) = on.forms
    assert (found.filter, found.topic, found.qos, found.retain) == expected


def test_two_of_one_kind_are_two_parts() -> None:
    """None is lost."""
    thing = lamp()
    thing["properties"]["on2"] = copy.deepcopy(thing["properties"]["on"])
    assert of(parts_of(read_thing(thing), MQTT))["on2"] == ("switch", ["on_off"])


def changed(path: str, value: object) -> dict[str, Any]:
    """The lamp with one thing different; None takes it away."""
    thing = lamp()
    *way, last = path.split("/")
    where: Any = thing
    for step in way:
        where = where[int(step) if step.isdigit() else step]
    if value is None:
        del where[last]
    else:
        where[last] = value
    return thing


@pytest.mark.parametrize(
    ("path", "value", "problem"),
    [
        ("@context", None, "@context: must contain https://www.w3.org/2022/wot/td/v1.1"),
        ("@context", ["https://schema.org"], "@context: must contain https://www.w3.org/2022/wot/td/v1.1"),
        ("title", None, "title: is missing; expected a text"),
        ("base", "http://[x", "base: 'http://[x' is not an address"),
        ("title", 5, "title: expected a text, got 5"),
        ("security", None, "security: is missing"),
        ("security", "basic_sc", "security: 'basic_sc' is not in securityDefinitions"),
        ("securityDefinitions", [], "securityDefinitions: expected an object, got a list"),
        ("securityDefinitions/nosec_sc", {}, "securityDefinitions.nosec_sc.scheme: is missing; expected a text"),
        ("properties", "on", "properties: expected an object, got 'on'"),
        ("properties/on", 1, "properties.on: expected an object, got 1"),
        ("properties/on/forms", None, "properties.on.forms: is empty; give at least one form"),
        ("properties/on/forms", [{"op": "readproperty"}], "properties.on.forms[0].href: is missing"),
        (
            "properties/on/forms",
            [{"href": "x", "op": "invokeaction"}],
            "properties.on.forms[0].op: 'invokeaction' is none",
        ),
        (
            "properties/on/forms",
            [{"href": "mqtt://[", "op": "readproperty"}],
            "properties.on.forms[0].href: 'mqtt://['",
        ),
        ("properties/on/forms", [{"href": "x", "mqv:qos": 3}], "properties.on.forms[0].mqv:qos: 0, 1 or 2 is expected"),
        (
            "properties/on/forms",
            [{"href": "x", "mqv:retain": "yes"}],
            "properties.on.forms[0].mqv:retain: expected true or false",
        ),
        ("properties/on/type", "bool", "properties.on.type: 'bool' is none of boolean, integer, number"),
        ("properties/on/readOnly", 1, "properties.on.readOnly: expected true or false, got 1"),
        ("properties/on/enum", [], "properties.on.enum: at least one value is expected"),
        ("properties/brightness/minimum", 255, "properties.brightness.minimum: 255 is above the maximum 254"),
        ("properties/brightness/maximum", "x", "properties.brightness.maximum: expected a number, got 'x'"),
        ("properties/brightness/maximum", 10**400, "properties.brightness.maximum: expected a finite number"),
        ("actions/blink/input", 3, "actions.blink.input: expected an object, got 3"),
        (
            "events/overheated/forms/0/op",
            "observeproperty",
            "events.overheated.forms[0].op: 'observeproperty' is none of",
        ),
        ("@type", [1], "@type: expected a text or a list of texts, got a list"),
        ("properties/x\u202e\n", {}, "properties.'x\\u202e\\n'.forms: is empty"),
        ("properties", {str(n): {} for n in range(301)}, "properties: 301 is too many; the limit is 300"),
        ("properties/" + "x" * 201, {}, "a name of at most 200 characters is expected"),
    ],
)
def test_an_invalid_field_is_named_in_the_refusal(path: str, value: object, problem: str) -> None:
    with pytest.raises(WireError) as caught:
        read_thing(changed(path, value))
    assert str(caught.value).startswith(problem) or (problem.startswith("a name") and problem in str(caught.value))
    assert len(str(caught.value)) < 300


def test_read_only_and_write_only_exclude_each_other() -> None:
    thing = changed("properties/on/readOnly", True)
    thing["properties"]["on"]["writeOnly"] = True
    with pytest.raises(WireError, match=r"properties\.on\.writeOnly: readOnly and writeOnly exclude each other"):
        read_thing(thing)
