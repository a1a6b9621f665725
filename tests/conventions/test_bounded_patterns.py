"""Regular expressions of strangers: who is held to them, and which are left to the device."""

import pytest

from homebot.conventions.bounded_patterns import require_match
from homebot.errors import RefusedError


def test_a_text_that_does_not_match_is_refused_in_words() -> None:
    require_match("ab12", "[a-z]+[0-9]*$")
    with pytest.raises(RefusedError, match="it takes a text that matches"):
        require_match("12", "[a-z]+$")


@pytest.mark.parametrize(
    "pattern", [None, 3, "(", "(a+)+$", r"(a)\1", "(?=a)b", "a*" * 12, "x" * 201, "[a-\\U00010000]"]
)
def test_a_pattern_that_is_none_or_may_take_long_is_left_to_the_device(pattern: object) -> None:
    require_match("c" * 60, pattern)
