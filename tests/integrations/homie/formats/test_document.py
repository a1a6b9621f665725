import json

import pytest

from homebot.errors import WireError
from homebot.integrations.homie.formats.model import HomieDevice, Range
from homebot.integrations.homie.formats.reader import parse_document

GOOD = {"datatype": "integer", "format": "0:100:5", "unit": "%", "settable": True, "retained": False, "name": "Dim"}


def parse(**fields: object) -> HomieDevice:
    return parse_document("homie", "x", json.dumps({"homie": "5.0", "version": 1, **fields}).encode())


def test_a_property_is_read_in_full() -> None:
    document = parse(name="Thing", nodes={"a": {"name": "A", "properties": {"b": GOOD}}})
    assert document.name == "Thing"
    assert document.ignored == 0
    (node,) = document.nodes
    (prop,) = node.properties
    assert (prop.id, prop.name, prop.topic, prop.unit) == ("b", "Dim", "homie/5/x/a/b", "%")
    assert prop.range == Range(0, 100, 5)
    assert prop.is_settable
    assert not prop.is_retained


def test_a_field_of_another_type_is_named_with_what_it_should_be() -> None:
    with pytest.raises(WireError, match="version is 'x', not a whole number"):
        parse(version="x")


def test_unknown_fields_are_passed_over() -> None:
    document = parse(future={"a": 1}, nodes={"a": {"future": 1, "properties": {"b": {**GOOD, "future": []}}}})
    assert len(document.nodes[0].properties) == 1


@pytest.mark.parametrize(
    "bad",
    [
        {"datatype": "number"},
        {"datatype": None},
        {},
        [],
        {**GOOD, "format": "100:0"},
        {**GOOD, "format": "a:b"},
        {**GOOD, "format": "1:2:3:4"},
        {**GOOD, "format": "0:1:-1"},
        {**GOOD, "format": 5},
        {**GOOD, "settable": "true"},
        {**GOOD, "retained": 1},
        {**GOOD, "unit": 1},
        {"datatype": "enum"},
        {"datatype": "enum", "format": "a,,b"},
        {"datatype": "enum", "format": "a,a"},
        {"datatype": "color", "format": "rgb,cmyk"},
        {"datatype": "color"},
        {"datatype": "boolean", "format": "on"},
    ],
)
def test_an_illegal_property_is_ignored_and_counted(bad: object) -> None:
    document = parse(nodes={"a": {"properties": {"bad": bad, "good": GOOD}}})
    assert [prop.id for prop in document.nodes[0].properties] == ["good"]
    assert document.ignored == 1


@pytest.mark.parametrize("bad", [[], {"name": 1}, {"type": []}, {"properties": []}])
def test_an_illegal_node_is_ignored_and_counted(bad: object) -> None:
    document = parse(nodes={"bad": bad, "good": {}})
    assert [node.id for node in document.nodes] == ["good"]
    assert document.ignored == 1


@pytest.mark.parametrize("name", ["A", "a_b", "", "ä", "a/b"])
def test_an_id_that_is_none_is_ignored(name: str) -> None:
    assert parse(nodes={name: {}}).nodes == ()
    assert parse(nodes={"a": {"properties": {name: GOOD}}}).nodes[0].properties == ()


@pytest.mark.parametrize(
    "fields",
    [
        {"homie": "4.0.0"},
        {"homie": 5},
        {"version": "1"},
        {"version": True},
        {"name": 1},
        {"nodes": []},
        {"children": "a"},
        {"root": "A"},
        {"parent": 1},
        {"type": 1},
    ],
)
def test_a_device_with_an_illegal_field_is_refused(fields: dict[str, object]) -> None:
    with pytest.raises(WireError):
        parse(**fields)


def test_a_thousand_properties_are_too_many() -> None:
    document = parse(nodes={"a": {"properties": {f"p{number}": GOOD for number in range(1000)}}})
    assert len(document.nodes[0].properties) == 500
    assert document.ignored == 500
