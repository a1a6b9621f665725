"""Values in the words of outcomes and notes."""

import pytest

from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import fits, value_text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (89 / 2.55, "34.9"),
        (21.25, "21.25"),
        (2702.7027, "2702.7"),
        (100.0, "100"),
        ((240.0, 33.333333), "240, 33.33"),
        (True, "on"),
        (False, "off"),
        (None, "unknown"),
        ("o" * 50, "o" * 40),
    ],
)
def test_a_value_is_told_as_people_say_it(value: PlainValue, text: str) -> None:
    assert value_text(value) == text


@pytest.mark.parametrize(
    ("wanted", "seen", "is_same"),
    [
        ("07:00", "07:00:00", True),
        ("07:00", "19:00:00", False),
        ("2021-02-03T04:05+02:00", "2021-02-03T02:05:00+00:00", True),
        ("2021-02-03T04:05", "2021-02-03T04:05:00+00:00", False),
        ("hello", "hello", True),
        ("hello", "07:00", False),
        ("10", "1000", False),
        ("1000", "10:00", False),
        ("2021-02-03", "20210203", False),
    ],
)
def test_a_moment_in_another_form_is_the_same(wanted: str, seen: str, *, is_same: bool) -> None:
    assert fits("text", wanted, seen) is is_same
