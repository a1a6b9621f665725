"""Numbers in what outsiders say."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.support.numbers import finite_number, to_number


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
        (b"21.5", 21.5),
        (" -7 ", -7.0),
        (b"\xff", None),
        (b"1_0", None),
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


@given(st.one_of(st.text(), st.binary(), st.integers(), st.floats(), st.booleans(), st.none(), st.lists(st.integers())))
def test_whatever_it_is_a_number_or_none_comes_of_it(value: object) -> None:
    found = to_number(value)
    assert found is None or (math.isfinite(found) and not isinstance(value, bool))


@given(st.floats(-1e18, 1e18))
def test_what_python_spells_is_read_again(number: float) -> None:
    assert to_number(repr(number)) == to_number(repr(number).encode()) == finite_number(number) == number
