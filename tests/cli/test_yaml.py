"""Messages as YAML."""

from __future__ import annotations

import math

import pytest

from homebot.cli.yaml import to_yaml


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
