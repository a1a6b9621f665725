"""Texts, JSON and numbers in what a device says."""

import pytest

from homebot.conventions.decode import finite_number, to_json, to_number, to_text


@pytest.mark.parametrize(
    ("value", "expected"),
    [(1, 1.0), (-2.5, -2.5), (True, None), ("1", None), (None, None), (10**400, None), (1e300, None), (2**63, 2.0**63)],
)
def test_a_number_is_one_that_devices_have(value: object, expected: float | None) -> None:
    assert finite_number(value) == expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (1, 1.0),
        ("21.5", 21.5),
        ("1e3", 1000.0),
        (True, None),
        (None, None),
        ([], None),
        ("", None),
        ("nan", None),
        ("inf", None),
        ("1_0", None),
        ("٣", None),
        (10**400, None),
        ("9" * 50, None),
    ],
)
def test_numbers_are_finite_and_spelled_plainly(value: object, expected: float | None) -> None:
    assert to_number(value) == expected


def test_what_is_no_text_or_json_is_none() -> None:
    assert to_text(b"\xff") is None
    assert to_text(b"x" * 300_000) is None
    assert to_json(b"NaN") is None
    assert to_json(b'{"a":1}') == {"a": 1}
