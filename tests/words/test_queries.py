"""Text queries: what each form means, and what is said where it means nothing."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.query.terms import (
    And,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    IsNear,
    IsUnapproved,
    NameIs,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    type_is,
)
from homebot.errors import UsageError
from homebot.words.queries import parse_query
from homebot.words.tokens import quoted

LIGHT = frozenset({"light"})
ON_LIGHT = StateIs("on_off", "=", True, LIGHT)

WEAK = Or((StateIs("battery", "<", 20.0), StateIs("battery_low", "=", True)))

UNDERSTOOD: dict[str, Query] = {
    "": And(()),
    "all devices": And(()),
    "light": type_is("light"),
    "the Lamps": type_is("lamps"),
    "light and dimmable in kitchen": And((type_is("light"), CanDo("level", settable=True), InArea("kitchen"))),
    "on lights": And((ON_LIGHT, type_is("lights"))),
    "heating in living": And((type_is("heating"), InArea("living"))),
    "heating thermostats": And(
        (StateIs("thermostat_action", "=", "heating", frozenset({"thermostat"})), type_is("thermostats"))
    ),
    "lights not on": And((type_is("lights"), Not(ON_LIGHT))),
    "sensor with temperature not stale": And((type_is("sensor"), CanDo("temperature"), Not(FreshnessIs("stale")))),
    "lamps in living room on": And((type_is("lamps"), InArea("living room"), ON_LIGHT)),
    'in "on the roof"': InArea("on the roof"),
    "light or plug, fresh": Or((type_is("light"), And((type_is("plug"), FreshnessIs("fresh"))))),
    "(light or plug) fresh": And((Or((type_is("light"), type_is("plug"))), FreshnessIs("fresh"))),
    "without battery": Not(CanDo("battery")),
    "level>50": StateIs("level", ">", 50.0),
    "brightness >= 50 %": StateIs("level", ">=", 50.0),
    "temperature below 18.5 °C": StateIs("temperature", "<", 18.5),
    "temperature Above 18": StateIs("temperature", ">", 18.0),
    "temperature Above 18 Degrees": StateIs("temperature", ">", 18.0),
    "battery is below 20": StateIs("battery", "<", 20.0),
    "temperature < 18.5 °C": StateIs("temperature", "<", 18.5),
    "temperature < 18.5C": StateIs("temperature", "<", 18.5),
    "level≠0": StateIs("level", "!=", 0.0),
    "on_off=true": StateIs("on_off", "=", True),
    "contact: open": StateIs("contact", "=", True),
    "movement=Opening": StateIs("movement", "=", "opening"),
    "gateway=mqtt": GatewayIs("mqtt"),
    "area=küche": InArea("kuche"),
    'model="E27 Bulb"': FactIs("model", "e27 bulb"),
    "via_device != bridge": Not(FactIs("via_device", "bridge")),
    "freshness=unconfirmed": FreshnessIs("unconfirmed"),
    "offline": ReachableIs("no"),
    "not disputed": Not(IsDisputed()),
    "low battery": WEAK,
    "lights with low battery": And((type_is("lights"), WEAK)),
    "unapproved in hall": And((IsUnapproved(), InArea("hall"))),
    "category=Config": FactIs("category", "config"),
    "reachable=unknown": ReachableIs("unknown"),
    "can=level": CanDo("level", settable=True),
    "has=level": CanDo("level"),
    "peter's!": And((HasText("peter"), HasText("s"))),
    "roomlights405": HasText("roomlights405"),
    '"desk lamp"': And((HasText("desk"), HasText("lamp"))),
    "color temperature": CanDo("color_temperature"),
    '"near" lamp': And((HasText("near"), type_is("lamp"))),
    '"Zone" = 3': FactIs("zone", "3"),
    'type="lamppp"': type_is("lamppp"),
    "type=coffee": type_is("coffee"),
    "off light near robot": And((StateIs("on_off", "=", False, LIGHT), type_is("light"), IsNear("robot"))),
    "lamps within 5 m of robot": And((type_is("lamps"), IsNear("robot", 5.0))),
    "lamps in hall near the robot within 2.5m": And((type_is("lamps"), InArea("hall"), IsNear("robot", 2.5))),
    "(lamp or plug) near 'robot 2'": And((Or((type_is("lamp"), type_is("plug"))), IsNear("robot 2"))),
    "serial_number=A7": FactIs("serial_number", "a7"),
    'name="Hall lamp"': NameIs("hall lamp"),
    "name=hall": FactIs("name", "hall"),
    "lamps that are offline": And((type_is("lamps"), ReachableIs("no"))),
    "which lights are on": And((type_is("lights"), ON_LIGHT)),
    "that lamp": And((HasText("that"), type_is("lamp"))),
}


@pytest.mark.parametrize(("text", "meant"), UNDERSTOOD.items(), ids=UNDERSTOOD)
def test_each_form_is_parsed_to_its_terms(text: str, meant: Query) -> None:
    assert parse_query(text) == meant


REFUSED = {
    "light or": "a term is missing next to 'or' at character 7",
    "light and and plug": "a term is missing next to 'and' at character 11",
    "not": "a term is missing next to 'not'",
    "(light": "the bracket at character 1 is never closed",
    "light)": "')' at character 6",
    "in and light": "'in' at character 1 is not followed by an area",
    "brightnes>3": "brightnes is not a capability; did you mean brightness?",
    "with temperatur": "did you mean temperature",
    "temperature > 70 °F": "temperature is a number in °C, not '70°F'",
    "temperature > 290K": "temperature is a number in °C, not '290K'",
    "power > 2 kWh": "power is a number in W, not '2kWh'",
    "power above 5 volt": "power is a number in W, not '5V'",
    "temperature below 18 kg": "temperature is a number in °C, not '18kg'",
    "with lamp": "it is a type of device: leave out the word before it",
    "on_off>3": "on_off is true or false, not '3'",
    "level=blue": "level is a number in %, not 'blue'",
    "lock=bolted": "lock is one of locked, unlocked",
    "movement>open": "movement is not a number; compare it with = or !=",
    "color=red": "cannot be compared; ask for `with color`",
    "gateway>mqtt": "gateway cannot be ordered",
    "level>": "'level >' is not followed by a value",
    "> 5": "has no name before it",
    '"lamp': "an unclosed quotation mark",
    "category=settings": "category is config or diagnostic, not 'settings'",
    "freshness=dead": "one of fresh, unconfirmed, stale",
    "press=single": "press is an event, and never a state of a device; ask for `with press`",
    "?!": "contains no search term",
    "xyzzy=bar": "'xyzzy' at character 1 is unknown; known are alias, area, brand",
    "lamp manufactuer=ikea": "'manufactuer' at character 6 is unknown; did you mean manufacturer",
    "lights but hall lamp": "'but' at character 8 is not followed by 'not' or 'without'",
    "!kettle": "'!kettle' at character 1 is not understood in a query; write 'not' before a term",
    "lamp -kettle": "'-kettle' at character 6 is not understood in a query; write 'not' before a term",
    "lights in hall or else kitchen": "'else' at character 19 is not understood in a query; write it in",
    "lights here": "'here' at character 8 is not understood in a query; write it in quotation marks",
    "lamps beside kitchen": "'beside' at character 7 is not understood in a query; write it in quotation marks",
    "lamps in kitchen under window": "'under' at character 18 is not understood",
    "lamp near": "'near' at character 6 is not followed by a robot",
    "lamp near and on": "'near' at character 6 is not followed by a robot",
    "lamp within robot": "'within' at character 6 is not followed by metres, such as '5 m'",
    "lamp within 5 m in hall": "'within' at character 6 is not followed by metres 'of' a robot",
    "lamp near robot or plug": "'near' applies to a whole query, not to a part with 'or' or 'not'; write for",
    "lamp and (plug or not near robot)": "'near' applies to a whole query, not to a part with 'or'",
    "lamp not near robot": "'near' applies to a whole query, not to a part with 'or' or 'not'",
    "near a and near b": "the query has 'near' twice",
    "type=lamppp": "'lamppp' at character 6 is not a device type; did you mean lamp or lamps?",
    "type=lihgts": "is not a device type; did you mean lights",
    "(" * 30 + "light" + ")" * 30: "nested deeper than 20",
    "lamp " * 101: "more than 100 words",
    "x" * 1001: "1,000 is the limit",
}


@pytest.mark.parametrize(("text", "problem"), REFUSED.items(), ids=[text[:20] for text in REFUSED])
def test_an_unknown_part_of_a_query_is_named(text: str, problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_query(text)
    assert problem in str(caught.value)


@given(st.text(max_size=50))
def test_a_quoted_text_is_one_value(text: str) -> None:
    assert parse_query(f"id={quoted(text)} fresh") == And((FactIs("id", text.casefold()), FreshnessIs("fresh")))


def test_every_capability_can_be_asked_for_by_its_name() -> None:
    assert [parse_query(f"with {name}") for name in CAPABILITIES] == [CanDo(name) for name in CAPABILITIES]


@pytest.mark.parametrize(
    ("words", "capability"),
    [("carbon dioxide", "carbon_dioxide"), ("colour temperature", "color_temperature"), ("co2", "carbon_dioxide")],
)
def test_a_capability_is_compared_by_all_its_words(words: str, capability: str) -> None:
    wanted = StateIs(capability, ">", 400.0)
    assert parse_query(f"{words} > 400") == wanted
    assert parse_query(f"not {words} > 400") == parse_query(f"without {words} > 400") == Not(wanted)
    assert parse_query(f"devices with {words} > 400") == wanted
    assert parse_query(f"{words} > 400 in hall") == And((wanted, InArea("hall")))


def test_a_repeated_query_is_parsed_once() -> None:
    """Apps ask the same at every event; what is wrong is refused each time."""
    assert parse_query("on lights in kitchen") is parse_query("on lights in kitchen")
    for _ in range(2):
        with pytest.raises(UsageError):
            parse_query("(light")
