"""YAML: values as people type them, and as messages are printed."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.cli.yaml import message, parse_flow, to_yaml, type_or_message
from homebot.errors import WireError


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("{data: hi}", {"data": "hi"}),
        ("{data: hi there}", {"data": "hi there"}),
        ('{"data": "hi"}', {"data": "hi"}),
        ("{data: 'it''s on'}", {"data": "it's on"}),
        ('{data: "a\\nb"}', {"data": "a\nb"}),
        ("{a: 1, b: -2.5, c: 1e3, d: true, e: null}", {"a": 1, "b": -2.5, "c": 1000.0, "d": True, "e": None}),
        ("{a: [1, x, {b: 2}], c: {}}", {"a": [1, "x", {"b": 2}], "c": {}}),
        ("{url: mqtt://host:1883}", {"url": "mqtt://host:1883"}),
        ("{on: off}", {"on": "off"}),
        ("{'a b': 1}", {"a b": 1}),
        (
            "{yes: on, time: 12:30, day: 2026-11-26, octal: 010, none: }",
            {"yes": "on", "time": "12:30", "day": "2026-11-26", "octal": 10, "none": None},
        ),
        ("{1: one}", {"1": "one"}),
        ("{}", {}),
        ("[]", []),
        ("hello", "hello"),
        ("{address: home/lights/lamp1/in, payload: off}", {"address": "home/lights/lamp1/in", "payload": "off"}),
    ],
)
def test_a_value_is_read(text: str, value: object) -> None:
    assert parse_flow(text) == value


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("data: 5", {"data": 5}),
        ("data: hi there", {"data": "hi there"}),
        ("linear: {x: 1.0}, angular: {}", {"linear": {"x": 1.0}, "angular": {}}),
    ],
)
def test_fields_need_no_braces_around_them_as_for_ros2(text: str, fields: object) -> None:
    assert message(text) == fields
    assert type_or_message(text) == fields


def test_not_a_number_is_a_number() -> None:
    value = parse_flow("{a: .nan}")
    assert isinstance(value, dict)
    assert isinstance(value["a"], float)
    assert math.isnan(value["a"])


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "a value was expected"),
        ("{data", "column 6: expected ',' or '}'"),
        ("{data: 1", "column 9: expected ',' or '}'"),
        ("{a: 1 b: 2}", "column 8: expected ',' or '}', but got ':'"),
        ("{a: 'b}", "column 8: found unexpected end of stream"),
        ("[1, 2", "column 6: expected ',' or ']'"),
        ("{a: 1} x", "column 8: expected '<document start>'"),
        ('{"a": 1, "a": 2}', "the field 'a' occurs twice"),
        ("{a: 1, a: 2}", "column 8: the field 'a' occurs twice"),
        ("[" * 200, "column 201: expected the node content"),
        ("[" * 20_000, "recursion"),
        ("[&a 1, *a]", "column 8: it has an alias (*NAME): write the value itself there"),
        ("!!python/object:os.system x", "could not determine a constructor"),
        ("{[1]: 2}", "expected a scalar node"),
    ],
)
def test_a_bad_value_says_where_it_went_wrong(text: str, problem: str) -> None:
    with pytest.raises(WireError) as caught:
        parse_flow(text)
    assert problem in str(caught.value)


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(), st.lists, max_leaves=5))
def test_json_means_what_it_means_in_json(value: object) -> None:
    assert parse_flow(json.dumps(value)) == value


@given(st.text(alphabet="{}[],:'\" \\ab1.-+~\n"))
def test_any_text_is_a_value_or_an_error(text: str) -> None:
    try:
        parse_flow(text)
    except WireError as exc:
        problem = str(exc)
    else:
        problem = "cannot read"
    assert "cannot read" in problem


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ({"data": "hi"}, "data: hi\n"),
        ({"data": ""}, 'data: ""\n'),
        ({"data": "off"}, 'data: "off"\n'),
        ({"data": "1"}, 'data: "1"\n'),
        ({"data": "a: b"}, 'data: "a: b"\n'),
        ({"data": "Küche"}, 'data: "Küche"\n'),
        ({"data": "\x1b[31m"}, 'data: "\\u001b[31m"\n'),
        ({"a": 1, "b": 2.5, "c": True, "d": None}, "a: 1\nb: 2.5\nc: true\nd: null\n"),
        ({"a": math.nan, "b": -math.inf}, "a: .nan\nb: -.inf\n"),
        ({"a": [], "b": {}}, "a: []\nb: {}\n"),
        ({"a": [1, 2]}, "a: [1, 2]\n"),
        ({"a": ["x", "y"]}, 'a:\n  - x\n  - "y"\n'),
        ({"a": {"b": {"c": 1}}}, "a:\n  b:\n    c: 1\n"),
        ({"a": [{"b": 1, "c": [1]}, {"b": 2, "c": []}]}, "a:\n  - b: 1\n    c: [1]\n  - b: 2\n    c: []\n"),
        ("hi", "hi\n"),
        ([1, 2], "[1, 2]\n"),
        ({}, "{}\n"),
    ],
)
def test_a_value_is_printed(value: object, text: str) -> None:
    assert to_yaml(value) == text
