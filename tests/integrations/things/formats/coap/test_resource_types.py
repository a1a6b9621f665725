"""Devices without a description: what their links say."""

import pytest

from homebot.conventions.coap.link_format import parse_links
from homebot.integrations.things.coap_session import COAP_BINDING
from homebot.integrations.things.formats.binding import ClassifiedPart
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.payload import decode_document, encode_document
from homebot.integrations.things.formats.resource_types import MAX_RESOURCES, thing_of_links
from homebot.integrations.things.formats.thing import Thing


def thing(text: str) -> Thing:
    links = parse_links(text.encode())
    return thing_of_links(links, {one.target: f"coap://h{one.target}" for one in links}, "Hall")


def kinds(parts: tuple[ClassifiedPart, ...]) -> dict[str, list[tuple[str, bool]]]:
    return {one.part.service_type: [(each.name, each.settable) for each in one.part.capabilities] for one in parts}


@pytest.mark.parametrize(
    ("links", "expected"),
    [
        ("</3311/0/5850>,</3311/0/5851>", {"light": [("on_off", True), ("level", True)]}),
        ("</3303/0/5700>;obs", {"temperature_sensor": [("temperature", False)]}),
        (
            '</>;rt="oma.lwm2m";ct=11542,</1/0>;ver=1.1,</3/0>,</3303>;ver=1.1,</3303/0>,</3311/0>',
            {"light": [("on_off", True)], "temperature_sensor": [("temperature", False)]},
        ),
        ("</3311/0>,</3311/0/5851>", {"light": [("level", True)]}),
        ("</3201/0>,</3200/0>", {"switch": [("on_off", True)], "x_binary_sensor": [("state", False)]}),
        ("</3305/0/5800>", {"electrical_meter": [("power", False)]}),
        (
            "</3311/0/5850>,</3331/0>,</3337/0>",
            {"light": [("on_off", True)], "electrical_meter": [("energy", False)], "x_setting": [("number", True)]},
        ),
        ("</3315/0>", {"x_sensor": [("measurement", False)]}),
        ("</3310/0>,</3303>", {}),
        ('</time>;obs;rt="ticktock";title="Clock"', {"x_sensor": [("value", False)]}),
        ("</storage>,</.well-known/core>", {}),
        ("</3303/0/5700>;ct=30000", {}),
        ('</hall>;if="core.s"', {"x_sensor": [("value", False)]}),
        ('</3306/0/5850>;if="core.s"', {"switch": [("on_off", False)]}),
    ],
)
def test_known_resources_are_capabilities(links: str, expected: dict[str, list[tuple[str, bool]]]) -> None:
    assert kinds(parts_of(thing(links), COAP_BINDING)) == expected


def test_each_lamp_has_its_own_brightness_and_no_relay_is_its_switch() -> None:
    """The relay has the lower number, and was what `turn off` switched."""
    links = "</3306/0/5850>,</3311/0/5851>,</3311/1/5850>,</3311/1/5851>,</3312/0>"
    assert [
        (one.part.id, one.part.service_type, [each.affordance.forms[0].href for each in one.affordances])
        for one in parts_of(thing(links), COAP_BINDING)
    ] == [
        ("3306/0", "switch", ["coap://h/3306/0/5850"]),
        ("", "light", ["coap://h/3311/0/5851"]),
        ("3311/1", "light", ["coap://h/3311/1/5850", "coap://h/3311/1/5851"]),
        ("3312/0", "switch", ["coap://h/3312/0/5850"]),
    ]


def test_values_are_read_and_written_as_the_resource_has_them() -> None:
    (lamp,) = parts_of(thing("</3311/0/5850>"), COAP_BINDING)
    (switch,) = lamp.affordances
    assert decode_document(switch.capability, switch.affordance, 1) == (True,)
    assert encode_document(switch.capability, switch.affordance, True) == "1"


def test_the_resources_of_one_device_are_limited() -> None:
    many = ",".join(f"</3303/{number}/5700>" for number in range(500))
    assert len(thing(many).affordances) == MAX_RESOURCES
