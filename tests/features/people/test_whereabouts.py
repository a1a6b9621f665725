"""Where a person is, by the signs of phones."""

import math

import pytest

from homebot.features.people.whereabouts import Sign, where_is


@pytest.mark.parametrize(
    ("kinds", "is_home"),
    [
        ([], None),
        (["home"], True),
        (["away"], False),
        (["unknown"], None),
        (["home", "away"], True),
        (["home", "unknown"], True),
        (["away", "unknown"], False),
        (["away", "silent"], False),
        (["unknown", "silent"], None),
        (["silent", "silent"], None),
    ],
)
def test_a_phone_at_home_decides_before_one_that_is_away_and_both_before_silence(
    kinds: list[Sign], *, is_home: bool | None
) -> None:
    assert where_is([(kind, 1000.0) for kind in kinds], 1060.0, 1200.0).is_home is is_home


def test_silence_is_unknown_for_its_time_and_then_away() -> None:
    signs: list[tuple[Sign, float]] = [("silent", 1000.0), ("silent", 1500.0)]
    assert where_is(signs, 2699.9, 1200.0) == (None, 2700.0)
    assert where_is(signs, 2700.0, 1200.0) == (False, math.inf)
