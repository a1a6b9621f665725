"""Values in the words of outcomes and notes."""

import pytest

from homebot.control.values import value_text
from homebot.devices.value import PlainValue


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
