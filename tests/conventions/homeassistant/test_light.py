from collections.abc import Mapping
from itertools import permutations

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.light import build_light
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

JSON = {
    "schema": "json",
    "command_topic": "z/lamp/set",
    "state_topic": "z/lamp",
    "brightness": True,
    "brightness_scale": 254,
    "supported_color_modes": ["xy", "color_temp"],
    "min_mireds": 150,
    "max_mireds": 500,
    "effect": True,
    "effect_list": ["blink", "breathe"],
}
BASIC = {"command_topic": "a/set"}
TEMPLATE = {**BASIC, "schema": "template", "command_on_template": "on", "command_off_template": "off"}


def lamp(fields: Mapping[str, object]) -> DescribedPart:
    return build_light(DiscoveryConfig("light", "x", fields))


def payload(part: DescribedPart, capability: str, value: PlainValue, transition: float = 0.0) -> bytes:
    (publication,) = part.codec.write(capability, value, transition=transition)
    return publication.payload


def test_a_lamp_offers_what_its_modes_allow() -> None:
    capabilities = {one.name: one for one in lamp(JSON).part.capabilities}
    assert list(capabilities) == ["on_off", "level", "color_temperature", "color", "effect"]
    assert capabilities["color_temperature"].bounds == (1997.0, 6666.0)
    assert capabilities["effect"].options == ("blink", "breathe")
    assert all(one.readable and one.settable for one in capabilities.values())


@pytest.mark.parametrize(
    ("fields", "names"),
    [
        (BASIC, ["on_off"]),
        ({**BASIC, "brightness_command_topic": "b"}, ["on_off", "level"]),
        ({**BASIC, "color_temp_command_topic": "b"}, ["on_off", "level", "color_temperature"]),
        ({**BASIC, "effect_command_topic": "b"}, ["on_off", "effect"]),
        ({**BASIC, "schema": "JSON"}, ["on_off"]),
        ({**BASIC, "schema": "json", "supported_color_modes": ["hs", "white"]}, ["on_off", "level", "color"]),
        ({**BASIC, "schema": "json", "color_temp": True}, ["on_off", "level", "color_temperature"]),
        ({**BASIC, "schema": "json", "rgb": True, "brightness": True}, ["on_off", "level", "color"]),
        (TEMPLATE, ["on_off"]),
        ({**TEMPLATE, "effect_list": "x"}, ["on_off", "effect"]),
    ],
)
def test_a_lamp_without_state_topic_is_optimistic(fields: Mapping[str, object], names: list[str]) -> None:
    capabilities = lamp(fields).part.capabilities
    assert [one.name for one in capabilities] == names
    assert not any(one.readable for one in capabilities)


@pytest.mark.parametrize(
    ("capability", "value", "transition", "expected"),
    [
        ("on_off", True, 0.0, b'{"state":"ON"}'),
        ("on_off", False, 2.5, b'{"state":"OFF","transition":2.5}'),
        ("level", 40.0, 0.0, b'{"state":"ON","brightness":102}'),
        ("level", 0.4, 0.0, b'{"state":"ON","brightness":1}'),
        ("level", 0.0, 1.0, b'{"state":"OFF","transition":1.0}'),
        ("color_temperature", 2700.0, 0.0, b'{"state":"ON","color_temp":370}'),
        ("color", (0.0, 100.0), 0.0, b'{"state":"ON","color":{"x":0.701,"y":0.299}}'),
        ("effect", "blink", 0.0, b'{"state":"ON","effect":"blink"}'),
    ],
)
def test_a_json_lamp_is_told_in_one_object(
    capability: str, value: PlainValue, transition: float, expected: bytes
) -> None:
    assert payload(lamp(JSON), capability, value, transition) == expected


@pytest.mark.parametrize(
    ("capability", "value"),
    [
        ("level", 101.0),
        ("level", -0.1),
        ("level", float("nan")),
        ("level", True),
        ("level", "50"),
        ("color_temperature", 0.0),
        ("color", (0.0,)),
        ("color", (361.0, 0.0)),
        ("color", (float("nan"), 0.0)),
        ("color", 3.0),
        ("effect", "explode"),
        ("effect", 1.0),
        ("on_off", None),
        ("position", 1.0),
    ],
)
def test_what_a_lamp_cannot_be_is_refused(capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        lamp(JSON).codec.write(capability, value)


@pytest.mark.parametrize("transition", [-1.0, 1e9, float("nan"), float("inf")])
def test_a_transition_without_end_is_refused(transition: float) -> None:
    with pytest.raises(RefusedError, match="transition"):
        lamp(JSON).codec.write("on_off", value=True, transition=transition)


def test_a_lamp_that_lists_no_effects_plays_any() -> None:
    part = lamp({**JSON, "effect_list": None})
    assert payload(part, "effect", "sparkle") == b'{"state":"ON","effect":"sparkle"}'
    with pytest.raises(RefusedError):
        part.codec.write("effect", value=True)


@pytest.mark.parametrize(
    ("said", "readings"),
    [
        (b'{"state":"ON","brightness":127}', {"on_off": True, "level": 50.0}),
        (b'{"state":null,"brightness":null}', {"on_off": None}),
        (b'{"brightness":0}', {}),
        (b'{"state":"off","brightness":"127","effect":3}', {}),
        (b'{"state":["ON"],"color_mode":["xy"],"color":3}', {}),
        (b'{"color_mode":"color_temp","color_temp":250}', {"color_temperature": 4000.0, "color": None}),
        (b'{"color_mode":"color_temp","color_temp":0}', {}),
        (b'{"color_mode":"xy","color":{"x":0.701,"y":0.299}}', {"color": (0.0, 100.0), "color_temperature": None}),
        (b'{"color_mode":"xy","color":{"x":7,"y":0.3}}', {}),
        (b'{"color_mode":"xy","color":[0.3,0.3]}', {}),
        (b'{"color_mode":"rgb","color":{"r":1,"g":2,"b":3}}', {}),
        (b'{"color":{"x":0.3,"y":0.3},"color_temp":250}', {}),
        (b'{"color":{"x":0.701,"y":0.299}}', {"color": (0.0, 100.0), "color_temperature": None}),
        (b'{"color_temp":250}', {"color_temperature": 4000.0, "color": None}),
        (b'{"color":{"h":1,"s":2}}', {}),
        (b'{"color_mode":null,"color_temp":250}', {}),
        (b'{"effect":"any\\u0007thing"}', {"effect": "any thing"}),
        (b"ON", {}),
        (b"[]", {}),
    ],
)
def test_a_json_lamp_is_read_field_by_field(said: bytes, readings: Mapping[str, object]) -> None:
    found = lamp(JSON).codec.read("z/lamp", said, retained=False)
    assert found.keys() == readings.keys()
    for name, value in readings.items():
        approximate = pytest.approx(value, abs=0.3) if isinstance(value, (float, tuple)) and value else value
        assert found[name] == approximate


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({}, "command_topic"),
        ({**BASIC, "schema": "yaml"}, "schema"),
        ({**BASIC, "on_command_type": "middle"}, "on_command_type"),
        ({**BASIC, "brightness_scale": 0}, "brightness_scale"),
        ({**BASIC, "min_mireds": -1}, "min_mireds"),
        ({**BASIC, "schema": "template", "command_on_template": "on"}, "command_off_template"),
        ({**JSON, "supported_color_modes": ["brightness", "rgb"]}, "supported_color_modes"),
        ({**JSON, "supported_color_modes": ["white"]}, "supported_color_modes"),
        ({**JSON, "supported_color_modes": ["ultraviolet"]}, "supported_color_modes"),
        ({**JSON, "supported_color_modes": {}}, "supported_color_modes"),
    ],
)
def test_a_lamp_that_cannot_be_is_refused(fields: Mapping[str, object], problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        lamp(fields)


def test_a_template_that_is_not_supported_costs_one_capability() -> None:
    fields = {**BASIC, "state_topic": "a", "brightness_command_topic": "b", "brightness_state_topic": "b"}
    part = lamp({**fields, "brightness_value_template": "{{ states('sensor.x') }}"})
    assert [(one.name, one.readable) for one in part.part.capabilities] == [
        ("raw", True),
        ("on_off", True),
        ("level", False),
    ]
    assert part.codec.read("b", b"77", retained=False) == {"raw": "77"}


def test_a_plain_dimmer_is_turned_on_as_bright_as_it_last_was() -> None:
    part = lamp(
        {**BASIC, "brightness_command_topic": "b", "brightness_state_topic": "s", "on_command_type": "brightness"}
    )
    assert payload(part, "on_off", value=True) == b"255"
    part.codec.read("s", b"77", retained=False)
    assert payload(part, "on_off", value=True) == b"77"


@pytest.mark.parametrize("said", [b"1e308", b"1e-320", b"-1e308", b"9" * 40])
def test_numbers_beyond_all_lamps_are_survived(said: bytes) -> None:
    topics = ("brightness", "color_temp", "rgb")
    fields = {f"{one}_{way}_topic": "a" for one in topics for way in ("command", "state")}
    for scale in (1, 2**50):
        found = lamp({**BASIC, **fields, "brightness_scale": scale}).codec.read("a", said, retained=False)
        level = found.get("level", 1.0)
        assert isinstance(level, float)
        assert 0 <= level <= 100
        assert "color_temperature" not in found


MODES = {
    **BASIC,
    "rgb_command_topic": "a/rgb/set",
    "rgb_state_topic": "a/rgb",
    "color_temp_command_topic": "a/ct/set",
    "color_temp_state_topic": "a/ct",
    "color_mode_state_topic": "a/mode",
    "brightness_command_topic": "a/b/set",
    "brightness_state_topic": "a/b",
}
RED = (0.0, 100.0)


@pytest.mark.parametrize("order", list(permutations(["a/rgb 255,0,0", "a/ct 250", "a/mode rgb"])))
def test_the_colour_mode_says_what_a_lamp_shows_in_whatever_order_it_comes(order: tuple[str, ...]) -> None:
    codec = lamp(MODES).codec
    known: dict[str, PlainValue] = {}
    for message in order:
        topic, said = message.split()
        known.update(codec.read(topic, said.encode(), retained=True))
    assert known == {"color": RED, "color_temperature": None}
    assert codec.read("a/mode", b"color_temp", retained=False) == {"color_temperature": 4000.0, "color": None}
    assert codec.read("a/rgb", b"0,255,0", retained=False) == {}
    assert codec.read("a/mode", b"ultraviolet", retained=False) == {}
    assert codec.read("a/mode", b"rgb", retained=False) == {"color": (120.0, 100.0), "color_temperature": None}


def test_a_lamp_whose_topics_say_no_mode_shows_what_came_last() -> None:
    codec = lamp({key: value for key, value in MODES.items() if key != "color_mode_state_topic"}).codec
    assert codec.read("a/rgb", b"255,0,0", retained=False) == {"color": RED, "color_temperature": None}
    assert codec.read("a/ct", b"250", retained=False) == {"color_temperature": 4000.0, "color": None}


def test_effects_without_a_list_are_read_and_told() -> None:
    part = lamp({**BASIC, "effect_command_topic": "a/e/set", "effect_state_topic": "a/e"})
    assert part.codec.read("a/e", b"sparkle", retained=False) == {"effect": "sparkle"}
    assert ("a/e/set", b"party") in [(one.topic, one.payload) for one in part.codec.write("effect", "party")]


def test_a_json_lamp_of_before_there_were_lists_flags_its_modes() -> None:
    flags = {"schema": "json", "brightness": True, "color_temp": True, "rgb": True, "xy": False}
    part = lamp({**BASIC, **flags, "state_topic": "a"})
    assert payload(part, "color", (120.0, 100.0)) == b'{"state":"ON","color":{"r":0,"g":255,"b":0}}'
    assert payload(part, "color_temperature", 4000.0) == b'{"state":"ON","color_temp":250}'
    message = b'{"state":"ON","brightness":255,"color":{"r":255,"g":0,"b":0}}'
    reported = {"on_off": True, "level": 100.0, "color": (0.0, 100.0), "color_temperature": None}
    assert dict(part.codec.read("a", message, retained=False)) == reported


def test_a_basic_lamp_may_call_the_template_of_its_state_as_other_parts_do() -> None:
    fields = {**BASIC, "state_topic": "a/STATE", "value_template": "{{ value_json.POWER }}"}
    assert dict(lamp(fields).codec.read("a/STATE", b'{"POWER":"ON","Dimmer":30}', retained=False)) == {"on_off": True}
