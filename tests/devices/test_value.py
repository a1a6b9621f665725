"""A value of a capability as a message."""

import math

import pytest

from homebot.devices.value import PlainValue, Value


@pytest.mark.parametrize("plain", [None, True, False, 1.0, 0.0, -0.5, 1e300, math.inf, "on", "", (1.0, 2.0), ()])
def test_a_value_comes_back_as_it_was(plain: PlainValue) -> None:
    """The type as well: 1.0 is no true."""
    for value in (Value.of(plain), Value.model_validate(plain)):
        back = value.plain()
        assert (back, type(back)) == (plain, type(plain))


def test_a_number_is_always_a_float() -> None:
    assert type(Value.of(1).plain()) is float


def test_there_is_no_negative_zero() -> None:
    """It equals zero and would be shown as -0."""
    assert math.copysign(1.0, Value.of(-0.0).number) == 1.0
    assert Value.of(-0.0) is Value.of(0.0)


def test_a_number_that_is_none_stays_one() -> None:
    assert math.isnan(Value.of(math.nan).number)


def test_a_number_has_no_error_of_its_calculation() -> None:
    """A lamp that counts to 1 has 0.55, which is 55 % and not 55.00000000000001 %."""
    for percent in range(101):
        assert Value.of(percent / 100 * 100).plain() == float(percent)
        assert Value.of((percent / 100 * 100, 0.1 + 0.2)).plain() == (float(percent), 0.3)


@pytest.mark.parametrize("number", [1 / 3, 1_700_000_000.123, 123_456_789_012.345, 9_007_199_254_740_993.0, 1.8e308])
def test_a_number_of_a_device_keeps_its_digits(number: float) -> None:
    assert Value.of(number).plain() == pytest.approx(number, rel=1e-15, abs=0)
