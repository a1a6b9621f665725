"""Calculations with values in braces."""

import re

import pytest

from homebot.errors import UsageError
from homebot.words.calculations import calculated, operands_of, read_calculation, with_operands
from homebot.words.conditions import read_condition
from homebot.words.message_values import Comparison, read_value
from homebot.words.steps import Do, Wait, read_step

VALUES = {"a": 2.0, "b of c": 5.0, "name='x - y'": 8.0, "d": None}


@pytest.mark.parametrize(
    ("text", "result"),
    [
        ("a + 3 * 2", 8.0),
        ("(a + 3) * 2", 10.0),
        ("a - 3 - 4", -5.0),
        ("8 / a / 2", 2.0),
        ("b of c - -1", 6.0),
        ("name='x - y' / 2", 4.0),
        ("min(max(a, 3), b of c, 100)", 3.0),
        ("round(b of c / 3, 2)", 1.67),
        ("round(2.5) + int(-2.9) + abs(-1)", 1.0),
        ("default(d, 20) + default(a, 20)", 22.0),
        ("d + 1", None),
        ("a / (a - 2)", None),
        ("((((a))))", 2.0),
        ("-4.5", -4.5),
    ],
)
def test_values_and_numbers_are_calculated_as_in_arithmetic(text: str, result: float | None) -> None:
    """Nothing comes of an unknown value without a default, or of a division by zero."""
    term = read_calculation(text)
    assert {*operands_of(term)} <= VALUES.keys()
    assert calculated(term, VALUES.__getitem__) == result


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("round(a", "a bracket is not closed"),
        ("min(a)", "min() has 1 parts; write 'min(a, 100)'"),
        ("(a + 1) b", "'b' is too much"),
        ("(" * 30 + "a" + ")" * 30, "brackets too deep"),
    ],
)
def test_what_is_no_calculation_is_refused_with_what_to_write(text: str, problem: str) -> None:
    with pytest.raises(UsageError, match=re.escape(problem)):
        read_calculation(text)


def test_values_alone_change_with_the_language() -> None:
    assert with_operands("round((a of b - 3) * c, 1)", str.upper) == "round((A OF B - 3) * C, 1)"


@pytest.mark.parametrize("text", ["name of door * 2", "temperature of office + 3 + time", "names of open windows / 2"])
def test_a_name_or_time_is_no_number(text: str) -> None:
    with pytest.raises(UsageError, match="is no number"):
        read_value(text)


@pytest.mark.parametrize("text", ["hall lamp {round(sun elevation * 2 + 10)} %", "wait {count of open windows * 2}m"])
def test_a_step_takes_what_is_calculated_or_counted(text: str) -> None:
    step = read_step(text)
    assert isinstance(step, Do | Wait)
    assert [piece.kind for piece in step.pieces if not isinstance(piece, str)] == ["calculated"]


@pytest.mark.parametrize("text", ["{count of light on} above 2", "{(power of washer - 5) / 2} is under -3"])
def test_a_condition_compares_what_is_calculated_with_a_limit(text: str) -> None:
    condition = read_condition(text)
    assert isinstance(condition, Comparison)
    assert condition.first.is_number


def test_a_condition_compares_no_name_with_a_limit() -> None:
    with pytest.raises(UsageError, match="count of light on"):
        read_condition("{name of door} above 2")
